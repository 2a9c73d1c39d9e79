#!/usr/bin/env python3
"""Compares exported worlds with what MuJoCo makes of them: rays, the joints of doors, and where leaves are.

    python3 scripts/check_mujoco.py OUT OPEN              judge the folders that `groundplan convert --world` and
                                                          `groundplan convert --world --doors open` wrote of one model
    python3 scripts/check_mujoco.py --self-test OUT OPEN  damage copies of OUT too; each damage must be noticed. Without ground
                                                          outdoors something has to end the way of a door, as in
                                                          demo_model.py --cabinet

Needs numpy, Pillow and mujoco. Prints a line with the verdict for each question. Exit codes: 0 all is as it should be, 1 it is not,
2 a folder cannot be read.

MuJoCo reads `doors.urdf`, `ground.xml` and the OBJ files itself; boxes and poses of `world.sdf`, which it does not read, are given to it.

- Rays from free cells of each storey's planning map, in two heights, end within a millimetre of where check_world.py lets them end,
  which cuts the same shapes at that height, and on ground outdoors within 2 cm: 99.9 % of them.
- Where storeys have heights, rays that fall on free cells end within 2 cm of them.
- Each leaf of `lookup.json` that moves has its joint, of that kind, with that axis and those limits, and there are no others.
- Each leaf at the end of its way, where it is open, is where it stands in the world whose doors are open.
- On its way it cuts into no static shape, and where the lookup says what ends its way it does cut into that a little further on.
"""
import argparse
import json
import math
import pathlib
import shutil
import sys
import tempfile
import xml.etree.ElementTree as ElementTree

import mujoco
import numpy as np

from check_world import CUBE, RANGE_M, Map, Plans, World, ground_links, judge_heights, pose_of

N_STARTS, N_DIRECTIONS = 100, 36
# Rays that fall on a storey.
N_FALLS = 4000
# Above the floor; at round heights shapes begin and end, and a ray along a face meets it or does not.
HEIGHTS_M = (0.317, 1.037)
RAY_M, RAY_GOAL = 1e-3, 0.999
# A level ray that meets a slope of 5 % a millimetre higher or lower, as plates may lie.
GROUND_RAY_M = 0.02
# Begins the names of what is of ground.xml.
GROUND = "ground/"
# Lookups and files round to these; leaves are allowed to cut this deep (gaskets, rounding), and MuJoCo knows depths to a millimetre.
LIMIT_KNOWN, PLACE_M = 1e-4, 1e-4
TOUCH_M, DEPTH_KNOWN_M = 0.004, 0.001
# Parts of its way at which a leaf is looked at, and how much further it is pushed against what ends its way.
N_STEPS = 60
FURTHER = {"revolute": math.radians(4), "prismatic": 0.04}
KINDS = {int(mujoco.mjtJoint.mjJNT_HINGE): "revolute", int(mujoco.mjtJoint.mjJNT_SLIDE): "prismatic"}
# Groups of geoms, so that rays see the static ones only.
STATIC_GROUP = 3
QUARTER_TURN = math.pi / 4


def quaternion(turn):
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, turn.flatten())
    return found


def static_collisions(folder):
    """Collisions of the static models of a world that are neither doors nor ground, with the name of their link, as World takes them."""
    ground = ground_links(folder)
    for model in ElementTree.parse(folder / "world.sdf").getroot().iter("model"):
        if (model.findtext("static") or "") == "true" and not model.get("name").startswith("door_"):
            for link in model.findall("link"):
                if not link.get("name").startswith("barrier_") and link.get("name") not in ground:
                    yield from ((link.get("name"), collision) for collision in link.findall("collision"))


