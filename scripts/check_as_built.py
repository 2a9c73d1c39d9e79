#!/usr/bin/env python3
"""Judges what `groundplan as-built` writes with IfcOpenShell, which knows nothing of groundplan.

    bash scripts/python-env ifcopenshell==0.9.0.post1 numpy pytest==8.4.2
    target/venv/bin/python scripts/check_as_built.py --groundplan target/debug/groundplan [--corpus FOLDER]

Models: the demo building (IFC4), a small building of each schema made here, and of a folder of buildings those that are there. In each
a task or element is reported, an element is absent, one is displaced, and something stands there that the model does not have. Then

- bytes: the old file with the lines of the list of changes is the new one;
- valid: ifcopenshell.validate has no finding in the new file that it did not have in the old one; of the small buildings with the
  rules of the schema (which need pytest), of larger ones without, since these take minutes;
- others: every entity that the list does not name is as it was, and none is gone;
- places: products have the placements that they had, but for the displaced one and what moves along, by the vector that was given;
- progress: tasks and property sets say what was reported, for these elements and no others;
- proxy: the body of what was added has the outline and height that were given.

Each of these notices a damage that is done to the new file (self-test). Exit codes: 0 as it should be, 1 not.
"""

import argparse
import collections
import hashlib
import json
import math
import pathlib
import subprocess
import sys
import tempfile

import ifcopenshell
import ifcopenshell.geom
import ifcopenshell.guid
import ifcopenshell.util.element
import ifcopenshell.util.placement
import ifcopenshell.util.unit
import ifcopenshell.validate
import numpy

ROOT = pathlib.Path(__file__).resolve().parent.parent
SET = "Groundplan_AsBuilt"
OFFSET_M = [0.07, -0.04]
SQUARE_M = [[1.0, 1.0], [1.6, 1.0], [1.6, 1.4], [1.0, 1.4]]
SEEN = "2024-04-06T10:00:00"
FINISH = "2024-03-20T10:00:00"
BUILDINGS = ["AC20-FZK-Haus.ifc", "Ifc2x3_Duplex_Architecture.ifc", "PCERT-Building-Architecture-IFC4X3.ifc"]


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--groundplan", type=pathlib.Path, required=True)
    arguments.add_argument("--corpus", type=pathlib.Path, help="folder of buildings")
    options = arguments.parse_args()
    is_well = True
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        cases = [(ROOT / "config/demo/demo.ifc", False)]
        cases += [(small_building(schema, folder), True) for schema in ["IFC2X3", "IFC4", "IFC4X3"]]
        if options.corpus:
            cases += [(options.corpus / name, False) for name in BUILDINGS if (options.corpus / name).is_file()]
        for number, (model, with_rules) in enumerate(cases):
            case = Case(options.groundplan, model, folder / str(number))
            faults = case.judge(case.new.read_bytes(), with_rules)
            for part, found in faults.items():
                print(f"{'FAIL' if found else 'ok  '} {model.name}: {part}" + "".join(f"\n     {fault}" for fault in found[:5]))
                is_well &= not found
            if model.name == "small-IFC4.ifc":
                is_well &= case.notices_damages()
    return 0 if is_well else 1


