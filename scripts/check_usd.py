#!/usr/bin/env python3
"""Judges world/site.usda of an output folder by USD's own validators, and by the other files of the world.

    python3 scripts/check_usd.py OUT..             judge folders that `groundplan convert MODEL -o OUT --world --usd` wrote
    python3 scripts/check_usd.py --damage OUT..    damage the stage, too; each damage must be noticed

Needs usd-core, trimesh and numpy. Exit codes: 0 all is as it should be, 1 it is not, 2 something cannot be read.

- UsdValidation finds nothing wrong (geometry, materials, physics, metadata), nor has composition errors; Z is up, in metres.
- Elements are those of lookup.json. What is seen of each, and the leaves of each door, have the bounds and the
  area that trimesh reads in site.glb, by GlobalId.
- What collides has the number and the bounds of the collision shapes of world.sdf, link by link; static bodies are no rigid bodies.
- The reader of physics that comes with USD takes every shape, body and joint for valid.
- Joints are those of doors.urdf, with kind, axis, limits, parent and mass; both ends of each joint meet while the door is closed.
- Each leaf, moved by its joint from limit to limit as USD defines joints, comes to where doors.urdf has it, and to an opened place: its
  middle has left the opening, where the joint goes as far as its kind does.
"""
import argparse
import json
import math
import pathlib
import re
import sys
import xml.etree.ElementTree as ElementTree

import numpy as np
import trimesh
from pxr import Gf, Usd, UsdGeom, UsdPhysics, UsdValidation

SAME_M = 2e-4
SAME_RAD = 2e-5
SAME_SHARE = 1e-3
SAME_DEGREES = 1e-3


def identifier(name):
    name = re.sub(r"[^0-9A-Za-z]", "_", name)
    return "_" + name if name[0].isdigit() else name


def numbers(text):
    return np.array([float(n) for n in text.split()])


def turned(roll, pitch, yaw):
    """Rotation about fixed axes, in this order."""
    cos, sin = np.cos([roll, pitch, yaw]), np.sin([roll, pitch, yaw])
    x = np.array([[1, 0, 0], [0, cos[0], -sin[0]], [0, sin[0], cos[0]]])
    y = np.array([[cos[1], 0, sin[1]], [0, 1, 0], [-sin[1], 0, cos[1]]])
    z = np.array([[cos[2], -sin[2], 0], [sin[2], cos[2], 0], [0, 0, 1]])
    return z @ y @ x


def motion(values):
    """A pose of six numbers as a matrix."""
    matrix = np.eye(4)
    matrix[:3, 3], matrix[:3, :3] = values[:3], turned(*values[3:])
    return matrix


def moved(matrix, points):
    return points @ matrix[:3, :3].T + matrix[:3, 3]


def box(size):
    return np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size


def area(corners):
    """Area of triangles."""
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    return np.linalg.norm(sides, axis=1).sum() / 2


class Shape:
    """Corners of a shape, and the area of its faces where they are known."""

    def __init__(self, points, triangles=None):
        self.bounds = np.array([points.min(axis=0), points.max(axis=0)])
        self.area = None if triangles is None else area(points[triangles])


def united(shapes):
    """Bounds and area of several shapes."""
    bounds = np.array([shape.bounds for shape in shapes])
    return np.array([bounds[:, 0].min(axis=0), bounds[:, 1].max(axis=0)]), sum(shape.area or 0.0 for shape in shapes)


