#!/usr/bin/env python3
"""The table of IFC schemas that `common/ids` reads attributes by, made from the schemas that IfcOpenShell ships.

usage: scripts/ids_schema.py [--check]   write common/ids/src/schema.txt; --check fails if it would change

Needs ifcopenshell (scripts/python-env ifcopenshell==0.9.0.post1). A line of the table is one of

    E RELEASES NAME SUPERTYPE ATTRIBUTE=TYPE..   entity with its own attributes, in order; A instead of E: abstract
    N RELEASES NAME VALUE..                      enumeration
    T RELEASES NAME BASE                         defined type, by the EXPRESS type beneath it

RELEASES is a digit for each of 2 (IFC2X3), 4 (IFC4), 3 (IFC4X3 ADD2) that has the line; SUPERTYPE is - where there is none. TYPE
is a defined type, an enumeration, an EXPRESS type in capitals, # (an entity), ? (a select) or () (an aggregate).
"""

import pathlib
import sys

import ifcopenshell

RELEASES = {"2": "IFC2X3", "4": "IFC4", "3": "IFC4X3_ADD2"}
TABLE = pathlib.Path(__file__).resolve().parent.parent / "common/ids/src/schema.txt"


def type_of(declared):
    """The token of the type of an attribute."""
    if declared.as_aggregation_type():
        return "()"
    if declared.as_simple_type():
        return declared.as_simple_type().declared_type().upper()
    declaration = declared.as_named_type().declared_type()
    if declaration.as_entity():
        return "#"
    if declaration.as_select_type():
        return "?"
    return declaration.name()


def base_of(declaration):
    """The EXPRESS type beneath a defined type."""
    declared = declaration.declared_type()
    while declared.as_named_type():
        declaration = declared.as_named_type().declared_type()
        if not declaration.as_type_declaration():
            return "?"
        declared = declaration.declared_type()
    return "()" if declared.as_aggregation_type() else declared.as_simple_type().declared_type().upper()


def lines_of(schema):
    for declaration in schema.declarations():
        if entity := declaration.as_entity():
            parent = entity.supertype().name() if entity.supertype() else "-"
            attributes = [f"{a.name()}={type_of(a.type_of_attribute())}" for a in entity.attributes()]
            yield ("A" if entity.is_abstract() else "E", " ".join([entity.name(), parent, *attributes]))
        elif enumeration := declaration.as_enumeration_type():
            yield ("N", " ".join([enumeration.name(), *enumeration.enumeration_items()]))
        elif defined := declaration.as_type_declaration():
            yield ("T", f"{defined.name()} {base_of(defined)}")


def table():
    releases = {}
    for digit, name in RELEASES.items():
        for kind, line in lines_of(ifcopenshell.ifcopenshell_wrapper.schema_by_name(name)):
            releases.setdefault((kind, line), []).append(digit)
    rows = sorted((line, kind, "".join(digits)) for (kind, line), digits in releases.items())
    return "".join(f"{kind} {digits} {line}\n" for line, kind, digits in rows)


def main():
    text = table()
    if sys.argv[1:] == ["--check"]:
        if TABLE.read_text() != text:
            sys.exit(f"{TABLE} is not what IfcOpenShell {ifcopenshell.version} has; run scripts/ids_schema.py and read the diff")
        print(f"{TABLE.name}: {len(text.splitlines())} lines as IfcOpenShell {ifcopenshell.version} has them")
    elif sys.argv[1:]:
        sys.exit(__doc__)
    else:
        TABLE.write_text(text)


if __name__ == "__main__":
    main()