class Simulation:
    """The doors and the static shapes of a world, as MuJoCo has them."""

    def __init__(self, folder):
        spec = mujoco.MjSpec.from_file(str(folder / "doors.urdf"))
        spec.compiler.fusestatic = False
        meshes = {}
        for number, (link, collision) in enumerate(static_collisions(folder)):
            turn, shift = pose_of(collision)
            placed = {"name": f"{link} {number}", "pos": shift, "quat": quaternion(turn), "group": STATIC_GROUP}
            size = collision.findtext("geometry/box/size")
            if size is not None:
                half = [float(side) / 2 for side in size.split()]
                spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=half, **placed)
                continue
            uri = collision.findtext("geometry/mesh/uri")
            if uri not in meshes:
                # Of a sheet the volume is too little to tell its inertia, which no static shape needs.
                shell = mujoco.mjtMeshInertia.mjMESH_INERTIA_SHELL
                meshes[uri] = spec.add_mesh(name=uri, file=str((folder / uri).resolve()), inertia=shell).name
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=meshes[uri], **placed)
        if has_ground(folder):
            ground = mujoco.MjSpec.from_file(str(folder / "ground.xml"))
            for number, geom in enumerate(ground.geoms):
                geom.name, geom.group = f"{geom.parent.name} plate {number}", STATIC_GROUP
            spec.attach(ground, prefix=GROUND, frame=spec.worldbody.add_frame())
        self.model = spec.compile()
        self.is_ground = np.array([self.model.geom(k).name.startswith(GROUND) for k in range(self.model.ngeom)] + [False])
        self.data = mujoco.MjData(self.model)

    def cast(self, start, directions):
        """Length of each ray to the first static shape; infinity without one in range."""
        return self.meet(start, directions)[0]

    def meet(self, start, directions):
        """The same, and the geom that each ray meets; -1 for none."""
        n = len(directions)
        groups = np.zeros(6, np.uint8)
        groups[STATIC_GROUP] = 1
        geoms, lengths = np.zeros(n, np.int32), np.zeros(n)
        mujoco.mj_multiRay(self.model, self.data, start, directions.flatten(), groups, 1, -1, geoms, lengths, None, n, RANGE_M)
        return np.where(geoms < 0, np.inf, lengths), geoms

    def fall(self, grid, looked, above):
        """The height at which a ray ends that falls from so far above the ground of each cell that is looked at."""
        found = np.full(looked.shape, -np.inf)
        for row, column in np.argwhere(looked):
            start = np.array([*(grid.origin + (np.array([column, row]) + 0.5) * grid.cell), grid.height[row, column] + above])
            lengths, _ = self.meet(start, np.array([[0.0, 0.0, -1.0]]))
            found[row, column] = start[2] - lengths[0]
        return found

    def put(self, joints):
        """Puts the leaves where these joints have these values, all others closed."""
        self.data.qpos[:] = 0
        for name, value in joints.items():
            self.data.qpos[self.model.joint(name).qposadr[0]] = value
        mujoco.mj_forward(self.model, self.data)

    def geoms_of(self, body):
        return np.flatnonzero(self.model.geom_bodyid == self.model.body(body).id)

    def boxes_of(self, body):
        """Corners of the boxes of a body, where it is now."""
        for geom in self.geoms_of(body):
            turn, at = self.data.geom_xmat[geom].reshape(3, 3), self.data.geom_xpos[geom]
            yield 2 * CUBE * self.model.geom_size[geom] @ turn.T + at

    def deepest(self, body):
        """Depth to which a body cuts into a static shape now, and the name of that."""
        own, found = set(self.geoms_of(body)), (0.0, None)
        for contact in self.data.contact[:self.data.ncon]:
            pair = set(contact.geom)
            others = [geom for geom in pair - own if self.model.geom_group[geom] == STATIC_GROUP]
            if pair & own and others and -contact.dist > found[0]:
                found = (-contact.dist, self.model.geom(others[0]).name)
        return found


def leaves_of(folder):
    """(name of the door's model, entry of the leaf) of all doors of the lookup."""
    lookup = json.loads((folder / "lookup.json").read_text(encoding="utf-8"))
    return [(door["model"], leaf) for door in lookup["doors"].values() for leaf in door["leaves"]]


def limits_of(leaf):
    return leaf["limits_rad"] or leaf["limits_m"]


def name_of(model, leaf, what):
    return f"{model}_{leaf[what]}"


