#!/usr/bin/env python3
"""Writes a furnished floor in IFC4: a model to measure what scans are planned among furniture.

usage: scripts/furnished_model.py {classroom,restaurant} OUT.ifc [--seed N] [--bare]

- classroom: a corridor, and a room of 9 x 7 m with windows, a door, 30 desks with their chairs, cupboards;
- restaurant: 600 m2 with a bar, a kitchen, toilets, columns, booths, and tables with round legs and chairs of many parts.

--bare leaves the furniture out. All lengths are metres, the same seed gives the same bytes, and nothing but Python is needed.
"""
import argparse
import math
import pathlib
import random
import sys

from office_model import DOOR_HEIGHT, HEIGHT, SLAB, Building

LEG, SILL, HEAD = 0.02, 0.9, 2.2


def leg(x, y, z0, z1, radius=LEG, sides=12):
    """A round leg as slices: boxes whose corners lie on a circle."""
    angles = [(k + 0.5) * math.pi / 2 / (sides // 4) for k in range(sides // 4)]
    return [(x - radius * math.cos(a), y - radius * math.sin(a), x + radius * math.cos(a), y + radius * math.sin(a), z0, z1)
            for a in angles]


def chair(x, y, side):
    """A chair whose seat has its middle at x, y and whose back is on a side: (1, 0), (-1, 0), (0, 1) or (0, -1)."""
    parts = [(x - 0.21, y - 0.21, x + 0.21, y + 0.21, 0.43, 0.46)]
    for dx in (-0.18, 0.18):
        for dy in (-0.18, 0.18):
            parts += leg(x + dx, y + dy, 0.0, 0.43)
    for k in range(5):
        across, along = 0.2 - 0.1 * k, 0.2
        at = (x + along * side[0] + across * side[1], y + along * side[1] + across * side[0])
        parts.append((at[0] - 0.015, at[1] - 0.015, at[0] + 0.015, at[1] + 0.015, 0.46, 0.9))
    return parts


def table(x, y, width, depth):
    top = [(x - width / 2, y - depth / 2, x + width / 2, y + depth / 2, 0.72, 0.75)]
    for dx in (-1, 1):
        for dy in (-1, 1):
            top += leg(x + dx * (width / 2 - 0.05), y + dy * (depth / 2 - 0.05), 0.0, 0.72)
    return top


class Floor:
    def __init__(self, key, bare):
        self.building, self.bare = Building(key), bare

    def slab(self, x0, y0, x1, y1):
        self.building.element("IFCSLAB", "Slab", [(x0, y0, x1, y1, -SLAB, 0.0)])

    def furniture(self, name, boxes):
        if not self.bare:
            self.building.element("IFCFURNITURE", name, boxes)

    def wall(self, name, along_x, fixed, span, thickness=0.2, doors=(), windows=()):
        """A straight wall; doors and windows are middles and widths along it. Windows have panes of their own."""
        low, high = span
        gaps = sorted([(m, w, "door") for m, w in doors] + [(m, w, "window") for m, w in windows])
        near, far = fixed - thickness / 2, fixed + thickness / 2

        def box(a, b, z0, z1, inset=0.0):
            n, f = near + inset, far - inset
            return (a, n, b, f, z0, z1) if along_x else (n, a, f, b, z0, z1)

        pieces, at = [], low
        for middle, width, kind in gaps:
            a, b = middle - width / 2, middle + width / 2
            pieces.append(box(at, a, 0.0, HEIGHT))
            if kind == "door":
                pieces.append(box(a, b, DOOR_HEIGHT, HEIGHT))
            else:
                pieces += [box(a, b, 0.0, SILL), box(a, b, HEAD, HEIGHT)]
                self.building.element("IFCWINDOW", f"{name} window", [box(a, b, SILL, HEAD, thickness / 2 - 0.03)])
            at = b
        pieces.append(box(at, high, 0.0, HEIGHT))
        self.building.element("IFCWALL", name, pieces)

    def space(self, name, x0, y0, x1, y1):
        building = self.building
        placement = building.file.add("IFCLOCALPLACEMENT", building.placement, building.axes)
        shape = building.body([(x0, y0, x1, y1, 0.0, HEIGHT)])
        space = building.root("IFCSPACE", name, "$", "$", placement, shape, "$", ".ELEMENT.", ".INTERNAL.", "$")
        building.root("IFCRELAGGREGATES", "", "$", building.storey, [space])


def classroom(seed, bare):
    draw, floor = random.Random(seed), Floor(f"classroom {seed}", bare)
    length, depth, corridor = 9.0, 7.0, 2.4
    floor.slab(-0.2, -0.2, length + 0.2, depth + corridor + 0.2)
    floor.wall("South", True, -0.1, (-0.2, length + 0.2), windows=[(1.8 + 2.7 * k, 1.8) for k in range(3)])
    floor.wall("West", False, -0.1, (0.0, depth + corridor))
    floor.wall("East", False, length + 0.1, (0.0, depth + corridor), doors=[(depth + corridor / 2, 1.2)])
    floor.wall("Corridor", True, depth + 0.05, (0.0, length), 0.1, doors=[(1.0, 1.0)])
    floor.wall("North", True, depth + corridor + 0.1, (-0.2, length + 0.2))
    floor.space("Classroom", 0.0, 0.0, length, depth)
    floor.space("Corridor", 0.0, depth + 0.1, length, depth + corridor)
    for row in range(6):
        for column in range(5):
            # Two, one and two in a row with two aisles; rows look to the west, where the board is.
            x = 2.3 + 1.15 * row + draw.uniform(-0.06, 0.06)
            y = 0.85 + 1.2 * column + draw.uniform(-0.08, 0.08)
            floor.furniture(f"Desk {row}.{column}", table(x, y, 0.5, 0.7))
            floor.furniture(f"Chair {row}.{column}", chair(x + 0.45 + draw.uniform(-0.1, 0.1), y, (1, 0)))
    floor.furniture("Teacher's desk", table(1.0, 3.0, 0.7, 1.4))
    floor.furniture("Teacher's chair", chair(0.45, 3.0, (-1, 0)))
    for k in range(3):
        floor.furniture(f"Cupboard {k}", [(2.4 + 1.1 * k, depth - 0.4, 3.4 + 1.1 * k, depth, 0.0, 1.9)])
    return floor.building.text()


def restaurant(seed, bare):
    draw, floor = random.Random(seed), Floor(f"restaurant {seed}", bare)
    length, depth, hall = 30.0, 20.0, 22.0
    floor.slab(-0.2, -0.2, length + 0.2, depth + 0.2)
    floor.wall("South", True, -0.1, (-0.2, length + 0.2), doors=[(3.0, 1.8)], windows=[(6.5 + 3.5 * k, 2.2) for k in range(4)])
    floor.wall("North", True, depth + 0.1, (-0.2, length + 0.2), windows=[(3.0 + 3.5 * k, 2.2) for k in range(5)])
    floor.wall("West", False, -0.1, (0.0, depth), windows=[(3.0 + 3.5 * k, 2.2) for k in range(5)])
    floor.wall("East", False, length + 0.1, (0.0, depth), doors=[(8.0, 1.2)])
    floor.wall("Kitchen", False, hall + 0.06, (0.0, depth), 0.12, doors=[(5.0, 1.2), (11.0, 1.2), (15.0, 1.0), (18.5, 1.0)])
    for y in (12.5, 16.7):
        floor.wall(f"Partition {y}", True, y, (hall + 0.12, length), 0.12)
    for number, (y0, y1) in enumerate([(12.56, 16.64), (16.76, depth)]):
        floor.wall(f"Stalls {number}", False, 26.0, (y0, y1), 0.1, doors=[((y0 + y1) / 2, 0.95)])
    floor.space("Hall", 0.0, 0.0, hall, depth)
    floor.space("Kitchen", hall + 0.12, 0.0, length, 12.44)
    for number, (y0, y1) in enumerate([(12.56, 16.64), (16.76, depth)]):
        floor.space(f"Washroom {number}", hall + 0.12, y0, 25.95, y1)
        floor.space(f"Stalls {number}", 26.05, y0, length, y1)
    for x in (5.5, 11.0, 16.5):
        for y in (6.5, 13.5):
            floor.building.element("IFCCOLUMN", f"Column {x} {y}", [(x - 0.2, y - 0.2, x + 0.2, y + 0.2, 0.0, HEIGHT)])
    number = 0
    for i in range(8):
        for j in range(7):
            x, y = 2.2 + 2.45 * i + draw.uniform(-0.15, 0.15), 3.2 + 2.4 * j + draw.uniform(-0.15, 0.15)
            if any(abs(x - cx) < 1.0 and abs(y - cy) < 1.0 for cx in (5.5, 11.0, 16.5) for cy in (6.5, 13.5)):
                continue
            number += 1
            floor.furniture(f"Table {number}", table(x, y, 0.8, 0.8))
            for side in [(1, 0), (-1, 0), (0, 1), (0, -1)]:
                away = 0.5 + draw.uniform(0.0, 0.2)
                floor.furniture(f"Chair {number} {side}", chair(x + away * side[0], y + away * side[1], side))
    floor.furniture("Bar", [(20.2, 6.5, 20.8, 9.5, 0.0, 1.1), (20.1, 6.4, 20.9, 9.6, 1.08, 1.12)])
    for k in range(5):
        floor.furniture(f"Stool {k}", leg(19.8, 6.8 + 0.6 * k, 0.0, 0.75, 0.17, 24))
    for k in range(6):
        floor.furniture(f"Planter {k}", leg(1.0 + 3.6 * k, 1.4, 0.0, 0.9, 0.25, 24))
    for k in range(5):
        floor.furniture(f"Range {k}", [(25.0, 1.2 + 2.0 * k, 26.6, 2.4 + 2.0 * k, 0.0, 0.9)])
        floor.furniture(f"Shelf {k}", [(29.4, 0.5 + 1.3 * k, 30.0, 1.5 + 1.3 * k, 0.0, 2.0)])
    for room in range(2):
        for k in range(3):
            floor.furniture(f"Basin {room}.{k}", [(22.9 + k, 12.56 if room == 0 else 19.5, 23.4 + k, 13.0 if room == 0 else 20.0, 0.7, 0.9)])
    return floor.building.text()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=["classroom", "restaurant"])
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.ifc")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--bare", action="store_true", help="without furniture")
    options = parser.parse_args()
    model = {"classroom": classroom, "restaurant": restaurant}[options.what]
    options.out.write_text(model(options.seed, options.bare))


if __name__ == "__main__":
    sys.exit(main())