class Case:
    """A model, what is observed of it, and the new model."""

    def __init__(self, groundplan, model, folder):
        folder.mkdir()
        self.model, self.new, self.changes = model, folder / "new.ifc", folder / "changes.json"
        self.old = ifcopenshell.open(str(model))
        self.yaw, storey, floor_z_m = frame_of(groundplan, model, folder)
        elements = [e for e in self.old.by_type("IfcElement") if e.Representation and e.ObjectPlacement and not e.is_a("IfcFeatureElement")]
        # What moves along with another is neither absent nor reported here.
        walls = [e for e in elements if e.is_a("IfcWall")] or elements
        self.displaced = next((wall for wall in walls if wall.HasOpenings), walls[0])
        along = {e.GlobalId for e in self.dependents(self.displaced)}
        others = [e for e in elements if e.GlobalId not in along and e != self.displaced and e.GlobalId != self.displaced.GlobalId]
        self.absent, self.built = others[0], others[1]
        tasks = self.old.by_type("IfcTask")
        self.task = next((t for t in tasks if t.is_a("IfcTask") and not any(r.RelatedObjects for r in t.IsNestedBy)), None) if self.old.schema != "IFC2X3" else next(iter(tasks), None)
        rows = [["id", "start", "finish"], [self.built.GlobalId, "", FINISH], [self.absent.GlobalId, "absent", ""]]
        if self.task:
            rows.append([self.task.GlobalId, "2024-03-04T08:00:00", FINISH])
        table = folder / "progress.csv"
        table.write_text("".join(",".join(row) + "\n" for row in rows))
        self.table_sha256 = hashlib.sha256(table.read_bytes()).hexdigest()
        self.lidar_m = 0.3
        evidence = {"observation": "displaced", "judgement": "displaced", "displacement_m": OFFSET_M, "deviation_m": 0.01, "absent_parts": []}
        deviations = folder / "deviations.json"
        deviations.write_text(json.dumps({
            "plan_time": SEEN, "storey": storey, "lidar_z_m": floor_z_m + self.lidar_m, "slam_map_hash": "0",
            "elements": {self.displaced.GlobalId: evidence},
            "obstacles": [{"area_m2": 0.24, "polygon_m": [SQUARE_M]}, {"area_m2": 0.24, "polygon_m": [SQUARE_M]}],
        }))
        command = [groundplan, "as-built", model, "-o", self.new, "--changes", self.changes, "--actuals", table, "--deviations", deviations,
                   "--confirm", self.displaced.GlobalId, "--confirm", "1"]
        subprocess.run(command, check=True, capture_output=True, text=True)
        self.list = json.loads(self.changes.read_text())
        again = folder / "again.ifc"
        subprocess.run([again if word == self.new else word for word in command if word not in ("--changes", self.changes)], check=True, capture_output=True)
        if again.read_bytes() != self.new.read_bytes():
            sys.exit(f"{model.name}: the same input gives other bytes")
        if [one["row"] for one in self.list["not_written"]] != ["obstacle 2"]:
            sys.exit(f"{model.name}: not written: {self.list['not_written']}")

    def dependents(self, element):
        found = [relation.RelatedOpeningElement for relation in element.HasOpenings]
        found += [filling.RelatedBuildingElement for opening in found for filling in opening.HasFillings]
        found += [part for relation in element.IsDecomposedBy for part in relation.RelatedObjects]
        return found

    def judge(self, bytes_, with_rules, only=None):
        """Faults of a new file by what is looked at: everything, or one of it."""
        path = self.new.parent / "judged.ifc"
        path.write_bytes(bytes_)
        faults = {"bytes": self.bytes_(bytes_)}
        try:
            new = ifcopenshell.open(str(path))
        except Exception as error:
            return faults | {"valid": [f"it cannot be read: {error}"]}
        if only in (None, "valid"):
            faults["valid"] = self.valid(path, with_rules)
        for part in [self.others, self.places, self.progress, self.proxy]:
            if only not in (None, part.__name__):
                continue
            try:
                faults[part.__name__] = part(new)
            except Exception as error:
                faults[part.__name__] = [f"it cannot be judged: {type(error).__name__} {error}"]
        return faults

    def bytes_(self, new):
        old, added = self.model.read_bytes(), b""
        end = b"\r\n" if b"\r\n" in old[:2000] else b"\n"
        for line in self.list["lines"]:
            text = line["new"].encode("latin-1", "replace")
            if line["change"] == "added":
                added += text + end
            elif old.count(line["old"].encode()) != 1:
                return [f"the old line is not in the file: {line['old']}"]
            else:
                old = old.replace(line["old"].encode(), line["new"].encode())
        at = old.rfind(b"ENDSEC;")
        return [] if old[:at] + added + old[at:] == new else ["the lines of the list do not make the new file"]

    def valid(self, path, with_rules):
        found = findings(path, with_rules) - findings(self.model, with_rules)
        return [f"{n} x {text}" for text, n in found.items()]

    def others(self, new):
        listed = {line["id"] for line in self.list["lines"]}
        faults = []
        for entity in self.old:
            if entity.id() in listed:
                continue
            try:
                if str(new.by_id(entity.id())) != str(entity):
                    faults.append(f"it is another one: {entity}")
            except RuntimeError:
                faults.append(f"it is gone: {entity}")
        known = {entity.id() for entity in self.old}
        either = known | listed
        faults += [f"it is new and not listed: {entity}" for entity in new if entity.id() not in either]
        ids = collections.Counter(root.GlobalId for root in new.by_type("IfcRoot"))
        before = collections.Counter(root.GlobalId for root in self.old.by_type("IfcRoot"))
        faults += [f"GlobalId {i} is there {n} times" for i, n in ids.items() if n > max(1, before[i])]
        greatest = max(known)
        return faults + [f"#{line['id']} is not above the old ones" for line in self.list["lines"] if line["change"] == "added" and line["id"] <= greatest]

    def places(self, new):
        unit = ifcopenshell.util.unit.calculate_unit_scale(self.old)
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        # From the frame of the maps into the world.
        by = numpy.array([cos * OFFSET_M[0] + sin * OFFSET_M[1], -sin * OFFSET_M[0] + cos * OFFSET_M[1], 0.0])
        along = {e.GlobalId for e in self.dependents(self.displaced)} | {self.displaced.GlobalId}
        faults = []
        for product in self.old.by_type("IfcProduct"):
            if not product.ObjectPlacement:
                continue
            place = lambda file: ifcopenshell.util.placement.get_local_placement(file.by_guid(product.GlobalId).ObjectPlacement)
            before, after = place(self.old), place(new)
            moved = (after[:3, 3] - before[:3, 3]) * unit
            expected = by if product.GlobalId in along else numpy.zeros(3)
            if numpy.abs(moved - expected).max() > 2e-6 or numpy.abs(after[:3, :3] - before[:3, :3]).max() > 1e-9:
                faults.append(f"{product.is_a()} {product.GlobalId} moved by {moved}, not {expected}")
        return faults

    def progress(self, new):
        faults = []
        proxy = next(o["global_id"] for o in self.list["observations"] if o["kind"] == "additional")
        expected = {
            self.built.GlobalId: {"Observation": "built", "ActualFinish": FINISH},
            self.absent.GlobalId: {"Observation": "absent"},
            self.displaced.GlobalId: {"Observation": "displaced"},
            proxy: {"Observation": "additional", "ActualFinish": SEEN},
        }
        for element in new.by_type("IfcElement"):
            said = ifcopenshell.util.element.get_psets(element, psets_only=True, should_inherit=False).get(SET)
            wanted = expected.pop(element.GlobalId, None)
            if (said is None) != (wanted is None):
                faults.append(f"{element.is_a()} {element.GlobalId}: {said}, not {wanted}")
            elif said:
                faults += [f"{element.GlobalId}.{name}: {said.get(name)}, not {value}" for name, value in wanted.items() if said.get(name) != value]
                if element.GlobalId in (self.built.GlobalId, self.absent.GlobalId) and said["EvidenceSha256"] != self.table_sha256:
                    faults.append(f"{element.GlobalId}: the evidence has another sha256")
                if not said["Observer"]:
                    faults.append(f"{element.GlobalId}: nobody observed it")
        faults += [f"{i} is gone" for i in expected]
        tasks = [self.task.GlobalId] if self.task else []
        for task in tasks:
            start, finish, done = times_of(new, new.by_guid(task))
            if (start, finish, done) != ("2024-03-04T08:00:00", FINISH, 1.0):
                faults.append(f"task {task}: {start} {finish} {done}")
        listed = {line["element"] for line in self.list["lines"]}
        for task in self.old.by_type("IfcTask"):
            if task.GlobalId not in listed and times_of(self.old, task) != times_of(new, new.by_guid(task.GlobalId)):
                faults.append(f"task {task.GlobalId} has other dates")
        last = max(entity.id() for entity in self.old)
        faults += [f"{root} has no owner history" for root in new.by_type("IfcRoot") if root.id() > last and not root.OwnerHistory]
        return faults

    def proxy(self, new):
        proxy = new.by_guid(next(o["global_id"] for o in self.list["observations"] if o["kind"] == "additional"))
        settings = ifcopenshell.geom.settings()
        settings.set("use-world-coords", True)
        shape = ifcopenshell.geom.create_shape(settings, proxy)
        corners = numpy.array(shape.geometry.verts).reshape(-1, 3)
        cos, sin = math.cos(self.yaw), math.sin(self.yaw)
        turned = numpy.column_stack([corners[:, 0] * cos - corners[:, 1] * sin, corners[:, 0] * sin + corners[:, 1] * cos, corners[:, 2]])
        size = turned.max(axis=0) - turned.min(axis=0)
        faults = [f"it is {size} m large"] if numpy.abs(size - [0.6, 0.4, self.lidar_m]).max() > 1e-5 else []
        if numpy.abs(turned[:, :2].min(axis=0) + self.translation - [1.0, 1.0]).max() > 1e-4:
            faults.append(f"it lies at {turned.min(axis=0)}")
        if not proxy.ContainedInStructure:
            faults.append("it is in no storey")
        return faults

    @property
    def translation(self):
        return numpy.array(self._translation)

    def notices_damages(self):
        """True if every part notices a damage of what it looks at."""
        good = self.new.read_bytes()
        added = [line for line in self.list["lines"] if line["change"] == "added"]
        find = lambda entity: next(line["new"] for line in added if f"={entity}(" in line["new"]).encode()
        point = next(line["new"] for line in added if "IFCCARTESIANPOINT" in line["new"]).encode()
        history, solid, finish = find("IFCOWNERHISTORY"), find("IFCEXTRUDEDAREASOLID"), f"'{FINISH}'".encode()
        property_set = find("IFCPROPERTYSET")
        wall = next(line for line in good.split(b"\n") if b"=IFCWALL(" in line)
        global_id = wall.split(b"'")[1]
        damages = [
            ("bytes", good + b"\n"),
            ("valid", good.replace(history, history.replace(b".ADDED.", b".MADE."))),
            ("valid", good.replace(property_set, property_set.replace(b"'Groundplan_AsBuilt'", b"$"))),
            ("others", good.replace(b"IFCBUILDINGSTOREY(", b"IFCBUILDINGSTOREY(", 1).replace(wall, wall.replace(b"$", b"'x'", 1))),
            ("others", good.replace(wall + b"\n", b"")),
            ("others", good.replace(property_set, property_set.replace(property_set.split(b"'")[1], global_id, 1))),
            ("places", good.replace(point, point.replace(b"((", b"((1"))),
            ("progress", good.replace(finish, b"'2024-03-21T10:00:00'")),
            ("progress", good.replace(b"IFCLABEL('absent')", b"IFCLABEL('built')")),
            ("progress", good.replace(self.table_sha256.encode(), b"0" * 64)),
            ("proxy", good.replace(solid, solid[:-2] + b"1);")),
        ]
        is_well = True
        for number, (part, damaged) in enumerate(damages):
            noticed = damaged != good and bool(self.judge(damaged, True, part).get(part))
            print(f"{'ok  ' if noticed else 'FAIL'} self-test: damage {number} is noticed by {part}")
            is_well &= noticed
        return is_well


