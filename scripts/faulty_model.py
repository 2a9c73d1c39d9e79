#!/usr/bin/env python3
"""Writes a small building with one fault of modelling, or none, and prints what is wrong with it as JSON.

usage: scripts/faulty_model.py OUT.ifc [FAULT] [--seed N] [--schema IFC4] [--unit MILLI] [--turn DEG] [--shift X Y] [--list]

Two storeys: rooms along a corridor, a stair hall at its end, outer and inner walls with doors, slabs, a georeference and numbers of
activities. Sizes follow from the seed, which also chooses the place of the fault. FAULT is one of --list; without it nothing is wrong.
Nothing but Python is needed, and the same arguments give the same bytes.

The JSON has the code that `groundplan check` gives the fault, the GlobalIds of the elements at fault, of doors that are closed for
it and of rooms that are out of reach or wrong, and its area in square metres, null where none is known.
"""
import argparse
import hashlib
import json
import math
import pathlib
import random
import sys

DIGITS = "0123456789ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz_$"
UNITS = {"METRE": 1.0, "MILLI": 0.001, "CENTI": 0.01, "FOOT": 0.3048}
SCHEMAS = ("IFC2X3", "IFC4", "IFC4X3_ADD2")
STOREY, CLEAR, SLAB = 3.2, 2.8, 0.3
OUTER, INNER, CORRIDOR = 0.3, 0.16, 2.4
DOOR, DOOR_HEIGHT, LEAF = 1.0, 2.1, 0.05
HALL, RISERS, TREAD, FLIGHT = 7.4, 18, 0.25, 1.1

FAULTS = {
    "door_without_opening": "door_without_opening", "door_beside_opening": "door_beside_opening",
    "opening_beside_wall": "opening_misses_wall", "opening_beyond_wall": "opening_misses_wall",
    "door_obstructed": "door_obstructed", "door_above_floor": "door_above_floor",
    "door_without_width": "door_without_width", "door_without_operation": "door_without_operation",
    "door_width_wrong": "door_width_wrong", "floor_hole": "floor_gap", "floor_crack": "floor_gap",
    "room_without_floor": "room_without_floor", "wall_gap": "wall_gap", "corner_gap": "wall_gap",
    "duplicate_element": "duplicate_element", "duplicate_global_id": "duplicate_global_id",
    "rooms_overlap": "rooms_overlap", "room_twice": "rooms_overlap", "room_without_body": "room_without_body",
    "room_without_door": "room_without_door", "room_missing": "floor_without_room", "storeys_apart": "storeys_apart",
    "storey_elevation": "storey_elevation", "element_on_other_storey": "element_on_other_storey",
    "geometry_failed": "geometry_failed", "element_out_of_reach": "element_out_of_reach",
    "no_georeference": "no_georeference", "no_dates": "no_dates",
}


class File:
    """Entities of a STEP file, in the order of their numbers; lengths are metres until they are written."""

    def __init__(self, key, unit_m):
        self.key, self.unit_m, self.lines, self.keys = key, unit_m, [], {}

    def add(self, entity, *values):
        self.lines.append(f"#{len(self.lines) + 1}={entity}({','.join(map(self.text, values))});")
        return f"#{len(self.lines)}"

    def text(self, value):
        if isinstance(value, (list, tuple)):
            return "(" + ",".join(map(self.text, value)) + ")"
        if isinstance(value, float):
            text = f"{value:.9g}"
            return text if "." in text or "e" in text else text + "."
        return str(value)

    def length(self, metres):
        return round(metres / self.unit_m, 7)

    def point(self, *metres):
        return self.add("IFCCARTESIANPOINT", [self.length(float(c)) for c in metres])

    def direction(self, *values):
        return self.add("IFCDIRECTION", [float(v) for v in values])

    def guid(self, key):
        number = int.from_bytes(hashlib.sha256(f"{self.key} {key}".encode()).digest()[:16], "big")
        return f"{number >> 126 & 3}" + "".join(DIGITS[number >> 6 * k & 63] for k in range(20, -1, -1))

    def root(self, entity, key, name, *values, guid=None):
        """An entity with a GlobalId, which is a hash of its key."""
        made = self.add(entity, f"'{guid or self.guid(key)}'", "$", f"'{name}'", *values)
        self.keys[key] = made
        return made


