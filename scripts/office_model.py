#!/usr/bin/env python3
"""Writes an office floor in IFC4 whose walls are made of leafs side by side: a model to measure deviations on.

usage: scripts/office_model.py OUT.ifc [--seed N] [--rooms N]

A corridor with rooms on both sides, columns in the large ones. Outer walls have three leafs, inner walls two, three or one:
as walls of their own, as parts of a wall, or as a wall with a covering on each side. Doors are gaps in all leafs. All lengths
are metres, the same seed gives the same bytes, and nothing but Python is needed.
"""
import argparse
import hashlib
import pathlib
import random
import sys

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"
HEIGHT, DOOR_HEIGHT, SLAB = 2.8, 2.1, 0.3
CORRIDOR = 2.2


class File:
    """Entities of a STEP file, in the order of their numbers."""

    def __init__(self):
        self.lines = []

    def add(self, entity, *values):
        self.lines.append(f"#{len(self.lines) + 1}={entity}({','.join(map(self.text, values))});")
        return f"#{len(self.lines)}"

    def text(self, value):
        if isinstance(value, (list, tuple)):
            return "(" + ",".join(map(self.text, value)) + ")"
        return f"{value:.4f}" if isinstance(value, float) else str(value)

    def root(self, entity, key, name, *values):
        """An entity with a GlobalId, which is a hash of its key."""
        number = int.from_bytes(hashlib.sha256(key.encode()).digest()[:16], "big")
        guid = "".join(DIGITS[number >> 6 * k & 63] for k in range(20, -1, -1))
        return self.add(entity, f"'{number >> 126 & 3}{guid}'", "$", f"'{name}'", *values)