def wrong_rays(out, simulation):
    """Rays of the simulation that end elsewhere than in the world of a folder: one of each storey; and how many of how many do."""
    manifest = json.loads((out / "manifest.json").read_text(encoding="utf-8"))
    world = World(out / "world")
    angles = (np.arange(N_DIRECTIONS) + 0.5) / N_DIRECTIONS * 2 * math.pi
    directions = np.stack([np.cos(angles), np.sin(angles)], 1)
    level = np.pad(directions, ((0, 0), (0, 1)))
    n_rays, n_wrong, wrong = 0, 0, []
    simulation.put({})
    for entry in manifest["storeys"]:
        starts = Map(out, entry, manifest["resolution_m"], manifest["slab_m"][0]).starts(N_STARTS)
        for height in (entry["floor_z_m"] + above for above in HEIGHTS_M):
            plans = Plans(world.plans(height - 1e-6, height + 1e-6))
            for start in starts:
                ours, (theirs, geoms) = plans.cast(start, directions), simulation.meet(np.array([*start, height]), level)
                known = np.where(simulation.is_ground[geoms], GROUND_RAY_M, RAY_M)
                off = np.abs(np.minimum(ours, RANGE_M) - np.minimum(theirs, RANGE_M)) > known
                n_rays, n_wrong = n_rays + len(off), n_wrong + off.sum()
                wrong += [f"from {start.round(2)} at {height:.2f} m towards {directions[k].round(2)}: {ours[k]:.3f} m, in MuJoCo "
                          f"{theirs[k]:.3f} m" for k in np.flatnonzero(off)[:1]]
    return wrong, n_wrong, n_rays


def wrong_joints(folder, simulation):
    """What differs between the joints of the lookup and those of MuJoCo."""
    model, wrong = simulation.model, []
    expected = {name_of(door, leaf, "joint"): leaf for door, leaf in leaves_of(folder) if leaf["kind"] != "fixed"}
    found = {model.joint(k).name for k in range(model.njnt)}
    wrong += [f"{name} is in one of lookup.json and doors.urdf only" for name in sorted(found ^ set(expected))]
    for name in sorted(found & set(expected)):
        joint, leaf = model.joint(name), expected[name]
        kind, limits = KINDS.get(int(joint.type[0])), joint.range if model.jnt_limited[joint.id] else None
        if kind != leaf["kind"]:
            wrong.append(f"{name} is {kind}, not {leaf['kind']}")
        if limits is None or np.abs(limits - limits_of(leaf)).max() > LIMIT_KNOWN:
            wrong.append(f"{name} goes from and to {limits}, not {limits_of(leaf)}")
        if np.abs(joint.axis - leaf["axis"]).max() > LIMIT_KNOWN:
            wrong.append(f"the axis of {name} is {joint.axis}, not {leaf['axis']}")
    return wrong


def standing_boxes(folder):
    """Corners of the boxes of each leaf as it stands in a world, by door and link."""
    found = {}
    for model in ElementTree.parse(folder / "world.sdf").getroot().iter("model"):
        if model.get("name").startswith("door_"):
            for link in model.findall("link"):
                chain = [pose_of(model), pose_of(link)]
                found[model.get("name"), link.get("name")] = [placed(box, chain) for box in link.findall("collision")]
    return found


def placed(collision, chain):
    corners = CUBE * np.array([float(side) for side in collision.findtext("geometry/box/size").split()])
    for turn, shift in [pose_of(collision), *reversed(chain)]:
        corners = corners @ turn.T + shift
    return corners


def open_values(folder, simulation):
    """The value of each joint at which a door is open: as far as it goes; a revolving door stands turned by an eighth."""
    joints = {}
    for door, leaf in leaves_of(folder):
        if leaf["kind"] != "fixed":
            is_revolving = len(simulation.geoms_of(name_of(door, leaf, "link"))) > 1
            farthest = max(simulation.model.joint(name_of(door, leaf, "joint")).range, key=abs)
            joints[name_of(door, leaf, "joint")] = QUARTER_TURN if is_revolving else farthest
    return joints


