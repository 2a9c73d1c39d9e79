#!/usr/bin/env python3
"""Writes a hall with furniture in fine detail, or with walls and floors that are hard to cut, in IFC4: models to measure cost on.

usage: scripts/stress_model.py OUT.ifc [--kind chairs|copies|plants|opening|windows|grating|rows|blocks|sleeve|frames|lattice]
                               [--count 300] [--triangles 20000] [--openings 1]

    chairs    COUNT chairs of TRIANGLES triangles each, as mapped items of one chair, in rows, each turned by another angle
    copies    the same, every chair with a body of its own
    plants    COUNT plants whose leaves are TRIANGLES triangles: sheets that cross each other, every plant with a body of its own
    opening   COUNT walls, each with OPENINGS openings that overlap, faceted BReps of TRIANGLES triangles each
    windows   COUNT walls, each with OPENINGS plain openings that all overlap, turned in the wall by another angle each
    grating   COUNT plates with OPENINGS x OPENINGS holes, faceted BReps whose upper and lower faces have the holes as inner bounds,
              and slabs that are cut by such a BRep
    rows      COUNT walls with mitred ends, each with OPENINGS plain openings in rows that overlap each other and share planes with
              the faces of the wall
    blocks    the same, the openings as faceted BReps
    sleeve    COUNT walls, each with OPENINGS small openings, faceted BReps, that lie apart and all meet one long one
    frames    COUNT walls, each with OPENINGS openings that lie apart, faceted BReps with 12 holes as inner bounds
    lattice   COUNT walls whose profile has OPENINGS holes, with as many openings whose profiles have a hole each

All lengths are metres, the same options give the same bytes, and nothing but Python is needed.
"""
import argparse
import math
import pathlib
import random
import sys

from office_model import Building

HEIGHT = 3.0
# Kinds of walls with openings, and how many openings each wall has.
CUTS = {"rows": 300, "blocks": 40, "sleeve": 40, "frames": 20, "lattice": 60}


def tube(axis, radius, n_around, n_along):
    """A closed surface around an axis that bends: (vertices, triangles) with 2 n_around (n_along - 1) triangles and caps."""
    rings = [axis(k / n_along) for k in range(n_along + 1)]
    vertices, faces = [], []
    for (x, y, z), (u, v) in rings:
        for k in range(n_around):
            c, s = math.cos(2 * math.pi * k / n_around), math.sin(2 * math.pi * k / n_around)
            vertices.append(tuple(p + radius * (c * a + s * b) for p, a, b in zip((x, y, z), u, v)))
    for i in range(n_along):
        for k in range(n_around):
            a, b = i * n_around + k, i * n_around + (k + 1) % n_around
            c, d = a + n_around, b + n_around
            faces += [(a, b, d), (a, d, c)]
    for ring, turned in ((0, True), (n_along * n_around, False)):
        middle = len(vertices)
        centre = rings[0 if turned else -1][0]
        vertices.append(centre)
        for k in range(n_around):
            a, b = ring + k, ring + (k + 1) % n_around
            faces.append((middle, b, a) if turned else (middle, a, b))
    return vertices, faces


def ellipsoid(centre, radii, n_around, n_up):
    """A closed surface: (vertices, triangles) with 2 n_around (n_up - 1) triangles."""
    vertices = [(centre[0], centre[1], centre[2] - radii[2])]
    for i in range(1, n_up):
        polar = math.pi * (i / n_up - 0.5)
        for k in range(n_around):
            turn = 2 * math.pi * k / n_around
            c = (math.cos(polar) * math.cos(turn), math.cos(polar) * math.sin(turn), math.sin(polar))
            vertices.append(tuple(centre[j] + radii[j] * c[j] for j in range(3)))
    top = len(vertices)
    vertices.append((centre[0], centre[1], centre[2] + radii[2]))
    faces = []
    for k in range(n_around):
        nxt = (k + 1) % n_around
        faces.append((0, 1 + nxt, 1 + k))
        for i in range(n_up - 2):
            a, b = 1 + i * n_around + k, 1 + i * n_around + nxt
            faces += [(a, b, b + n_around), (a, b + n_around, a + n_around)]
        last = 1 + (n_up - 2) * n_around
        faces.append((last + k, last + nxt, top))
    return vertices, faces