class Building:
    def __init__(self, key):
        self.key, self.file, self.elements, self.n = key, File(), [], 0
        add = self.file.add
        axes = add("IFCAXIS2PLACEMENT3D", add("IFCCARTESIANPOINT", (0.0, 0.0, 0.0)), "$", "$")
        context = add("IFCGEOMETRICREPRESENTATIONCONTEXT", "$", "'Model'", 3, 1e-5, axes, "$")
        kinds = [("LENGTHUNIT", "METRE"), ("AREAUNIT", "SQUARE_METRE"), ("VOLUMEUNIT", "CUBIC_METRE"), ("PLANEANGLEUNIT", "RADIAN")]
        units = add("IFCUNITASSIGNMENT", [add("IFCSIUNIT", "*", f".{kind}.", "$", f".{name}.") for kind, name in kinds])
        self.project = self.root("IFCPROJECT", "Office", "$", "$", "$", "$", [context], units)
        self.placement = add("IFCLOCALPLACEMENT", "$", axes)
        self.axes, self.context = axes, context
        spatial = ["$", "$", self.placement, "$", "$", ".ELEMENT."]
        site = self.root("IFCSITE", "Site", *spatial, "$", "$", "$", "$", "$")
        building = self.root("IFCBUILDING", "Office", *spatial, "$", "$", "$")
        self.storey = self.root("IFCBUILDINGSTOREY", "Floor", *spatial, 0.0)
        for whole, part in ((self.project, site), (site, building), (building, self.storey)):
            self.root("IFCRELAGGREGATES", "", "$", whole, [part])

    def root(self, entity, name, *values):
        self.n += 1
        return self.file.root(entity, f"{self.key} {self.n} {name}", name, *values)

    def body(self, boxes):
        """Boxes of x0, y0, x1, y1, z0, z1."""
        add, items = self.file.add, []
        for x0, y0, x1, y1, z0, z1 in boxes:
            middle = add("IFCCARTESIANPOINT", ((x0 + x1) / 2, (y0 + y1) / 2))
            flat = add("IFCAXIS2PLACEMENT2D", middle, "$")
            profile = add("IFCRECTANGLEPROFILEDEF", ".AREA.", "$", flat, float(x1 - x0), float(y1 - y0))
            at = add("IFCAXIS2PLACEMENT3D", add("IFCCARTESIANPOINT", (0.0, 0.0, float(z0))), "$", "$")
            up = add("IFCDIRECTION", (0.0, 0.0, 1.0))
            items.append(add("IFCEXTRUDEDAREASOLID", profile, at, up, float(z1 - z0)))
        shape = add("IFCSHAPEREPRESENTATION", self.context, "'Body'", "'SweptSolid'", items)
        return add("IFCPRODUCTDEFINITIONSHAPE", "$", "$", [shape])

    def element(self, entity, name, boxes, contained=True):
        shape = self.body(boxes) if boxes else "$"
        placement = self.file.add("IFCLOCALPLACEMENT", self.placement, self.axes)
        element = self.root(entity, name, "$", "$", placement, shape, "$", "$")
        if contained:
            self.elements.append(element)
        return element

    def text(self):
        self.root("IFCRELCONTAINEDINSPATIALSTRUCTURE", "", "$", self.elements, self.storey)
        head = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('ViewDefinition [ReferenceView]'),'2;1');\n"
        head += f"FILE_NAME('{self.key}.ifc','2024-01-01T00:00:00',(''),(''),'','groundplan','');\nFILE_SCHEMA(('IFC4'));\nENDSEC;\nDATA;\n"
        return head + "\n".join(self.file.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"


def wall(building, name, along_x, fixed, span, leafs, how, doors=()):
    """A wall whose middle line is at a fixed coordinate; leafs are thicknesses, doors are middle and width."""
    low, high = span
    pieces, at = [], low
    for middle, width in sorted(doors):
        pieces += [(at, middle - width / 2, 0.0), (middle - width / 2, middle + width / 2, DOOR_HEIGHT)]
        at = middle + width / 2
    pieces.append((at, high, 0.0))

    def boxes(near, far):
        return [((a, near, b, far) if along_x else (near, a, far, b)) + (z, HEIGHT) for a, b, z in pieces]

    across, parts = fixed - sum(leafs) / 2, []
    for number, thickness in enumerate(leafs):
        is_lining = how == "covering" and number in (0, len(leafs) - 1) and len(leafs) > 1
        entity = "IFCBUILDINGELEMENTPART" if how == "parts" else "IFCCOVERING" if is_lining else "IFCWALL"
        leaf = f"{name} leaf {number + 1}" if len(leafs) > 1 else name
        parts.append(building.element(entity, leaf, boxes(across, across + thickness), how != "parts"))
        across += thickness
    if how == "parts":
        whole = building.element("IFCWALL", name, [])
        building.root("IFCRELAGGREGATES", "", "$", whole, parts)


def office(seed, n_rooms=None):
    draw = random.Random(seed)
    building = Building(f"office {seed}")
    outer, n_rooms = [0.1, 0.12, 0.15], n_rooms or 5 + seed % 3
    widths = [round(draw.uniform(3.0, 6.5), 2) for _ in range(n_rooms)]
    depth = [round(draw.uniform(4.2, 6.5), 2) for _ in range(2)]
    length, breadth = sum(widths), depth[0] + CORRIDOR + depth[1]
    half = sum(outer) / 2
    building.element("IFCSLAB", "Slab", [(-1.0, -1.0, length + 1.0, breadth + 1.0, -SLAB, 0.0)])

    def inner():
        leafs = draw.choice([[0.1], [0.115], [0.05, 0.05], [0.0125, 0.075, 0.0125], [0.025, 0.1, 0.025], [0.1, 0.04, 0.1]])
        return leafs, draw.choice(["walls", "parts", "covering"])

    for name, along_x, fixed, span in [("south", True, -half, (0, length)), ("north", True, breadth + half, (0, length)),
                                       ("west", False, -half, (-2 * half, breadth + 2 * half)),
                                       ("east", False, length + half, (-2 * half, breadth + 2 * half))]:
        wall(building, f"Outer wall {name}", along_x, fixed, span, outer, draw.choice(["walls", "parts"]))
    for side, (y0, y1, corridor) in enumerate([(0.0, depth[0], depth[0]), (breadth - depth[1], breadth, breadth - depth[1])]):
        at = 0.0
        for number, width in enumerate(widths):
            if side and number + 1 < n_rooms:
                width = round(width * draw.uniform(0.9, 1.1), 2) if number + 2 < n_rooms else width
            end = length if number + 1 == n_rooms else min(at + width, length - 2.5)
            leafs, how = inner()
            door = at + draw.uniform(0.9, max(1.0, end - at - 0.9))
            is_open = number % 4 == 3
            if not is_open:
                wall(building, f"Corridor {side}.{number}", True, corridor, (at, end), leafs, how, [(door, 0.95)])
            if number + 1 < n_rooms:
                leafs, how = inner()
                thick = 0.15
                span = (y0, y1 - thick) if side == 0 else (y0 + thick, y1)
                wall(building, f"Partition {side}.{number}", False, end, span, leafs, how)
            if end - at > 4.5:
                x, y, s = (at + end) / 2, (y0 + y1) / 2, 0.15
                building.element("IFCCOLUMN", f"Column {side}.{number}", [(x - s, y - s, x + s, y + s, 0.0, HEIGHT)])
            at = end
    # A wall that stands free in the corridor, and one in a room: cupboards built in, for the model.
    building.element("IFCFURNITURE", "Cupboard", [(0.05, 0.6, 0.5, 2.4, 0.0, 2.0)])
    building.element("IFCFURNITURE", "Counter", [(length - 2.6, breadth - 1.2, length - 0.9, breadth - 0.5, 0.0, 1.0)])
    return building.text()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--rooms", type=int, help="on each side of the corridor, instead of 5 to 7")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.ifc")
    options = parser.parse_args()
    options.out.write_text(office(options.seed, options.rooms))


if __name__ == "__main__":
    sys.exit(main())