class Building:
    def __init__(self, arguments):
        self.fault, self.schema = arguments.fault, arguments.schema
        self.draw = random.Random(arguments.seed)
        self.file = File(f"{arguments.seed}", UNITS[arguments.unit])
        self.arguments, self.contained, self.spaces = arguments, {}, {}
        self.is_old = self.schema == "IFC2X3"
        self.write_project()

    def placement(self, parent, at=(0.0, 0.0, 0.0), turn_deg=0.0):
        file, turn = self.file, math.radians(turn_deg)
        x = file.direction(round(math.cos(turn), 12), round(math.sin(turn), 12), 0.0)
        axes = file.add("IFCAXIS2PLACEMENT3D", file.point(*at), file.direction(0, 0, 1), x)
        return file.add("IFCLOCALPLACEMENT", parent, axes)

    def write_project(self):
        file, add = self.file, self.file.add
        axes = add("IFCAXIS2PLACEMENT3D", file.point(0, 0, 0), "$", "$")
        self.context = add("IFCGEOMETRICREPRESENTATIONCONTEXT", "$", "'Model'", 3, 1e-5, axes, "$")
        if self.arguments.unit == "FOOT":
            metre = add("IFCSIUNIT", "*", ".LENGTHUNIT.", "$", ".METRE.")
            per_foot = add("IFCMEASUREWITHUNIT", "IFCLENGTHMEASURE(0.3048)", metre)
            one = add("IFCDIMENSIONALEXPONENTS", 1, 0, 0, 0, 0, 0, 0)
            length = add("IFCCONVERSIONBASEDUNIT", one, ".LENGTHUNIT.", "'FOOT'", per_foot)
        else:
            prefix = "$" if self.arguments.unit == "METRE" else f".{self.arguments.unit}."
            length = add("IFCSIUNIT", "*", ".LENGTHUNIT.", prefix, ".METRE.")
        others = [("AREAUNIT", "SQUARE_METRE"), ("VOLUMEUNIT", "CUBIC_METRE"), ("PLANEANGLEUNIT", "RADIAN")]
        units = add("IFCUNITASSIGNMENT", [length] + [add("IFCSIUNIT", "*", f".{kind}.", "$", f".{name}.") for kind, name in others])
        project = file.root("IFCPROJECT", "project", "Project", "$", "$", "$", "$", [self.context], units)
        self.origin = self.placement("$", (*self.arguments.shift, 0.0), self.arguments.turn)
        spatial = ["$", "$", self.origin, "$", "$", ".ELEMENT."]
        site = file.root("IFCSITE", "site", "Site", *spatial, "$", "$", "$", "$", "$")
        building = file.root("IFCBUILDING", "building", "Building", *spatial, "$", "$", "$")
        self.storeys, self.at, self.storey_z = [], [], []
        for k, name in enumerate(("Ground", "Upper")):
            # The fault is the placement alone: bodies stay where they are.
            off = 1.3 if self.fault == "storey_elevation" and k == 1 else 0.0
            placed = self.placement(self.origin, (0.0, 0.0, k * STOREY + off))
            self.at.append(self.placement(placed, (0.0, 0.0, -off)) if off else placed)
            self.storey_z.append(k * STOREY)
            self.storeys.append(file.root("IFCBUILDINGSTOREY", f"storey {k}", name, "$", "$", placed, "$", "$", ".ELEMENT.",
                                          file.length(k * STOREY + off)))
        for whole, parts in ((project, [site]), (site, [building]), (building, self.storeys)):
            file.root("IFCRELAGGREGATES", f"parts of {whole}", "", "$", whole, parts)
        if self.fault != "no_georeference":
            self.write_georeference(project)

    def write_georeference(self, project):
        file, add = self.file, self.file.add
        if self.is_old:
            def value(name, kind, number):
                return add("IFCPROPERTYSINGLEVALUE", f"'{name}'", "$", f"{kind}({number})", "$")
            metres = self.file.unit_m
            conversion = [value("Eastings", "IFCREAL", "500120."), value("Northings", "IFCREAL", "5700340."),
                          value("OrthogonalHeight", "IFCREAL", "61.5"), value("Scale", "IFCREAL", f"{metres}")]
            system = [value("Name", "IFCLABEL", "'EPSG:25832'"), value("MapUnit", "IFCLABEL", "'METRE'")]
            for name, values in (("ePSet_MapConversion", conversion), ("ePSet_ProjectedCRS", system)):
                made = file.root("IFCPROPERTYSET", name, name, "$", values)
                file.root("IFCRELDEFINESBYPROPERTIES", f"of {name}", "", "$", [file.keys["site"]], made)
            return
        metre = add("IFCSIUNIT", "*", ".LENGTHUNIT.", "$", ".METRE.")
        system = add("IFCPROJECTEDCRS", "'EPSG:25832'", "$", "'ETRS89'", "$", "'UTM'", "'32N'", metre)
        add("IFCMAPCONVERSION", self.context, system, 500120.0, 5700340.0, 61.5, 1.0, 0.0, self.file.unit_m)

    # Bodies: boxes of x0, y0, x1, y1, z0, z1 in the coordinates of the storey.

    def body(self, boxes):
        file, add, items = self.file, self.file.add, []
        for x0, y0, x1, y1, z0, z1 in boxes:
            flat = add("IFCAXIS2PLACEMENT2D", file.point((x0 + x1) / 2, (y0 + y1) / 2), "$")
            profile = add("IFCRECTANGLEPROFILEDEF", ".AREA.", "$", flat, file.length(x1 - x0), file.length(y1 - y0))
            at = add("IFCAXIS2PLACEMENT3D", file.point(0, 0, z0), "$", "$")
            items.append(add("IFCEXTRUDEDAREASOLID", profile, at, file.direction(0, 0, 1), file.length(z1 - z0)))
        shape = add("IFCSHAPEREPRESENTATION", self.context, "'Body'", "'SweptSolid'", items)
        return add("IFCPRODUCTDEFINITIONSHAPE", "$", "$", [shape])

    def element(self, entity, key, storey, boxes, *more, guid=None, listed=None, shape=None):
        """An element of a storey; `more` are its attributes behind the tag."""
        file = self.file
        placed = self.placement(self.at[storey])
        shape = shape or self.body(boxes)
        made = file.root(entity, key, key, "$", "$", placed, shape, "$", *more, guid=guid)
        self.contained.setdefault(storey if listed is None else listed, []).append(made)
        return made

    def wall(self, key, storey, box, **more):
        kind = () if self.is_old else (".STANDARD.",)
        return self.element("IFCWALL", key, storey, [(*box, 0.0, CLEAR)], *kind, **more)

    def slab(self, key, storey, boxes):
        return self.element("IFCSLAB", key, storey, [(*box, -SLAB, 0.0) for box in boxes], ".FLOOR.")

    def space(self, key, storey, box, body=True):
        file = self.file
        placed = self.placement(self.at[storey])
        shape = self.body([(*box, 0.0, CLEAR)]) if body else "$"
        kind = (".INTERNAL.",) if self.is_old else (".INTERNAL.",)
        made = file.root("IFCSPACE", key, key, "$", "$", placed, shape, "$", ".ELEMENT.", *kind, "$")
        self.spaces.setdefault(storey, []).append(made)
        return made

    def door(self, key, storey, wall, middle, along_x, thickness, fault=None):
        """A door in a wall: its middle in plan, and the direction of the wall."""
        file, [x, y] = self.file, middle
        lift = 0.6 if fault == "door_above_floor" else 0.0

        def box(width, depth, off_along, off_across, z0, z1):
            along, across = (x + off_along, y + off_across) if along_x else (y + off_along, x + off_across)
            a0, a1, c0, c1 = along - width / 2, along + width / 2, across - depth / 2, across + depth / 2
            return (a0, c0, a1, c1, z0, z1) if along_x else (c0, a0, c1, a1, z0, z1)

        across = thickness / 2 + 0.8 if fault == "opening_beside_wall" else 0.0
        beyond = 45.0 if fault == "opening_beyond_wall" else 0.0
        hole = box(DOOR, thickness + 0.2, beyond, across, lift, lift + DOOR_HEIGHT)
        beside = 1.25 if fault == "door_beside_opening" else 0.0
        leaf = box(DOOR, LEAF, beside, 0.0, lift, lift + DOOR_HEIGHT)
        width = "$" if fault == "door_without_width" else file.length(DOOR)
        height = file.length(DOOR_HEIGHT)
        if fault == "door_width_wrong":
            width, height = file.length(DOOR_HEIGHT), file.length(DOOR)
        swing = "$" if fault == "door_without_operation" else ".SINGLE_SWING_LEFT."
        more = (height, width) if self.is_old else (height, width, ".DOOR.", swing, "$")
        door = self.element("IFCDOOR", key, storey, [leaf], *more)
        if self.is_old and fault != "door_without_operation":
            style = file.root("IFCDOORSTYLE", f"style of {key}", "Style", "$", "$", "$", "$", "$", ".SINGLE_SWING_LEFT.",
                              ".NOTDEFINED.", ".T.", ".F.")
            file.root("IFCRELDEFINESBYTYPE", f"type of {key}", "", "$", [door], style)
        if fault != "door_without_opening":
            more = () if self.is_old else (".OPENING.",)
            opening = file.root("IFCOPENINGELEMENT", f"opening of {key}", "Opening", "$", "$", self.placement(self.at[storey]),
                                self.body([hole]), "$", *more)
            file.root("IFCRELVOIDSELEMENT", f"void of {key}", "", "$", wall, opening)
            file.root("IFCRELFILLSELEMENT", f"fill of {key}", "", "$", opening, door)
        if fault == "door_obstructed":
            kind = () if self.is_old else (".COLUMN.",)
            self.element("IFCCOLUMN", f"column in {key}", storey, [box(0.4, 0.3, 0.05, 0.0, 0.0, CLEAR)], *kind)
        return door

    def write(self):
        file = self.file
        for storey, elements in self.contained.items():
            file.root("IFCRELCONTAINEDINSPATIALSTRUCTURE", f"elements of {storey}", "", "$", elements, self.storeys[storey])
        for storey, spaces in self.spaces.items():
            file.root("IFCRELAGGREGATES", f"spaces of {storey}", "", "$", self.storeys[storey], spaces)
        if self.fault != "no_dates":
            number = file.add("IFCPROPERTYSINGLEVALUE", "'Activity ID'", "$", "IFCLABEL('A1000')", "$")
            made = file.root("IFCPROPERTYSET", "planning", "Planning", "$", [number])
            file.root("IFCRELDEFINESBYPROPERTIES", "of planning", "", "$", self.contained[0], made)
        head = "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(('ViewDefinition [ReferenceView]'),'2;1');\n"
        head += "FILE_NAME('faulty.ifc','2024-01-01T00:00:00',(''),(''),'','groundplan','');\n"
        head += f"FILE_SCHEMA(('{self.schema}'));\nENDSEC;\nDATA;\n"
        return head + "\n".join(file.lines) + "\nENDSEC;\nEND-ISO-10303-21;\n"


