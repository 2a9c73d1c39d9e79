#!/usr/bin/env python3
"""Links schedule files with real buildings by a property, and compares the states with the truth.

    python3 scripts/check_schedule_links.py --groundplan PROGRAM TRUTH.expected.json...

Needs ifcopenshell. TRUTH is what the corpus has beside a building with a schedule: its tasks with dates, types and products, and the
states of all elements and spaces at probe instants. The schedule is taken out of the model; the codes of its tasks are put on elements and
spaces as the property `4D_Number`, several with semicolons between them, and the tasks go into a CSV. A task that takes some elements
away and puts up others becomes two. Prints a line with the verdict for each building. Exit codes: 0 all agree, 1 one does not.
"""
import argparse
import csv
import json
import pathlib
import subprocess
import sys
import tempfile
from collections import defaultdict

import ifcopenshell
import ifcopenshell.guid

RULES = """
[[link]]
elements = { property = "Planning.4D_Number", value = "=code" }
effect = "=field:Work"
"""
REMOVES = {'DEMOLITION', 'REMOVAL', 'DISMANTLE', 'DISPOSAL'}
BUILDS = {'CONSTRUCTION', 'INSTALLATION', 'NOTDEFINED', None}
CARRIES = {'MOVE', 'LOGISTIC'}
SCHEDULE = ['IfcRelAssignsToProduct', 'IfcRelAssignsToProcess', 'IfcRelAssignsTasks', 'IfcRelSequence', 'IfcRelAssignsToControl', 'IfcTask',
            'IfcWorkControl', 'IfcWorkCalendar', 'IfcScheduleTimeControl']


def rows_of(tasks):
    """Rows of the plan, and what each works on: (row, GlobalIds). A row has the GlobalId of its task for the comparison."""
    codes = {task['guid']: f'A{10 * k:04}' for k, task in enumerate(tasks, 1)}
    for task in tasks:
        works = {'Construction': task['products'] + task['inputs']}
        if task['type'] in CARRIES:
            works = {'Construction': task['products'], 'Removal': task['inputs']}
        elif task['type'] in REMOVES:
            works = {'Removal': task['products'] + task['inputs']}
        elif task['type'] not in BUILDS:
            works = {'Inspection': task['products'] + task['inputs']}
        for work, on in works.items():
            if on or work == next(iter(works)):
                code = codes[task['guid']] + ('R' if work == 'Removal' else '')
                dates = [task['start'], task['finish']] if task['leaf'] else ['', '']
                yield [code, task['name'], codes.get(task['parent'], ''), *(date or '' for date in dates), work], on, task['guid']


def write_model(source, numbers, path):
    """The model without its schedule, with the numbers of tasks on its elements and spaces; how many have one."""
    model = ifcopenshell.open(source)
    for entity in SCHEDULE:
        try:
            found = list(model.by_type(entity))
        except RuntimeError:             # not in this schema
            continue
        for instance in found:
            model.remove(instance)
    owner = next(iter(model.by_type('IfcOwnerHistory')), None)
    n = 0
    for global_id, codes in numbers.items():
        value = model.create_entity('IfcLabel', '; '.join(codes))
        number = model.create_entity('IfcPropertySingleValue', '4D_Number', None, value)
        properties = model.create_entity('IfcPropertySet', ifcopenshell.guid.new(), owner, 'Planning', None, [number])
        model.create_entity('IfcRelDefinesByProperties', ifcopenshell.guid.new(), owner, None, None, [model.by_guid(global_id)], properties)
        n += 1
    model.write(str(path))
    return n


def check(program, truth_path):
    """Differences between the states and the truth, and how many elements and instants were compared."""
    truth = json.loads(truth_path.read_text())
    source = truth_path.with_name(truth['output'])
    rows, numbers, task_of = [], defaultdict(list), {}
    for row, on, guid in rows_of(truth['tasks']):
        rows.append(row)
        task_of[row[0]] = guid
        for global_id in on:
            if row[0] not in numbers[global_id]:
                numbers[global_id].append(row[0])
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        model, plan, rules = folder / 'model.ifc', folder / 'plan.csv', folder / 'rules.toml'
        n = write_model(source, numbers, model)
        with plan.open('w', newline='', encoding='utf-8') as file:
            csv.writer(file).writerows([['Activity ID', 'Activity Name', 'Parent', 'Start', 'Finish', 'Work'], *rows])
        rules.write_text(RULES)
        dates = [argument for probe in truth['probes'] for argument in ('--date', probe['at'])]
        run = subprocess.run([program, 'states', model, '--json', '--schedule', rules, '--schedule-file', plan, *dates],
                             check=True, capture_output=True, text=True)
    states = json.loads(run.stdout)
    differences = []
    for found, expected in zip(states, truth['probes'], strict=True):
        for global_id, state in expected['elements'].items():
            if found['elements'].get(global_id) != state:
                differences.append(f"{expected['at']} element {global_id}: {found['elements'].get(global_id)}, is {state}")
        for global_id, state in expected['spaces'].items():
            is_found = dict(found['spaces'].get(global_id, {}))
            is_found['why'] = sorted({named(why, task_of) for why in is_found.get('why', [])})
            if is_found != {**state, 'why': sorted(state.get('why', []))}:
                differences.append(f"{expected['at']} space {global_id}: {is_found}, is {state}")
    return differences, f"{n} of {len(truth['elements']) + len(truth['spaces'])} elements and spaces numbered, {len(states)} instants"


def named(why, task_of):
    kind, _, task = why.partition(':')
    return f'task:{task_of.get(task, task)}' if kind == 'task' else why


def main():
    parser = argparse.ArgumentParser(description='Links schedule files with buildings by a property and compares states with the truth.')
    parser.add_argument('--groundplan', required=True, type=pathlib.Path, metavar='PROGRAM', help='the client')
    parser.add_argument('truths', nargs='+', type=pathlib.Path, metavar='TRUTH.expected.json')
    options = parser.parse_args()
    is_wrong = False
    for truth in options.truths:
        differences, said = check(options.groundplan, truth)
        print(f"{'FAIL' if differences else 'ok  '} {truth.name.removesuffix('.expected.json')}: {said}", flush=True)
        for difference in differences[:5]:
            print(f'     {difference}')
        if len(differences) > 5:
            print(f'     and {len(differences) - 5} more')
        is_wrong |= bool(differences)
    sys.exit(is_wrong)


if __name__ == '__main__':
    main()