def frame_of(groundplan, model, folder):
    """Yaw of the maps in the world, the lowest storey with a map that a file's storey has, and the height of its floor in the maps."""
    out = folder / "maps"
    subprocess.run([groundplan, "convert", model, "-o", out, "--allow-empty", "--allow-boxes"], check=True, capture_output=True)
    manifest = json.loads((out / "manifest.json").read_text())
    motion = manifest["frames"]["map_from_world"]
    Case._translation = [motion["x_m"], motion["y_m"]]
    storeys = {s.GlobalId for s in ifcopenshell.open(str(model)).by_type("IfcBuildingStorey")}
    storey = next(storey for storey in manifest["storeys"] if storey["global_id"] in storeys)
    return motion["yaw_rad"], storey["index"], storey["floor_z_m"]


def findings(path, with_rules):
    """What ifcopenshell.validate says, without numbers of instances that differ between the files."""
    logger = ifcopenshell.validate.json_logger()
    ifcopenshell.validate.validate(str(path), logger, express_rules=with_rules)
    text = lambda statement: json.dumps({k: str(v).split("\n")[0] for k, v in statement.items() if k in ("level", "type", "attribute", "message")}, sort_keys=True)
    return collections.Counter(text(statement) for statement in logger.statements)


def times_of(file, task):
    """Actual start, actual finish and completion."""
    if file.schema != "IFC2X3":
        time = task.TaskTime
        return (time.ActualStart, time.ActualFinish, time.Completion) if time else (None, None, None)
    times = [relation.TimeForTask for relation in file.by_type("IfcRelAssignsTasks") if task in relation.RelatedObjects and relation.TimeForTask]
    if not times:
        return None, None, None
    date = lambda at: at and f"{at.DateComponent.YearComponent:04}-{at.DateComponent.MonthComponent:02}-{at.DateComponent.DayComponent:02}T{at.TimeComponent.HourComponent:02}:{at.TimeComponent.MinuteComponent or 0:02}:{int(at.TimeComponent.SecondComponent or 0):02}"
    return date(times[0].ActualStart), date(times[0].ActualFinish), times[0].Completion