class Stage:
    """What a stage holds."""

    def __init__(self, stage):
        self.stage, self.cache = stage, UsdGeom.XformCache()
        self.elements, self.names = {}, {}
        for prim in stage.Traverse():
            id = prim.GetAttribute("ifc:globalId")
            if id and id.Get():
                self.elements.setdefault(id.Get(), []).append(prim)
                # Identifiers of two GlobalIds may be one but for a number behind it.
                before = prim.GetName().split("_" + identifier("x" + id.Get())[1:])[0]
                self.names[prim.GetParent().GetName(), f"{before}_{id.Get()}"] = prim

    def at(self, model, link):
        """The prim of a link of world.sdf."""
        door = self.names.get(("site", model))
        if door:
            return door.GetChild(identifier(link))
        found = self.names.get((identifier(model), link))
        return found or self.stage.GetPrimAtPath(f"/site/{identifier(model)}/{identifier(link)}")

    def world(self, prim):
        # USD multiplies rows from the left.
        return np.array(self.cache.GetLocalToWorldTransform(prim)).T

    def shape(self, prim):
        if prim.IsA(UsdGeom.Cube):
            return Shape(moved(self.world(prim), box(UsdGeom.Cube(prim).GetSizeAttr().Get())), CUBE)
        mesh = UsdGeom.Mesh(prim)
        counts, corners = mesh.GetFaceVertexCountsAttr().Get(), mesh.GetFaceVertexIndicesAttr().Get()
        points = moved(self.world(prim), np.array(mesh.GetPointsAttr().Get(), float))
        triangles, at = [], 0
        for n in counts:
            triangles += [[corners[at], corners[at + k], corners[at + k + 1]] for k in range(1, n - 1)]
            at += n
        return Shape(points, np.array(triangles))

    def shapes(self, prim, collides):
        """Shapes below a prim that are seen, or that collide."""
        found = [p for p in Usd.PrimRange(prim) if p.IsA(UsdGeom.Gprim) and p.HasAPI(UsdPhysics.CollisionAPI) == collides]
        return [self.shape(p) for p in found]


# Two triangles for each side of a cube whose corners are in the order of `box`.
CUBE = np.array([[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1], [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]])


class Truth:
    """The other files of a world."""

    def __init__(self, world):
        lookup = json.loads((world / "lookup.json").read_text(encoding="utf-8"))
        self.ids = set(lookup["elements"]) | set(lookup["doors"])
        self.glb = self.read_glb(world / "site.glb")
        self.sdf = self.read_sdf(world)
        self.links, self.joints = self.read_urdf(world / "doors.urdf")

    @staticmethod
    def read_glb(path):
        """Shapes by GlobalId, in `map`."""
        scene = trimesh.load_scene(path)
        graph = scene.graph
        # trimesh numbers nodes that share a name; names of elements are those that their node has in the file.
        y_up = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]], float)
        found = {}
        for node in graph.nodes_geometry:
            matrix, geometry = graph[node]
            mesh = scene.geometry[geometry]
            shape = Shape(moved(y_up @ matrix, np.array(mesh.vertices)), np.array(mesh.faces))
            at = node
            while at is not None:
                found.setdefault(at, []).append(shape)
                at = graph.transforms.parents.get(at)
        return found

    @staticmethod
    def read_sdf(world):
        """Bounds of collision shapes by the names of model and link."""
        found, meshes = {}, {}

        def points_of(geometry):
            size, uri = geometry.findtext("box/size"), geometry.findtext("mesh/uri")
            if size is not None:
                return box(numbers(size))
            if uri not in meshes:
                lines = (world / uri).read_text().splitlines()
                meshes[uri] = np.array([numbers(line[2:]) for line in lines if line.startswith("v ")])
            return meshes[uri]

        pose = lambda node: motion(numbers(node.findtext("pose") or "0 0 0 0 0 0"))
        for model in ElementTree.parse(world / "world.sdf").getroot().iter("model"):
            for link in model.findall("link"):
                place = pose(model) @ pose(link)
                of = [Shape(moved(place @ pose(c), points_of(c.find("geometry")))).bounds for c in link.findall("collision")]
                found[model.get("name"), link.get("name")] = of
        return found

    @staticmethod
    def read_urdf(path):
        root = ElementTree.parse(path).getroot()
        links = {}
        for link in root.findall("link"):
            mass = link.find("inertial/mass")
            links[link.get("name")] = None if mass is None else float(mass.get("value"))
        joints = {}
        for joint in root.findall("joint"):
            origin, axis, limit = joint.find("origin"), joint.find("axis"), joint.find("limit")
            joints[joint.find("child").get("link")] = {
                "kind": joint.get("type"),
                "parent": joint.find("parent").get("link"),
                "origin": motion(np.concatenate([numbers(origin.get("xyz")), numbers(origin.get("rpy"))])),
                "axis": None if axis is None else numbers(axis.get("xyz")),
                "limits": None if limit is None else [float(limit.get("lower")), float(limit.get("upper"))],
            }
        return links, joints

    def place(self, link, values):
        """Pose of a link of doors.urdf in `map` for values of joints."""
        if link not in self.joints:
            return np.eye(4)
        joint = self.joints[link]
        own, value = np.eye(4), values.get(link, 0.0)
        if joint["kind"] == "revolute":
            own[:3, :3] = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*joint["axis"]), math.degrees(value)))).T
        elif joint["kind"] == "prismatic":
            own[:3, 3] = joint["axis"] * value
        return self.place(joint["parent"], values) @ joint["origin"] @ own


