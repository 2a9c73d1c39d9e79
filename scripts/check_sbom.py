#!/usr/bin/env python3
"""Checks a bill of materials: valid by the schema of CycloneDX 1.6, and of the crates that `cargo tree` finds.

usage: target/venv/bin/python scripts/check_sbom.py groundplan.cdx.json PACKAGE...

Needs cyclonedx-python-lib with json-validation (scripts/python-env). That damages are noticed is checked, too.
"""

import json
import pathlib
import re
import subprocess
import sys

from cyclonedx.schema import SchemaVersion
from cyclonedx.validation.json import JsonStrictValidator

ROOT = pathlib.Path(__file__).resolve().parent.parent


def faults(document):
    return JsonStrictValidator(SchemaVersion.V1_6).validate_str(json.dumps(document))


def linked(packages, target):
    """Name and version of each crate that cargo links into the packages."""
    command = ["cargo", "tree", "--locked", "--offline", "--prefix", "none", "-e", "normal", "--target", target]
    command += [word for package in packages for word in ("-p", package)]
    lines = subprocess.run(command, cwd=ROOT, check=True, stdout=subprocess.PIPE, text=True).stdout.splitlines()
    return set(re.findall(r"(?m)^(\S+) v(\S+)", "\n".join(lines)))


def main():
    path, packages = sys.argv[1], sys.argv[2:]
    document = json.loads(pathlib.Path(path).read_text(encoding="utf-8"))
    if (fault := faults(document)) is not None:
        sys.exit(f"{path}: {fault}")
    components = {c["bom-ref"]: c for c in document["components"]}
    references = {d["ref"] for d in document["dependencies"]}
    dangling = {to for d in document["dependencies"] for to in d["dependsOn"]} - set(components)
    assert not dangling, dangling
    assert references - {"groundplan"} <= set(components), references
    crates = {(c["name"], c["version"]) for ref, c in components.items() if ref.startswith(("pkg:cargo/", "groundplan/"))}
    target = next(p["value"] for p in document["metadata"]["properties"] if p["name"] == "groundplan:target")
    expected = linked(packages, target)
    assert crates == expected, f"only in the bill: {crates - expected}; missing: {expected - crates}"
    for ref, found in components.items():
        assert found["licenses"], f"{ref} has no licence"
        assert not ref.startswith("pkg:cargo/") or len(found["hashes"][0]["content"]) == 64, ref
    assert "pkg:npm/three@" in " ".join(components), "the page bundles three.js"
    for damage in [
        lambda d: d["components"][0].pop("name"),
        lambda d: d.update(bomFormat="other"),
        lambda d: d["components"].append(d["components"][0]),
        lambda d: d["components"][0].update(licenses=[{"expression": 3}]),
    ]:
        damaged = json.loads(json.dumps(document))
        damage(damaged)
        assert faults(damaged) is not None, "a damage is not noticed"
    print(f"{len(components)} components, {len(crates)} of them crates; valid by CycloneDX 1.6")


main()