def small_building(schema, folder):
    """Four walls, one with an opening and a door, on a slab, and a task, turned by 30 degrees."""
    file = ifcopenshell.file(schema=schema)
    number = iter(range(1, 1000))
    guid = lambda: ifcopenshell.guid.compress(hashlib.md5(f"{schema}{next(number)}".encode()).hexdigest())
    history = None
    if schema == "IFC2X3":
        person = file.create_entity("IfcPerson", FamilyName="Planner")
        organisation = file.create_entity("IfcOrganization", Name="Office")
        both = file.create_entity("IfcPersonAndOrganization", person, organisation)
        application = file.create_entity("IfcApplication", organisation, "1", "Editor", "editor")
        history = file.create_entity("IfcOwnerHistory", both, application, None, "ADDED", None, None, None, 1700000000)
    point = lambda *c: file.create_entity("IfcCartesianPoint", [float(x) for x in c])
    direction = lambda *c: file.create_entity("IfcDirection", [float(x) for x in c])
    axes = lambda at, x=(1, 0, 0): file.create_entity("IfcAxis2Placement3D", point(*at), direction(0, 0, 1), direction(*x))
    place = lambda to, at, x=(1, 0, 0): file.create_entity("IfcLocalPlacement", to, axes(at, x))
    units = [file.create_entity("IfcSIUnit", None, "LENGTHUNIT", "MILLI", "METRE"), file.create_entity("IfcSIUnit", None, "AREAUNIT", None, "SQUARE_METRE"),
             file.create_entity("IfcSIUnit", None, "VOLUMEUNIT", None, "CUBIC_METRE"), file.create_entity("IfcSIUnit", None, "PLANEANGLEUNIT", None, "RADIAN"),
             file.create_entity("IfcSIUnit", None, "TIMEUNIT", None, "SECOND")]
    context = file.create_entity("IfcGeometricRepresentationContext", None, "Model", 3, 1e-5, axes((0, 0, 0)))
    root = lambda kind, **more: file.create_entity(kind, GlobalId=guid(), OwnerHistory=history, **more)
    project = root("IfcProject", Name="P", RepresentationContexts=[context], UnitsInContext=file.create_entity("IfcUnitAssignment", units))
    site_place = place(None, (0, 0, 0), (math.cos(math.pi / 6), math.sin(math.pi / 6), 0))
    site = root("IfcSite", Name="S", ObjectPlacement=site_place, CompositionType="ELEMENT")
    building_place = place(site_place, (5000, 0, 0))
    building = root("IfcBuilding", Name="B", ObjectPlacement=building_place, CompositionType="ELEMENT")
    storey_place = place(building_place, (0, 0, 1000))
    storey = root("IfcBuildingStorey", Name="Ground", ObjectPlacement=storey_place, CompositionType="ELEMENT", Elevation=1000.0)
    for whole, part in [(project, site), (site, building), (building, storey)]:
        root("IfcRelAggregates", RelatingObject=whole, RelatedObjects=[part])

    def box(size):
        corner = file.create_entity("IfcRectangleProfileDef", "AREA", None, file.create_entity("IfcAxis2Placement2D", point(size[0] / 2, size[1] / 2), direction(1, 0)), float(size[0]), float(size[1]))
        solid = file.create_entity("IfcExtrudedAreaSolid", corner, axes((0, 0, 0)), direction(0, 0, 1), float(size[2]))
        shape = file.create_entity("IfcShapeRepresentation", context, "Body", "SweptSolid", [solid])
        return file.create_entity("IfcProductDefinitionShape", None, None, [shape])

    def element(kind, at, size, to=storey_place, **more):
        return root(kind, Name=kind, ObjectPlacement=place(to, at), Representation=box(size), **more)

    walls = [element("IfcWall", at, size) for at, size in [((0, 0, 0), (6000, 200, 2800)), ((0, 4000, 0), (6000, 200, 2800)), ((0, 200, 0), (200, 3800, 2800)), ((5800, 200, 0), (200, 3800, 2800))]]
    slab = element("IfcSlab", (0, 0, -200), (6000, 4200, 200), PredefinedType="FLOOR")
    column = element("IfcColumn", (3000, 2000, 0), (300, 300, 2800))
    opening = element("IfcOpeningElement", (1000, -50, 0), (1000, 300, 2100), walls[0].ObjectPlacement)
    door = element("IfcDoor", (1000, 50, 0), (1000, 50, 2100), OverallWidth=1000.0, OverallHeight=2100.0)
    root("IfcRelVoidsElement", RelatingBuildingElement=walls[0], RelatedOpeningElement=opening)
    root("IfcRelFillsElement", RelatingOpeningElement=opening, RelatedBuildingElement=door)
    root("IfcRelContainedInSpatialStructure", RelatedElements=[*walls, slab, column, door], RelatingStructure=storey)
    if schema == "IFC2X3":
        task = root("IfcTask", Name="Column", TaskId="1", IsMilestone=False)
    else:
        time = file.create_entity("IfcTaskTime", ScheduleStart="2024-03-04T08:00:00", ScheduleFinish="2024-03-08T17:00:00")
        task = root("IfcTask", Name="Column", Identification="1", IsMilestone=False, TaskTime=time, PredefinedType="CONSTRUCTION")
    root("IfcRelAssignsToProduct", RelatedObjects=[task], RelatingProduct=column)
    path = folder / f"small-{schema}.ifc"
    file.write(str(path))
    return path


if __name__ == "__main__":
    sys.exit(main())