def chair(n_triangles):
    """Seat, back, four legs and two arms: closed surfaces with about as many triangles as asked for."""
    n = max(6, round(math.sqrt(n_triangles / 16)))
    upright = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    bodies = [ellipsoid((0.0, 0.0, 0.45), (0.24, 0.24, 0.05), 2 * n, n), ellipsoid((0.0, 0.22, 0.75), (0.22, 0.04, 0.25), 2 * n, n)]
    for x in (-0.2, 0.2):
        for y in (-0.2, 0.2):
            bodies.append(tube(lambda t, x=x, y=y: ((x * (1.2 - 0.2 * t), y * (1.2 - 0.2 * t), 0.45 * t), upright), 0.02, n, n))
        ahead = ((1.0, 0.0, 0.0), (0.0, 0.0, 1.0))
        bodies.append(tube(lambda t, x=x: ((x * 1.2, 0.2 - 0.4 * t, 0.65 + 0.04 * math.sin(math.pi * t)), ahead), 0.015, n, n))
    vertices, faces = [], []
    for more, triangles in bodies:
        faces += [tuple(k + len(vertices) for k in t) for t in triangles]
        vertices += more
    return vertices, faces


def plant(n_triangles, draw):
    """Leaves of two triangles each, turned at random around a stem."""
    vertices, faces = [], []
    for _ in range(n_triangles // 2):
        turn, rise, out = draw.uniform(0, 2 * math.pi), draw.uniform(0.2, 1.6), 0.45 * math.sqrt(draw.random())
        tilt, size = draw.uniform(-0.8, 0.8), draw.uniform(0.03, 0.08)
        along, across = (math.cos(turn), math.sin(turn)), (-math.sin(turn), math.cos(turn))
        for a, b in ((0, 0), (0.5, 0.3), (1, 0), (0.5, -0.3)):
            xy = [along[k] * (out + a * size) + across[k] * b * size for k in range(2)]
            vertices.append((xy[0], xy[1], rise + a * size * math.sin(tilt) + b * size * math.cos(3 * turn)))
        first = len(vertices) - 4
        faces += [(first, first + 1, first + 2), (first, first + 2, first + 3)]
    return vertices, faces


def face_set(building, body):
    vertices, faces = body
    points = building.file.add("IFCCARTESIANPOINTLIST3D", vertices)
    return building.file.add("IFCTRIANGULATEDFACESET", points, "$", ".U.", [tuple(k + 1 for k in t) for t in faces], "$")


def faceted_brep(building, body):
    add = building.file.add
    vertices, faces = body
    points = [add("IFCCARTESIANPOINT", tuple(map(float, v))) for v in vertices]
    shell = [add("IFCFACE", [add("IFCFACEOUTERBOUND", add("IFCPOLYLOOP", [points[k] for k in t]), ".T.")]) for t in faces]
    return add("IFCFACETEDBREP", add("IFCCLOSEDSHELL", shell))


def placed(building, x, y, turn):
    add = building.file.add
    along = add("IFCDIRECTION", (math.cos(turn), math.sin(turn), 0.0))
    up = add("IFCDIRECTION", (0.0, 0.0, 1.0))
    axes = add("IFCAXIS2PLACEMENT3D", add("IFCCARTESIANPOINT", (float(x), float(y), 0.0)), up, along)
    return add("IFCLOCALPLACEMENT", building.placement, axes)


def product(building, entity, name, shape, x, y, turn, *last):
    building.elements.append(building.root(entity, name, "$", "$", placed(building, x, y, turn), shape, "$", *last))
    return building.elements[-1]


def shape_of(building, kind, item):
    shape = building.file.add("IFCSHAPEREPRESENTATION", building.context, "'Body'", f"'{kind}'", [item])
    return building.file.add("IFCPRODUCTDEFINITIONSHAPE", "$", "$", [shape])


def hall(building, length, breadth):
    building.element("IFCSLAB", "Slab", [(-1.0, -1.0, length + 1.0, breadth + 1.0, -0.3, 0.0)])
    for name, box in [("south", (-0.2, -0.2, length + 0.2, 0.0)), ("north", (-0.2, breadth, length / 2 - 0.6, breadth + 0.2)),
                      ("north east", (length / 2 + 0.6, breadth, length + 0.2, breadth + 0.2)),
                      ("west", (-0.2, 0.0, 0.0, breadth)), ("east", (length, 0.0, length + 0.2, breadth))]:
        building.element("IFCWALL", f"Wall {name}", [box + (0.0, HEIGHT)])


def furniture(count, n_triangles, kind):
    building, mapped, draw = Building(kind), kind == "chairs", random.Random(count)
    n_columns = math.ceil(math.sqrt(1.5 * count))
    pitch = 1.1
    hall(building, (n_columns + 1) * pitch, (math.ceil(count / n_columns) + 1) * pitch)
    add, body = building.file.add, chair(n_triangles)
    if mapped:
        kind = "Tessellation"
        inner = add("IFCSHAPEREPRESENTATION", building.context, "'Body'", f"'{kind}'", [face_set(building, body)])
        source = add("IFCREPRESENTATIONMAP", building.axes, inner)
        operator = add("IFCCARTESIANTRANSFORMATIONOPERATOR3D", "$", "$", add("IFCCARTESIANPOINT", (0.0, 0.0, 0.0)), "$", "$")
    for k in range(count):
        if mapped:
            shape = shape_of(building, "MappedRepresentation", add("IFCMAPPEDITEM", source, operator))
        else:
            own = plant(n_triangles, draw) if kind == "plants" else body
            shape = shape_of(building, "Tessellation", face_set(building, own))
        x, y = (1 + k % n_columns) * pitch + 0.0137 * (k % 7), (1 + k // n_columns) * pitch
        product(building, "IFCFURNITURE", f"Piece {k + 1}", shape, x, y, 0.37 * k, "$", "$")
    return building.text()


def openings(count, n_triangles, n_each):
    building = Building("openings")
    length = 6.0 * count
    hall(building, length, 10.0)
    n = max(6, round(math.sqrt(n_triangles / 2)))
    for k in range(count):
        solid = building.body([(0.0, 0.0, 5.0, 0.3, 0.0, HEIGHT)])
        wall = product(building, "IFCWALL", f"Wall {k + 1}", solid, 6.0 * k + 0.5, 5.0, 0.0, "$", "$")
        for i in range(n_each):
            # They overlap, as the parts of a window do.
            body = ellipsoid((1.0 + 3.0 * (i + 0.5) / n_each, 0.15, 1.2), (1.0, 0.5, 1.4), n, n)
            void, at = shape_of(building, "Brep", faceted_brep(building, body)), placed(building, 6.0 * k + 0.5, 5.0, 0.0)
            opening = building.root("IFCOPENINGELEMENT", f"Opening {k + 1}.{i + 1}", "$", "$", at, void, "$", "$")
            building.root("IFCRELVOIDSELEMENT", f"Cut {k + 1}.{i + 1}", "$", wall, opening)
    return building.text()


def windows(count, n_each):
    building = Building("windows")
    add = building.file.add
    hall(building, 6.0 * count, 10.0)
    for k in range(count):
        solid = building.body([(0.0, 0.0, 5.0, 0.3, 0.0, HEIGHT)])
        at = placed(building, 6.0 * k + 0.5, 5.0, 0.0)
        wall = product(building, "IFCWALL", f"Wall {k + 1}", solid, 6.0 * k + 0.5, 5.0, 0.0, "$", "$")
        for i in range(n_each):
            turn = math.pi / 2 * (i + 0.37) / n_each
            lean = 0.05 * math.sin(3 * i)
            along, across = (math.cos(turn), 0.0, math.sin(turn)), (lean * math.sin(turn), 1.0, -lean * math.cos(turn))
            middle = add("IFCCARTESIANPOINT", (2.5 + 0.5 * math.cos(7 * turn), -0.5, 1.5 + 0.2 * math.sin(5 * turn)))
            axes = add("IFCAXIS2PLACEMENT3D", middle, add("IFCDIRECTION", across), add("IFCDIRECTION", along))
            profile = add("IFCRECTANGLEPROFILEDEF", ".AREA.", "$", "$", 2.2 - 0.003 * i, 0.8 + 0.003 * i)
            solid = add("IFCEXTRUDEDAREASOLID", profile, axes, add("IFCDIRECTION", (0.0, 0.0, 1.0)), 1.2)
            opening = building.root("IFCOPENINGELEMENT", f"Opening {k + 1}.{i + 1}", "$", "$", at, shape_of(building, "SweptSolid", solid), "$", "$")
            building.root("IFCRELVOIDSELEMENT", f"Cut {k + 1}.{i + 1}", "$", wall, opening)
    return building.text()


def grating_brep(building, n, size, low, high):
    """A plate with n x n square holes, of which each is an inner bound of the upper and of the lower face."""
    add = building.file.add
    pitch = size / n
    rings = [[(0.0, 0.0), (size, 0.0), (size, size), (0.0, size)]]
    for i in range(n):
        for k in range(n):
            x0, y0, x1, y1 = (i + 0.2) * pitch, (k + 0.2) * pitch, (i + 0.8) * pitch, (k + 0.8) * pitch
            rings.append([(x0, y0), (x0, y1), (x1, y1), (x1, y0)])
    points = [[[add("IFCCARTESIANPOINT", (x, y, z)) for x, y in ring] for ring in rings] for z in (low, high)]
    loop = lambda corners: add("IFCPOLYLOOP", corners)

    def face(outlines):
        bounds = [add("IFCFACEBOUND" if k else "IFCFACEOUTERBOUND", loop(outline), ".T.") for k, outline in enumerate(outlines)]
        return add("IFCFACE", bounds)

    faces = [face([ring[::-1] for ring in points[0]]), face(points[1])]
    for below, above in zip(*points):
        for k, nxt in ((0, 1), (1, 2), (2, 3), (3, 0)):
            faces.append(face([[below[k], below[nxt], above[nxt], above[k]]]))
    return add("IFCFACETEDBREP", add("IFCCLOSEDSHELL", faces))


def gratings(count, n):
    building = Building("grating")
    hall(building, 14.0 * count, 10.0)
    for k in range(count):
        cases = [("IFCPLATE", grating_brep(building, n, 5.0, 0.0, 0.04), [(1.03, 1.03, 3.97, 3.97, -0.1, 0.1)]), ("IFCSLAB", None, None)]
        for i, (entity, brep, hole) in enumerate(cases):
            x = 14.0 * k + 1.0 + 6.0 * i
            at = placed(building, x, 2.0, 0.0)
            shape = shape_of(building, "Brep", brep) if brep else building.body([(0.0, 0.0, 6.0, 6.0, 0.0, 0.1)])
            element = product(building, entity, f"{entity[3:].title()} {k + 1}", shape, x, 2.0, 0.0, "$", "$")
            void = building.body(hole) if hole else shape_of(building, "Brep", grating_brep(building, n, 5.0, -0.1, 0.2))
            opening = building.root("IFCOPENINGELEMENT", f"Opening {k + 1}.{i + 1}", "$", "$", at, void, "$", "$")
            building.root("IFCRELVOIDSELEMENT", f"Cut {k + 1}.{i + 1}", "$", element, opening)
    return building.text()


def void(building, host, name, at, shape):
    opening = building.root("IFCOPENINGELEMENT", f"Opening {name}", "$", "$", at, shape, "$", "$")
    building.root("IFCRELVOIDSELEMENT", f"Cut {name}", "$", host, opening)


def rings_brep(building, rings, low, high):
    """A prism along y over rings of x and z: the first is the outline, the others are inner bounds of its two faces."""
    add = building.file.add
    points = [[[add("IFCCARTESIANPOINT", (float(x), float(y), float(z))) for x, z in ring] for ring in rings] for y in (low, high)]

    def face(outlines):
        bounds = [add("IFCFACEBOUND" if k else "IFCFACEOUTERBOUND", add("IFCPOLYLOOP", outline), ".T.") for k, outline in enumerate(outlines)]
        return add("IFCFACE", bounds)

    faces = [face(points[0]), face([ring[::-1] for ring in points[1]])]
    for near, far in zip(*points):
        n = len(near)
        faces += [face([[near[k], far[k], far[(k + 1) % n], near[(k + 1) % n]]]) for k in range(n)]
    return add("IFCFACETEDBREP", add("IFCCLOSEDSHELL", faces))


def ring_of(x0, z0, x1, z1, is_hole=False):
    ring = [(x0, z0), (x1, z0), (x1, z1), (x0, z1)]
    return ring[::-1] if is_hole else ring


def polyline(building, ring):
    points = [building.file.add("IFCCARTESIANPOINT", (float(x), float(y))) for x, y in ring]
    return building.file.add("IFCPOLYLINE", points + points[:1])


def upright_prism(building, rings, height):
    """A prism along z over rings of x and y."""
    add = building.file.add
    outline, *holes = [polyline(building, ring) for ring in rings]
    if holes:
        profile = add("IFCARBITRARYPROFILEDEFWITHVOIDS", ".AREA.", "$", outline, holes)
    else:
        profile = add("IFCARBITRARYCLOSEDPROFILEDEF", ".AREA.", "$", outline)
    return add("IFCEXTRUDEDAREASOLID", profile, building.axes, add("IFCDIRECTION", (0.0, 0.0, 1.0)), float(height))


def prism_across(building, rings, low, high):
    """A prism along y over rings of x and z."""
    add = building.file.add
    outline, *holes = [polyline(building, [(x, -z) for x, z in ring]) for ring in rings]
    kind = "IFCARBITRARYPROFILEDEFWITHVOIDS" if holes else "IFCARBITRARYCLOSEDPROFILEDEF"
    profile = add(kind, ".AREA.", "$", outline, *([holes] if holes else []))
    axis, along = add("IFCDIRECTION", (0.0, 1.0, 0.0)), add("IFCDIRECTION", (1.0, 0.0, 0.0))
    axes = add("IFCAXIS2PLACEMENT3D", add("IFCCARTESIANPOINT", (0.0, float(low), 0.0)), axis, along)
    return add("IFCEXTRUDEDAREASOLID", profile, axes, add("IFCDIRECTION", (0.0, 0.0, 1.0)), float(high - low))


def cut_walls(kind, count, n_each):
    """Walls 0.3 m thick and 3 m high, with openings that are as long as their number needs."""
    building = Building(kind)
    length = max(6.0, 0.12 * n_each if kind in ("rows", "blocks") else 0.25 * n_each if kind in ("sleeve", "lattice") else 1.1 * n_each)
    hall(building, length + 2.0, 4.0 * count + 4.0)
    for k in range(count):
        y = 2.0 + 4.0 * k
        at = placed(building, 1.0, y, 0.0)
        outline = [(0.0, 0.0), (length, 0.0), (length - 0.3, 0.3), (0.3, 0.3)]
        holes = [ring_of(0.25 * i + 0.4, 0.1, 0.25 * i + 0.5, 0.2, True) for i in range(n_each - 3)] if kind == "lattice" else []
        solid = upright_prism(building, [outline, *holes], HEIGHT)
        wall = product(building, "IFCWALL", f"Wall {k + 1}", shape_of(building, "SweptSolid", solid), 1.0, y, 0.0, "$", "$")
        if kind == "sleeve":
            long = [ring_of(0.2, 1.05, length - 0.2, 1.15)]
            void(building, wall, f"{k + 1}.0", at, shape_of(building, "Brep", rings_brep(building, long, 0.1, 0.2)))
        for i in range(n_each):
            if kind in ("rows", "blocks"):
                # Sills at three heights, among them the foot of the wall, so that neighbours share planes and overlap.
                x, z = 0.4 + (length - 1.3) * i / n_each, (0.0, 0.9, 0.4)[i % 3]
                rings, across = [ring_of(round(x, 2), z, round(x + 0.5, 2), (2.1, 2.1, 1.6)[i % 3])], (0.0, 0.3)
            elif kind == "frames":
                x = 0.4 + 1.1 * i
                holes = [ring_of(x + 0.05 + 0.3 * (n % 3), 0.95 + 0.3 * (n // 3), x + 0.25 + 0.3 * (n % 3), 1.15 + 0.3 * (n // 3), True)
                         for n in range(12)]
                rings, across = [ring_of(x, 0.9, x + 0.9, 2.2), *holes], (0.0, 0.3)
            elif kind == "lattice":
                x = 0.35 + 0.25 * i
                rings, across = [ring_of(x, 0.9, x + 0.2, 1.9), ring_of(x + 0.05, 1.0, x + 0.15, 1.2, True)], (-0.1, 0.4)
            else:
                x = 0.4 + 0.25 * i
                rings, across = [ring_of(x, 0.9, x + 0.1, 1.9)], (-0.05, 0.35)
            is_swept = kind in ("rows", "lattice")
            body = (prism_across if is_swept else rings_brep)(building, rings, *across)
            void(building, wall, f"{k + 1}.{i + 1}", at, shape_of(building, "SweptSolid" if is_swept else "Brep", body))
    return building.text()


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--kind", choices=["chairs", "copies", "plants", "opening", "windows", "grating", *CUTS], default="chairs")
    parser.add_argument("--count", type=int)
    parser.add_argument("--triangles", type=int, default=20_000)
    parser.add_argument("--openings", type=int)
    parser.add_argument("out", type=pathlib.Path, metavar="OUT.ifc")
    options = parser.parse_args()
    if options.kind == "opening":
        text = openings(options.count or 2, options.triangles, options.openings or 1)
    elif options.kind == "windows":
        text = windows(options.count or 2, options.openings or 60)
    elif options.kind == "grating":
        text = gratings(options.count or 1, options.openings or 20)
    elif options.kind in CUTS:
        text = cut_walls(options.kind, options.count or 1, options.openings or CUTS[options.kind])
    else:
        text = furniture(options.count or 300, options.triangles, options.kind)
    options.out.write_text(text)


if __name__ == "__main__":
    sys.exit(main())