def cut(box, hole):
    """A rectangle without another one, as rectangles."""
    x0, y0, x1, y1 = box
    a0, b0, a1, b1 = max(x0, hole[0]), max(y0, hole[1]), min(x1, hole[2]), min(y1, hole[3])
    if a0 >= a1 or b0 >= b1:
        return [box]
    pieces = [(x0, y0, x1, b0), (x0, b1, x1, y1), (x0, b0, a0, b1), (a1, b0, x1, b1)]
    return [p for p in pieces if p[2] - p[0] > 1e-9 and p[3] - p[1] > 1e-9]


def building(arguments):
    b = Building(arguments)
    fault, draw, guid = arguments.fault, b.draw, b.file.guid
    n = draw.randint(3, 4)
    widths = [round(draw.uniform(3.4, 5.2), 2) for _ in range(n)]
    depth = round(draw.uniform(4.2, 5.4), 2)
    truth = {"elements": [], "doors": [], "rooms": [], "unreachable": [], "area_m2": None}
    edges = [0.0]
    for width in widths:
        edges.append(round(edges[-1] + width + INNER, 4))
    length = edges[-1] - INNER                       # of the rooms, between the outer walls
    north0, north1 = CORRIDOR + INNER, CORRIDOR + INNER + depth
    hall0, hall1 = length + INNER, length + INNER + HALL
    # The storey and the room of the fault.
    at_storey, at_room = draw.randint(0, 1), draw.randint(0, n - 1)
    inner_room = draw.randint(0, n - 2)              # of the wall between it and the next
    on_floor = fault in ("floor_hole", "floor_crack", "room_without_floor")
    at_storey = 1 if on_floor or fault == "storeys_apart" else at_storey

    def room_box(k):
        return (edges[k], north0, edges[k] + widths[k], north1)

    def area(box):
        return (box[2] - box[0]) * (box[3] - box[1])

    for s in range(2):
        here = s == at_storey
        name = ("G", "U")[s]
        # Outer walls: south, north, west, east.
        short = draw.uniform(0.15, 0.35) if fault == "corner_gap" and here else 0.0
        south = b.wall(f"{name} wall south", s, (-OUTER, -OUTER, hall1 + OUTER, 0.0))
        b.wall(f"{name} wall north", s, (-OUTER + (OUTER + short if short else 0.0), north1, length + OUTER, north1 + OUTER))
        west = b.wall(f"{name} wall west", s, (-OUTER, 0.0, 0.0, north1))
        if short:
            truth["elements"] = [guid(f"{name} wall north")]
            truth["rooms"] = [guid(f"{name}.1 room")]
        b.wall(f"{name} wall east", s, (length, CORRIDOR + INNER, length + OUTER, north1))
        b.wall(f"{name} wall hall north", s, (length + OUTER, CORRIDOR, hall1 + OUTER, CORRIDOR + OUTER))
        b.wall(f"{name} wall hall east", s, (hall1, 0.0, hall1 + OUTER, CORRIDOR))
        # Between corridor and rooms, and between corridor and hall.
        middle = b.wall(f"{name} wall middle", s, (0.0, CORRIDOR, length + OUTER, CORRIDOR + INNER))
        hall = b.wall(f"{name} wall hall", s, (length, 0.0, length + INNER, CORRIDOR))
        for k in range(n - 1):
            x = edges[k] + widths[k]
            gap = round(draw.uniform(0.14, 0.4), 3) if fault == "wall_gap" and here and k == inner_room else 0.0
            key = f"{name} wall {k + 1}"
            shape = None
            if fault == "geometry_failed" and here and k == inner_room:
                line = b.file.add("IFCPOLYLINE", [b.file.point(0, 0), b.file.point(1, 0)])
                profile = b.file.add("IFCARBITRARYCLOSEDPROFILEDEF", ".AREA.", "$", line)
                axes = b.file.add("IFCAXIS2PLACEMENT3D", b.file.point(0, 0, 0), "$", "$")
                solid = b.file.add("IFCEXTRUDEDAREASOLID", profile, axes, b.file.direction(0, 0, 1), b.file.length(CLEAR))
                shape = b.file.add("IFCSHAPEREPRESENTATION", b.context, "'Body'", "'SweptSolid'", [solid])
                shape = b.file.add("IFCPRODUCTDEFINITIONSHAPE", "$", "$", [shape])
                truth["elements"] = [guid(key)]
            other = guid(f"{name} wall south") if fault == "duplicate_global_id" and here and k == inner_room else None
            listed = 1 - s if fault == "element_on_other_storey" and here and k == inner_room else None
            b.wall(key, s, (x, north0, x + INNER, north1 - gap), guid=other, listed=listed, shape=shape)
            if gap or listed is not None:
                truth["elements"] = [guid(key)]
            if gap:
                truth["rooms"] = [guid(f"{name}.{k + 1} room"), guid(f"{name}.{k + 2} room")]
            if other:
                truth["elements"] = [other]
            if fault == "duplicate_element" and here and k == inner_room:
                b.wall(f"{key} again", s, (x, north0, x + INNER, north1))
                truth["elements"] = [guid(f"{key} again")]
        # Slabs: under everything, with the stair's hole on the upper floor.
        flight = (hall0 + 1.0, CORRIDOR - FLIGHT, hall0 + 1.0 + (RISERS - 1) * TREAD, CORRIDOR)
        plates = [(-OUTER, -OUTER, hall1 + OUTER, CORRIDOR + OUTER), (-OUTER, CORRIDOR + OUTER, length + OUTER, north1 + OUTER)]
        if s == 1 and fault != "storeys_apart":
            plates = [piece for plate in plates for piece in cut(plate, flight)]
        if on_floor and here:
            box = room_box(at_room)
            if fault == "floor_hole":
                x, y = box[0] + draw.uniform(0.8, 1.2), box[1] + draw.uniform(1.4, 2.0)
                hole = (x, y, x + draw.uniform(0.8, 1.4), y + draw.uniform(0.8, 1.2))
            elif fault == "floor_crack":
                y = round(box[1] + depth * draw.uniform(0.4, 0.6), 3)
                hole = (box[0] - INNER / 2, y, box[2] + INNER / 2, y + draw.uniform(0.2, 0.4))
            else:
                hole = (box[0] - 0.05, box[1] - 0.05, box[2] + 0.05, box[3] + 0.05)
            plates = [piece for plate in plates for piece in cut(plate, hole)]
            inside = (max(hole[0], box[0]), max(hole[1], box[1]), min(hole[2], box[2]), min(hole[3], box[3]))
            truth["elements"] = truth["rooms"] = [guid(f"{name}.{at_room + 1} room")]
            # Behind a crack the rest of the room is out of reach, too.
            truth["area_m2"] = area(inside) if fault != "floor_crack" else None
        b.slab(f"{name} slab", s, plates)
        # Rooms and their doors.
        for k in range(n):
            this = here and k == at_room
            box, room, door = room_box(k), f"{name}.{k + 1} room", f"{name} door {k + 1}"
            if fault == "rooms_overlap" and here and k == inner_room:
                over = draw.uniform(0.6, 1.4)
                box = (box[0], box[1], box[2] + INNER + over, box[3])
                truth["rooms"] = [guid(room), guid(f"{name}.{k + 2} room")]
                truth["area_m2"] = over * depth
            missing = this and fault == "room_missing"
            if missing:
                truth["area_m2"] = area(box)
            else:
                b.space(room, s, box, body=not (this and fault == "room_without_body"))
            if this and fault == "room_twice":
                b.space(f"{room} again", s, box)
                truth["rooms"], truth["area_m2"] = [guid(room), guid(f"{room} again")], area(box)
            if this and fault == "room_without_body":
                truth["elements"] = truth["rooms"] = [guid(room)]
            if this and fault == "room_without_door":
                truth["elements"] = truth["unreachable"] = [guid(room)]
                truth["area_m2"] = area(box)
                continue
            own = fault if this and fault and (fault.startswith("door_") or fault.startswith("opening_")) else None
            x = room_box(k)[0] + (0.9 if own == "door_beside_opening" else draw.uniform(0.8, widths[k] - 0.8))
            b.door(door, s, middle, (x, CORRIDOR + INNER / 2), True, INNER, own)
            if own:
                truth["elements"] = truth["doors"] = [guid(door)]
            if own in ("door_without_opening", "opening_beyond_wall", "door_obstructed", "door_above_floor"):
                truth["unreachable"], truth["area_m2"] = [guid(room)], area(box)
        b.space(f"{name}.10 corridor", s, (0.0, 0.0, length, CORRIDOR))
        b.space(f"{name}.11 stairs", s, (hall0, 0.0, hall1, CORRIDOR))
        b.door(f"{name} door hall", s, hall, (length + INNER / 2, CORRIDOR - FLIGHT - 0.65), False, INNER)
        if s == 0:
            b.door("G door outside", s, west, (-OUTER / 2, CORRIDOR / 2), False, OUTER)
    if fault == "storeys_apart":
        truth["elements"] = [guid("storey 1")]
    else:
        rise, z = STOREY / RISERS, 0.0
        steps = []
        for k in range(RISERS - 1):
            z = rise * (k + 1)
            steps.append((flight[0] + k * TREAD, flight[1], flight[0] + (k + 1) * TREAD, flight[3], max(0.0, z - 2 * rise), z))
        b.element("IFCSTAIR", "stair", 0, steps, ".STRAIGHT_RUN_STAIR.")
    if fault == "storey_elevation":
        truth["elements"] = [guid("storey 1")]
    if fault == "element_out_of_reach":
        kind = () if b.is_old else ("$",)
        far = 400000.0 + draw.uniform(0, 100)
        b.element("IFCFURNISHINGELEMENT", "desk", 0, [(far, far, far + 1.4, far + 0.7, 0.0, 0.75)])
        truth["elements"] = [guid("desk")]
    truth.update(fault=fault, code=FAULTS.get(fault))
    return b.write(), truth


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", nargs="?")
    parser.add_argument("fault", nargs="?", choices=list(FAULTS))
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--schema", choices=SCHEMAS, default="IFC4")
    parser.add_argument("--unit", choices=list(UNITS), default="METRE")
    parser.add_argument("--turn", type=float, default=0.0, metavar="DEG")
    parser.add_argument("--shift", type=float, nargs=2, default=(0.0, 0.0), metavar=("X", "Y"))
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    if arguments.list:
        print("\n".join(FAULTS))
        return 0
    if not arguments.out:
        parser.error("OUT.ifc is missing")
    text, truth = building(arguments)
    pathlib.Path(arguments.out).write_text(text)
    print(json.dumps(truth))
    return 0


if __name__ == "__main__":
    sys.exit(main())