def wrong_places(out, opened, simulation):
    """Leaves that are elsewhere at the end of their way than in the world with open doors."""
    wrong, expected = [], standing_boxes(opened / "world")
    simulation.put(open_values(out / "world", simulation))
    for door, leaf in leaves_of(out / "world"):
        boxes = list(simulation.boxes_of(name_of(door, leaf, "link")))
        others = expected.get((door, leaf["link"]), [])
        if len(boxes) != len(others):
            wrong.append(f"{door} {leaf['link']} has {len(boxes)} boxes, and {len(others)} where it stands open")
            continue
        off = max(np.linalg.norm(a[:, None] - b[None], axis=2).min(1).max() for a, b in zip(boxes, others))
        if off > PLACE_M:
            wrong.append(f"{door} {leaf['link']} is {off:.4f} m from where it stands open")
    return wrong


def wrong_ways(folder, simulation):
    """Leaves that cut into static shapes on their way, or could go further; and how many ways are ended by something."""
    wrong, n_ended = [], 0
    for door, leaf in leaves_of(folder):
        if leaf["kind"] == "fixed":
            continue
        joint, body, limits = name_of(door, leaf, "joint"), name_of(door, leaf, "link"), limits_of(leaf)
        depths = []
        for value in np.linspace(*limits, N_STEPS + 1):
            simulation.put({joint: value})
            depths.append((*simulation.deepest(body), value))
        depth, shape, value = max(depths, key=lambda found: found[0])
        if depth > TOUCH_M + DEPTH_KNOWN_M:
            wrong.append(f"{joint} at {value:.3f} cuts {depth:.3f} m into {shape}")
        for limit, sense, ended_by in zip(limits, (-1, 1), leaf["ended_by"]):
            if ended_by is not None:
                n_ended += 1
                simulation.put({joint: limit + sense * FURTHER[leaf["kind"]]})
                depth, shape = simulation.deepest(body)
                if shape is None or depth < TOUCH_M - DEPTH_KNOWN_M:
                    wrong.append(f"{joint} could go beyond {limit:.3f}, where {ended_by} is said to end it")
    return wrong, n_ended


def answers(out, opened, simulation):
    """What the simulation says to each question: its name, the figures in words, and what is wrong."""
    world = out / "world"
    rays, n_wrong, n_rays = wrong_rays(out, simulation)
    ways, n_ended = wrong_ways(world, simulation)
    leaves = leaves_of(world)
    n_moving = sum(leaf["kind"] != "fixed" for _, leaf in leaves)
    yield "rays", f"{n_rays - n_wrong} of {n_rays} rays end where they should", rays if n_wrong > (1 - RAY_GOAL) * n_rays else []
    simulation.put({})
    n_heights, n_off, heights = judge_heights(out, lambda above: lambda grid, looked: simulation.fall(grid, looked, above), N_FALLS)
    yield "heights", f"{n_heights - n_off} of {n_heights} are those of the map", heights
    yield "joints", f"{simulation.model.njnt} in MuJoCo, {n_moving} in the lookup", wrong_joints(world, simulation)
    yield "places", f"{len(leaves)} leaves at the end of their way", wrong_places(out, opened, simulation)
    yield "ways", f"{n_moving} leaves, {n_ended} ends of ways at which something stands", ways


def verdict(out, opened):
    is_good = True
    for question, words, wrong in answers(out, opened, Simulation(out / "world")):
        is_good &= not wrong
        print(f"{'FAIL' if wrong else 'ok  '} {out.name}: {question}: {words}", flush=True)
        print("".join(f"       {line}\n" for line in wrong[:10]), end="")
    return is_good


def self_test(out, opened):
    """Gives MuJoCo damaged copies of the world: the question at which each must be noticed has to notice it."""
    is_good = verdict(out, opened)
    damages = [("joints", limit_raised), ("joints", axis_turned), ("places", leaf_moved), ("rays", meshes_moved), ("ways", way_blocked)]
    damages += [("ways", stop_removed)] if stops_of(out / "world") or not has_ground(out / "world") else []
    damages += [("heights", ground_sunk), ("heights", ground_moved)] if has_ground(out / "world") else []
    for question, damage in damages:
        with tempfile.TemporaryDirectory() as home:
            copy = pathlib.Path(home) / "world"
            shutil.copytree(out / "world", copy)
            damage(copy)
            wrong = {name: wrong for name, _, wrong in answers(out, opened, Simulation(copy))}[question]
            is_good &= bool(wrong)
            print(f"{'ok  ' if wrong else 'FAIL'} {damage.__doc__} {question}: {wrong[0] if wrong else 'not noticed'}", flush=True)
    return is_good