KINDS = {"PhysicsRevoluteJoint": "revolute", "PhysicsPrismaticJoint": "prismatic", "PhysicsFixedJoint": "fixed"}


def frame_of(joint, end):
    position = joint.GetAttribute(f"physics:localPos{end}").Get()
    rotation = joint.GetAttribute(f"physics:localRot{end}").Get()
    matrix = np.eye(4)
    matrix[:3, 3] = position
    matrix[:3, :3] = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Quatd(rotation)))).T
    return matrix


class Judge:
    def __init__(self, out):
        self.truth = Truth(out / "world")
        self.path = out / "world/site.usda"

    def judge(self, stage):
        """What is wrong with a stage: a sentence each."""
        wrong = []

        def expect(is_so, what):
            if not is_so:
                wrong.append(what)

        for error in UsdValidation.ValidationContext(UsdValidation.ValidationRegistry().GetOrLoadAllValidators()).Validate(stage):
            wrong.append(f"a validator of USD: {error.GetMessage()}")
        expect(UsdGeom.GetStageUpAxis(stage) == "Z" and UsdGeom.GetStageMetersPerUnit(stage) == 1.0, "it is not in metres with Z up")
        expect(stage.GetDefaultPrim() and stage.GetDefaultPrim().GetPath() == "/site", "its default prim is not /site")
        read = Stage(stage)
        self.judge_seen(read, expect)
        self.judge_collisions(read, expect)
        self.judge_joints(read, expect)
        self.judge_physics(stage, expect)
        return wrong

    def judge_physics(self, stage, expect):
        """What engines get of the stage."""
        taken = {}
        for kind, (paths, facts) in UsdPhysics.UsdPhysicsLoadStageFromPrimRange(stage, ["/site"]).items():
            name = str(kind).split(".")[-1]
            expect(all(fact.isValid for fact in facts), f"USD takes no {name} from {[str(p) for p, f in zip(paths, facts) if not f.isValid][:2]}")
            group = "Joint" if name.endswith("Joint") else "Shape" if name.endswith("Shape") else name
            taken[group] = taken.get(group, 0) + len(paths)
        told = {"Scene": 1, "Shape": self.n_collisions, "RigidBody": self.n_joints, "Joint": self.n_joints}
        expect(taken == {kind: n for kind, n in told.items() if n}, f"USD takes {taken} from it, and there are {told}")

    def judge_seen(self, read, expect):
        self.n_elements = 0
        for id, prims in read.elements.items():
            shapes = [shape for prim in prims for shape in read.shapes(prim, collides=False)]
            told = self.truth.glb.get(id, [])
            # The frame of a door is in world.sdf alone.
            if any(prim.GetChild("frame") for prim in prims):
                shapes = [s for prim in prims for leaf in prim.GetChildren() if leaf.GetName() != "frame" for s in read.shapes(leaf, collides=False)]
            if not shapes or not told:
                expect(not shapes and not told, f"{id} is seen in one of site.usda and site.glb")
                continue
            self.n_elements += 1
            (bounds, own_area), (told_bounds, told_area) = united(shapes), united(told)
            far = np.abs(bounds - told_bounds).max()
            expect(far <= SAME_M + 1e-6 * np.abs(bounds).max(), f"{id} has other bounds than in site.glb, by {far:.4f} m")
            expect(abs(own_area - told_area) <= SAME_SHARE * told_area + 1e-6, f"{id} has {own_area:.3f} m2 of faces, and {told_area:.3f} in site.glb")
        expect(set(read.elements) == self.truth.ids, f"elements are not those of lookup.json: {sorted(set(read.elements) ^ self.truth.ids)[:3]}")

    def judge_collisions(self, read, expect):
        self.n_collisions = 0
        for (model, link), bounds in self.truth.sdf.items():
            if model == "waypoints":
                continue
            prim = read.at(model, link)
            expect(bool(prim), f"{model}/{link} is not in site.usda")
            if not prim:
                continue
            shapes = read.shapes(prim, collides=True)
            self.n_collisions += len(shapes)
            expect(len(shapes) == len(bounds), f"{model}/{link} has {len(shapes)} shapes that collide, and {len(bounds)} in world.sdf")
            far = max((np.abs(s.bounds - b).max() for s, b in zip(shapes, bounds)), default=0.0)
            expect(far <= SAME_M, f"{model}/{link} collides elsewhere than in world.sdf, by {far:.4f} m")
            is_leaf = prim.GetParent().GetChild("frame") and prim.GetName() != "frame"
            is_rigid = prim.HasAPI(UsdPhysics.RigidBodyAPI)
            expect(is_rigid == bool(is_leaf and self.is_movable(read)), f"{model}/{link} is {'' if is_rigid else 'no '}rigid body")

    def is_movable(self, read):
        return any(prim.IsA(UsdPhysics.Joint) for prim in read.stage.Traverse())

    def judge_joints(self, read, expect):
        self.n_joints, self.n_opened = 0, 0
        joints = [prim for prim in read.stage.Traverse() if prim.IsA(UsdPhysics.Joint)]
        if not joints:
            return
        doors = {prim.GetPath(): name for (_, name), prim in read.names.items()}
        name = lambda path: doors.get(path.GetParentPath(), str(path)) + ("" if path.name == "frame" else f"_{path.name}")
        told = {child: joint for child, joint in self.truth.joints.items() if joint["parent"] != "map"}
        found = {}
        for joint in joints:
            bodies = [joint.GetRelationship(f"physics:body{end}").GetTargets()[0] for end in (0, 1)]
            found[name(bodies[1])] = (joint, bodies)
        expect(set(found) == set(told), f"joints are not those of doors.urdf: {sorted(set(found) ^ set(told))[:3]}")
        for child, (joint, bodies) in found.items():
            if child not in told:
                continue
            self.n_joints += 1
            want, prims = told[child], [read.stage.GetPrimAtPath(path) for path in bodies]
            expect(KINDS.get(joint.GetTypeName()) == want["kind"], f"{child} is {joint.GetTypeName()}, and {want['kind']} in doors.urdf")
            expect(name(bodies[0]) == want["parent"], f"{child} hangs on {name(bodies[0])}")
            mass = prims[1].GetAttribute("physics:mass").Get()
            expect(abs(mass - self.truth.links[child]) <= 1e-3, f"{child} weighs {mass} kg")
            frames = [read.world(prim) @ frame_of(joint, end) for end, prim in enumerate(prims)]
            expect(np.abs(frames[0] - frames[1]).max() <= SAME_M, f"the ends of the joint of {child} do not meet")
            if want["kind"] == "fixed" or KINDS.get(joint.GetTypeName()) != want["kind"]:
                continue
            limits = [joint.GetAttribute(f"physics:{end}Limit").Get() for end in ("lower", "upper")]
            wanted = [math.degrees(v) if want["kind"] == "revolute" else v for v in want["limits"]]
            expect(np.abs(np.array(limits) - wanted).max() <= SAME_DEGREES, f"{child} moves from {limits}, and {wanted} in doors.urdf")
            self.judge_motion(read, child, joint, prims, frames[0], want, limits, expect)

    def judge_motion(self, read, child, joint, prims, frame, want, limits, expect):
        axis = "XYZ".index(joint.GetAttribute("physics:axis").Get())
        along = np.eye(3)[axis]
        middle = np.array([shape.bounds.mean(axis=0) for shape in read.shapes(prims[1], collides=True)]).mean(axis=0)
        closed = np.linalg.inv(read.world(prims[1]))
        for value, own_value in zip(limits, want["limits"]):
            own = np.eye(4)
            if want["kind"] == "revolute":
                own[:3, :3] = np.array(Gf.Matrix3d(Gf.Rotation(Gf.Vec3d(*along), value))).T
            else:
                own[:3, 3] = along * value
            place = frame @ own @ np.linalg.inv(frame_of(joint, 1))
            expected = self.truth.place(child, {child: own_value})
            expect(np.abs(place - expected).max() <= SAME_M, f"{child} at {value} is not where doors.urdf has it")
            gone = np.linalg.norm(moved(place @ closed, middle[None])[0] - middle)
            reaches = abs(own_value) > 1.5 if want["kind"] == "revolute" else abs(own_value) > 0.5
            if reaches and abs(own_value) < 3:
                self.n_opened += 1
                expect(gone > 0.25, f"{child} at {value} is {gone:.2f} m from where it closes the opening")


