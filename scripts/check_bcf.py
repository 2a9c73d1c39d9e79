#!/usr/bin/env python3
"""Reads BCF files of groundplan with bcf-client, and compares what it finds with what was asked for.

usage: scripts/check_bcf.py FILE.bcfzip.. [--closed GLOBALID].. [--self-test]

Every document is parsed against the classes that bcf-client has made from the schemas of BCF 2.1 and 3.0, which refuse elements and
attributes that a schema does not have and ask for those that it requires. Each topic has a title, a status, a viewpoint with a camera,
a selection or lines, and a picture that is a PNG file. With --closed, topics about that element are closed and have a comment.
With --self-test copies of the files are damaged, and each damage has to be noticed. Needs bcf-client.
Exit codes: 0 all is well, 1 something is wrong, 2 bad usage.
"""
import argparse
import io
import pathlib
import re
import struct
import sys
import tempfile
import zipfile

from xsdata.formats.dataclass.parsers import XmlParser
from xsdata.formats.dataclass.parsers.config import ParserConfig

import bcf.v2.model as v2
import bcf.v3.model as v3
from bcf.bcfxml import load

GUID = re.compile(r"[0-9a-f]{8}(-[0-9a-f]{4}){3}-[0-9a-f]{12}")


def strict(bytes_, model):
    """The document, if it has what the schema asks for and nothing else."""
    config = ParserConfig(fail_on_unknown_properties=True, fail_on_unknown_attributes=True, fail_on_converter_warnings=True)
    return XmlParser(config=config).from_bytes(bytes_, model)


def is_in_order(bytes_, names):
    """True if children of the topic are in the order of the schema, which xsdata does not ask for."""
    found = re.findall(rb"<(\w+)", re.search(rb"<Topic .*?>(.*?)</Topic>", bytes_, re.S).group(1))
    places = [names.index(name.decode()) for name in found if name.decode() in names]
    return places == sorted(places)


TOPIC_ORDER = ["ReferenceLink", "ReferenceLinks", "Title", "Priority", "Index", "Labels", "CreationDate", "CreationAuthor", "ModifiedDate",
               "ModifiedAuthor", "DueDate", "AssignedTo", "Stage", "Description", "BimSnippet", "Comments", "Viewpoints"]


def faults(path, closed=()):
    """What is wrong with a file."""
    wrong = []
    with zipfile.ZipFile(path) as archive:
        if archive.testzip():
            return ["a file in it is damaged"]
        files = {name: archive.read(name) for name in archive.namelist()}
    version = re.search(rb'VersionId="([\d.]+)"', files.get("bcf.version", b""))
    if not version:
        return ["it has no version"]
    is_3 = version.group(1) == b"3.0"
    model = v3 if is_3 else v2
    if is_3:
        if "extensions.xml" not in files:
            wrong.append("version 3.0 without extensions.xml")
        else:
            strict(files["extensions.xml"], model.Extensions)
    n_topics, seen_closed = 0, set()
    for name in sorted(files):
        if not name.endswith("/markup.bcf"):
            continue
        n_topics += 1
        folder = name.rsplit("/", 1)[0]
        markup = strict(files[name], model.Markup)
        topic = markup.topic
        words = ("guid", "title", "topic_status", "topic_type", "creation_date", "creation_author")
        missing = [word for word in words if not getattr(topic, word)]
        wrong += [f"{folder}: the topic has no {word}" for word in missing]
        if topic.guid != folder or not GUID.fullmatch(folder):
            wrong.append(f"{folder}: the topic is {topic.guid}")
        if not is_in_order(files[name], TOPIC_ORDER if is_3 else TOPIC_ORDER[:-2]):
            wrong.append(f"{folder}: elements of the topic are in another order than that of the schema")
        comments = (topic.comments.comment if topic.comments else []) if is_3 else markup.comment
        points = (topic.viewpoints.view_point if topic.viewpoints else []) if is_3 else markup.viewpoints
        components = set()
        if not points:
            wrong.append(f"{folder}: there is no viewpoint")
        for point in points:
            view = strict(files.get(f"{folder}/{point.viewpoint}", b""), model.VisualizationInfo)
            camera = view.orthogonal_camera
            if view.guid != point.guid:
                wrong.append(f"{folder}: the viewpoint {point.guid} is {view.guid}")
            if camera is None or not camera.view_to_world_scale > 0 or (is_3 and not camera.aspect_ratio > 0):
                wrong.append(f"{folder}: there is no camera")
            selected = view.components.selection.component if view.components and view.components.selection else []
            if not selected and not view.lines:
                wrong.append(f"{folder}: nothing is selected or drawn")
            components |= {component.ifc_guid for component in selected}
            picture = files.get(f"{folder}/{point.snapshot}", b"")
            if picture[:8] != b"\x89PNG\r\n\x1a\n" or min(struct.unpack(">II", picture[16:24])) < 100:
                wrong.append(f"{folder}: there is no picture")
        for global_id in components & set(closed):
            if topic.topic_status == "Closed" and comments and all(c.comment for c in comments):
                seen_closed.add(global_id)
            else:
                wrong.append(f"{folder}: the topic of {global_id} is {topic.topic_status}, with {len(comments)} comments")
    wrong += [f"there is no topic of {global_id}" for global_id in set(closed) - seen_closed]
    if not n_topics:
        wrong.append("there are no topics")
    # The program's own reader, as people use it.
    with load(str(path)) as container:
        if len(container.topics) != n_topics:
            wrong.append(f"bcf-client reads {len(container.topics)} of {n_topics} topics")
    return wrong