def edited(path, edit):
    tree = ElementTree.parse(path)
    edit(tree.getroot())
    tree.write(path)


def turning_joint(root):
    return next(joint for joint in root.iter("joint") if joint.get("type") == "revolute")


def limit_raised(world):
    """A door turns by a fifth more than the lookup says."""
    edited(world / "doors.urdf", lambda root: turning_joint(root).find("limit").set("upper", "1.9"))


def axis_turned(world):
    """A door turns about a level axis."""
    edited(world / "doors.urdf", lambda root: turning_joint(root).find("axis").set("xyz", "1 0 0"))


def leaf_moved(world):
    """A leaf hangs a hand's breadth beside its hinge."""
    def edit(root):
        origin = turning_joint(root).find("origin")
        x, y, z = map(float, origin.get("xyz").split())
        origin.set("xyz", f"{x + 0.1} {y} {z}")
    edited(world / "doors.urdf", edit)


def meshes_moved(world):
    """Meshes lie 0.05 m beside their place."""
    for path in (world / "meshes").glob("*.obj"):
        lines = [line.split() for line in path.read_text().splitlines()]
        lines = [[w[0], str(float(w[1]) + 0.05), *w[2:]] if w and w[0] == "v" else w for w in lines]
        path.write_text("".join(" ".join(words) + "\n" for words in lines))


def way_blocked(world):
    """A post stands where a door turns."""
    joint = turning_joint(ElementTree.parse(world / "doors.urdf").getroot())
    simulation = Simulation(world)
    simulation.put({joint.get("name"): float(joint.find("limit").get("upper")) / 2})
    corners = next(simulation.boxes_of(joint.find("child").get("link")))
    x, y, z = corners.mean(0)
    pose, box = f"<pose>{x} {y} {z} 0 0 0</pose>", "<geometry><box><size>0.1 0.1 1</size></box></geometry>"
    post = f'<model name="post"><static>true</static><link name="post"><collision name="c">{pose}{box}</collision></link></model>'
    edited(world / "world.sdf", lambda root: root.find("world").append(ElementTree.fromstring(post)))


def stop_removed(world):
    """What ends the way of a door is not there."""
    stops = stops_of(world)

    def edit(root):
        for model in root.iter("model"):
            for link in [link for link in model.findall("link") if link.get("name") in stops]:
                model.remove(link)
    edited(world / "world.sdf", edit)


def stops_of(world):
    """Names of what ends the way of a door."""
    return {name for _, leaf in leaves_of(world) for name in leaf["ended_by"] if name is not None}


def has_ground(world):
    return (world / "ground.xml").exists()


def ground_shifted(world, by):
    def edit(root):
        for geom in root.iter("geom"):
            geom.set("pos", " ".join(str(x) for x in np.add([float(x) for x in geom.get("pos").split()], by)))
    edited(world / "ground.xml", edit)


def ground_sunk(world):
    """The ground lies 5 cm lower."""
    ground_shifted(world, (0.0, 0.0, -0.05))


def ground_moved(world):
    """The ground lies 1 m farther east."""
    ground_shifted(world, (1.0, 0.0, 0.0))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--self-test", action="store_true", help="damage copies of the world too: each damage must be noticed")
    parser.add_argument("out", metavar="OUT", type=pathlib.Path)
    parser.add_argument("opened", metavar="OPEN", type=pathlib.Path)
    options = parser.parse_args()
    try:
        is_good = (self_test if options.self_test else verdict)(options.out, options.opened)
    except (OSError, ValueError, LookupError, TypeError, ElementTree.ParseError) as problem:
        print(f"scripts/check_mujoco.py: cannot read the folder: {type(problem).__name__}: {problem}", file=sys.stderr)
        return 2
    return 0 if is_good else 1


if __name__ == "__main__":
    sys.exit(main())