def damages(path):
    """Stages with something wrong in each, and words of what has to be found."""

    def changed(change):
        stage = Usd.Stage.Open(path.as_posix())
        # What is changed stays in memory.
        stage.SetEditTarget(stage.GetSessionLayer())
        change(stage)
        return stage

    def first(stage, kind):
        return next((prim for prim in stage.Traverse() if kind(prim)), None)

    def shifted(stage):
        prim = first(stage, lambda p: p.IsA(UsdGeom.Mesh) and not p.HasAPI(UsdPhysics.CollisionAPI))
        attribute = prim.GetAttribute("xformOp:translate")
        attribute.Set(attribute.Get() + Gf.Vec3d(0.01, 0, 0))

    def inches(stage):
        UsdGeom.SetStageMetersPerUnit(stage, 0.0254)

    def without_a_collision(stage):
        first(stage, lambda p: p.HasAPI(UsdPhysics.CollisionAPI)).SetActive(False)

    def larger(stage):
        prim = first(stage, lambda p: p.IsA(UsdGeom.Cube) and p.HasAPI(UsdPhysics.CollisionAPI))
        UsdGeom.Cube(prim).GetSizeAttr().Set(1.1)

    def falls(stage):
        prim = first(stage, lambda p: p.GetAttribute("ifc:globalId") and not p.GetChild("frame"))
        UsdPhysics.RigidBodyAPI.Apply(prim)

    def of(prim_kind):
        return lambda p: p.GetTypeName() == prim_kind

    def radians(stage):
        attribute = first(stage, of("PhysicsRevoluteJoint")).GetAttribute("physics:upperLimit")
        attribute.Set(math.radians(attribute.Get()))

    def other_sense(stage):
        joint = first(stage, of("PhysicsRevoluteJoint"))
        for end in (0, 1):
            attribute = joint.GetAttribute(f"physics:localRot{end}")
            attribute.Set(attribute.Get() * Gf.Quatf(0, 1, 0, 0))

    def other_hinge(stage):
        attribute = first(stage, of("PhysicsRevoluteJoint")).GetAttribute("physics:localPos0")
        attribute.Set(attribute.Get() + Gf.Vec3f(0.2, 0, 0))

    def nowhere(stage):
        first(stage, of("PhysicsRevoluteJoint")).GetRelationship("physics:body1").SetTargets(["/site/nothing"])

    cases = {
        "an element 1 cm beside its place": (shifted, "has other bounds than in site.glb"),
        "inches": (inches, "not in metres"),
        "a collision shape less": (without_a_collision, "shapes that collide"),
        "a larger collision shape": (larger, "collides elsewhere"),
        "an element that falls": (falls, "rigid body"),
        "a limit in radians": (radians, "moves from"),
        "a leaf that turns the other way": (other_sense, "is not where doors.urdf has it"),
        "a hinge 20 cm beside its place": (other_hinge, "do not meet"),
        "a joint of a body that is not": (nowhere, "a validator of USD"),
    }
    stage = Usd.Stage.Open(path.as_posix())
    if first(stage, of("PhysicsRevoluteJoint")) is None:
        cases = {what: case for what, case in cases.items() if case[0] not in (radians, other_sense, other_hinge, nowhere)}
    return {what: (changed(change), word) for what, (change, word) in cases.items()}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--damage", action="store_true", help="damage the stage, too: each damage must be noticed")
    parser.add_argument("out", type=pathlib.Path, nargs="+", metavar="OUT")
    options = parser.parse_args()
    failed = False
    for out in options.out:
        try:
            judge = Judge(out)
            stage = Usd.Stage.Open(judge.path.as_posix())
        except (OSError, RuntimeError, ValueError) as why:
            print(f"{out} cannot be read: {why!r}", file=sys.stderr)
            return 2
        wrong = judge.judge(stage)
        print(
            f"{out}: {judge.n_elements} elements seen, {judge.n_collisions} shapes that collide, {judge.n_joints} joints,"
            f" {judge.n_opened} opened, {judge.path.stat().st_size // 1024} KiB"
        )
        if options.damage:
            for what, (damaged, word) in damages(judge.path).items():
                try:
                    found = [why for why in judge.judge(damaged) if word in why]
                except (AttributeError, RuntimeError, TypeError) as why:
                    found = [f"a validator of USD or the reader: {why!r}"] if word == "a validator of USD" else []
                print(f" with {what}: {found[0][:150] if found else 'nothing'}")
                if not found:
                    wrong.append(f"not noticed: {what}")
        print("\n".join(f"FAIL {out}: {why}" for why in wrong[:20]) or "PASS")
        failed |= bool(wrong)
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