def checked(path, closed=()):
    try:
        return faults(path, closed)
    except Exception as error:  # A parser that refuses has judged.
        return [f"{type(error).__name__}: {error}"]


DAMAGES = {
    "a topic without a title": ("markup.bcf", rb"<Title>.*?</Title>", b""),
    "a topic of another folder": ("markup.bcf", rb'(<Topic Guid=")........', rb"\g<1>00000000"),
    "an element that no schema has": ("markup.bcf", rb"<CreationAuthor>", b"<Creator>x</Creator><CreationAuthor>"),
    "elements in another order": ("markup.bcf", rb"(<Title>.*?</Title>)(.*?)(<CreationAuthor>)", rb"\2\1\3"),
    "a viewpoint with another name": ("viewpoint.bcfv", rb'Guid="........', b'Guid="00000000'),
    "no camera": ("viewpoint.bcfv", rb"<OrthogonalCamera>.*?</OrthogonalCamera>", b""),
    "a place that is no number": ("viewpoint.bcfv", rb"<X>.*?</X>", b"<X>east</X>"),
    "a picture that is none": ("snapshot.png", rb"\A.*\Z", b"no picture"),
}


def damaged(path, damage, out):
    """A copy with the first file of a kind damaged; false if there is nothing to damage."""
    end, pattern, by = damage
    done = False
    with zipfile.ZipFile(path) as archive, zipfile.ZipFile(out, "w") as copy:
        for name in archive.namelist():
            content = archive.read(name)
            if not done and name.endswith(end):
                other = re.sub(pattern, by, content, count=1, flags=re.S)
                done, content = other != content, other
            copy.writestr(name, content)
    return done


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("files", nargs="+", type=pathlib.Path, metavar="FILE.bcfzip")
    parser.add_argument("--closed", action="append", default=[], metavar="GLOBALID")
    parser.add_argument("--self-test", action="store_true")
    arguments = parser.parse_args()
    failed = False
    for path in arguments.files:
        wrong = checked(path, arguments.closed)
        print(f"{'FAIL' if wrong else 'ok  '} {path}")
        print("".join(f"     {text}\n" for text in wrong[:20]), end="")
        failed |= bool(wrong)
        if arguments.self_test and not wrong:
            for name, damage in DAMAGES.items():
                with tempfile.TemporaryDirectory() as folder:
                    out = pathlib.Path(folder) / "damaged.bcfzip"
                    if not damaged(path, damage, out) or not checked(out, arguments.closed):
                        print(f"FAIL {path}: {name} was not noticed")
                        failed = True
    return int(failed)


if __name__ == "__main__":
    sys.exit(main())
