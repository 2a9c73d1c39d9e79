#!/usr/bin/env python3
"""Makes the pictures in config/demo from the demo building, with the programs as they are.

usage: scripts/shots.py [--programs target/debug] [--only WORD] [--check]

--only   those whose name has this word
--check  writes nothing, and compares the pictures of maps with those that are there, pixel by pixel: they depend on model, schedule
         and program alone. Screens of the page, the monitor and the world, which depend on browser and fonts too, are not compared.
Needs numpy and Pillow; for the world trimesh, for the monitor pyte, for screens selenium and Chromium with its driver:
scripts/python-env numpy pillow==11.3.0 trimesh==5.2.0 pyte==0.8.2 selenium. What cannot be made is said. Exit codes: 0 done, 1 a
picture differs or was not made.
"""

import argparse
import fcntl
import html
import io
import json
import os
import pathlib
import pty
import select
import shutil
import struct
import subprocess
import sys
import tempfile
import termios
import time

import numpy as np
from PIL import Image, ImageChops

ROOT = pathlib.Path(__file__).resolve().parent.parent
DEMO = ROOT / "config/demo"
MODEL, PLAN = DEMO / "demo.ifc", DEMO / "demo-schedule.xer"
PARTITION = "G.meeting-store"
# Corners of a box that no model has, in metres.
BOX_M = (18.0, 3.2, 18.6, 3.7)
OFFICE = "1sKGhI2trIeezvns$ocK_O"
BEFORE, AFTER = "2024-04-15T08:00", "2024-05-13T08:00"
MAPS, SCREENS = {}, {}


def picture(of, name):
    """Registers what makes a picture."""
    return lambda make: of.setdefault(name, make)


class Demo:
    """The programs, and what they have made, each once."""

    def __init__(self, programs, folder):
        self.programs, self.folder = programs, folder

    def run(self, *words):
        done = subprocess.run([self.programs / "groundplan", *words], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert done.returncode == 0, f"groundplan {' '.join(map(str, words))}: {done.stderr}"

    def script(self, name, *words):
        subprocess.run([sys.executable, ROOT / "scripts" / name, *words], check=True, stdout=subprocess.DEVNULL)

    def maps(self, name="finished", model=MODEL, *words):
        out = self.folder / name
        if not out.is_dir():
            self.run("convert", model, "-o", out, *words)
        return out

    def storey(self, index, *words, **more):
        return next((self.maps(*words, **more) / "storeys").glob(f"{index:02}-*"))

    def drive(self, maps, name):
        """Maps of a robot that drives through the ground floor of these maps, in the order in which they grow."""
        out = self.folder / name
        self.script("slam_drive.py", maps, out)
        return sorted(out.glob("*.yaml"))


def doubled(image):
    return image.resize([2 * side for side in image.size], Image.NEAREST)


for at in ("2024-04-06", "2024-04-27", "2024-06-03"):
    picture(MAPS, f"ground-floor-{at}")(
        lambda demo, at=at: Image.open(demo.storey(0, at, MODEL, "--date", at, "--schedule-file", PLAN) / "semantic.png"))


@picture(MAPS, "ground-floor")
def ground_floor(demo):
    return doubled(Image.open(demo.storey(0) / "semantic.png"))


@picture(MAPS, "upper-floor")
def upper_floor(demo):
    return doubled(Image.open(demo.storey(1) / "semantic.png"))


@picture(MAPS, "waypoints")
def waypoints(demo):
    return Image.open(demo.storey(0) / "waypoints.png")


@picture(MAPS, "yard")
def yard(demo):
    site, robot = demo.folder / "site.ifc", demo.folder / "climber.toml"
    subprocess.run([ROOT / "scripts/build_terrain_site", site, "--size", "60", "60"], check=True, stdout=subprocess.DEVNULL)
    robot.write_text('name = "climber"\nmax_slope_rad = 0.2\n')
    storey = demo.storey(2, "yard", site, "--date", "2024-04-10T00:00:00", "--robot", robot, "--resolution", "0.1")
    return Image.open(storey / "relief.png")


@picture(MAPS, "alignment")
def alignment(demo):
    maps = demo.maps()
    grown = demo.drive(maps, "drive")
    out = demo.folder / "overlay.png"
    demo.run("align", "--reference", maps, "--slam", grown[len(grown) // 2], "--robot", "0", "0", "--overlay", out)
    return Image.open(out)


@picture(MAPS, "deviations")
def deviations(demo):
    """The robot drives in a building without a partition, with a box; its map is compared with the model before the furniture comes."""
    maps = demo.folder / "changed"
    shutil.copytree(demo.maps(), maps)
    elements = json.loads((maps / "semantic.json").read_text())["elements"]
    partition = next(element["aabb_m"] for element in elements.values() if element["name"] == PARTITION)
    gone = (*partition["min"][:2], *partition["max"][:2])
    storey = json.loads((maps / "manifest.json").read_text())["storeys"][0]
    for name in ("planning", "localization"):
        path = maps / storey["directory"] / f"{name}.pgm"
        data = bytearray(path.read_bytes())
        width, height = storey["size_cells"]
        cells = np.frombuffer(data, np.uint8)[-width * height:].reshape(height, width)[::-1]
        for (x0, y0, x1, y1), value, margin_m in ((gone, 254, 0.06), (BOX_M, 0, 0.0)):
            k = [round((v - storey["origin_m"][i % 2] + side * margin_m) / 0.05) for i, (v, side) in
                 enumerate(zip((x0, y0, x1, y1), (-1, -1, 1, 1)))]
            # Doorways of walls that meet the partition stay as they are.
            cells[k[1] + 3 * (value == 254):k[3] - 3 * (value == 254), k[0]:k[2]] = value
        path.write_bytes(data)
    grown, out = demo.drive(maps, "changed-drive"), demo.folder / "deviations"
    demo.run("deviations", MODEL, "--slam", grown[-1], "--storey", "0", "--date", "2024-05-24T00:00:00", "-o", out)
    return Image.open(out / "deviations.png")


@picture(SCREENS, "world")
def world(demo):
    """The ground floor of site.glb, from above, without ceilings; doors are open."""
    import trimesh

    out = demo.maps("world", MODEL, "--world", "--doors", "open")
    scene = trimesh.load(out / "world/site.glb", process=False)
    corners, colours = [], []
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        vertices = trimesh.transform_points(mesh.vertices, transform)
        # glTF has Y up.
        vertices = vertices[:, [0, 2, 1]] * [1, -1, 1]
        # What is above, and the terrain around it, hides the floor.
        if vertices[:, 2].max() > 3.1 or np.ptp(vertices[:, :2], 0).max() > 30:
            continue
        base = mesh.visual.material.baseColorFactor if hasattr(mesh.visual, "material") else None
        # Factors of glTF are linear.
        base = 255 * (np.array(base[:3] if base is not None else (90, 90, 90), float) / 255) ** (1 / 2.2)
        corners.append(vertices[mesh.faces])
        colours.append(np.tile(base, (len(mesh.faces), 1)))
    return drawn(np.concatenate(corners), np.concatenate(colours), (960, 600))


def drawn(corners, colours, size):
    """Triangles as a camera above the building's corner sees them: nearest in front, lit from above, four samples a pixel."""
    width, height = (2 * side for side in size)
    low, high = corners.min((0, 1)), corners.max((0, 1))
    middle, eye = (low + high) / 2, np.array([(low + high)[0] / 2 - 4, low[1] - 8, 23.0])
    ahead = (middle - eye) / np.linalg.norm(middle - eye)
    right = np.cross(ahead, [0, 0, 1])
    right /= np.linalg.norm(right)
    seen = (corners - eye) @ np.stack([right, np.cross(right, ahead), ahead]).T
    focal = 0.84 * width
    x, y = width / 2 + focal * seen[..., 0] / seen[..., 2], height / 2 - focal * seen[..., 1] / seen[..., 2]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.maximum(np.linalg.norm(normals, axis=1, keepdims=True), 1e-12)
    light = 0.5 + 0.35 * np.abs(normals @ np.array([0.25, -0.4, 0.88]))
    image, nearest = np.full((height, width, 3), 250.0), np.full((height, width), np.inf)
    for k in range(len(corners)):
        xs, ys, inverse = x[k], y[k], 1 / seen[k, :, 2]
        x0, x1 = max(int(xs.min()), 0), min(int(xs.max()) + 1, width - 1)
        y0, y1 = max(int(ys.min()), 0), min(int(ys.max()) + 1, height - 1)
        area = (xs[1] - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (ys[1] - ys[0])
        if seen[k, :, 2].min() <= 0 or x0 > x1 or y0 > y1 or abs(area) < 1e-9:
            continue
        px, py = np.meshgrid(np.arange(x0, x1 + 1) + 0.5, np.arange(y0, y1 + 1) + 0.5)
        w1 = ((px - xs[0]) * (ys[2] - ys[0]) - (xs[2] - xs[0]) * (py - ys[0])) / area
        w2 = ((xs[1] - xs[0]) * (py - ys[0]) - (px - xs[0]) * (ys[1] - ys[0])) / area
        depth = 1 / np.maximum(inverse[0] + w1 * (inverse[1] - inverse[0]) + w2 * (inverse[2] - inverse[0]), 1e-9)
        part = np.s_[y0:y1 + 1, x0:x1 + 1]
        is_front = (w1 >= 0) & (w2 >= 0) & (w1 + w2 <= 1) & (depth < nearest[part])
        nearest[part][is_front] = depth[is_front]
        image[part][is_front] = colours[k] * light[k]
    return Image.fromarray(image.clip(0, 255).astype(np.uint8)).resize(size, Image.BOX)


def browser_of_pages():
    sys.path.insert(0, str(ROOT / "scripts"))
    import page_browser

    return page_browser, page_browser.Browser()


def page_of(demo, pages):
    """The address of the page of all dates, and what serves it."""
    programs = pages.Programs(demo.programs)
    maps = demo.maps("all", MODEL, "--date", "all", "--schedule-file", PLAN, "--world")
    tasks = demo.folder / "tasks.json"
    tasks.write_text(programs.groundplan("tasks", MODEL, "--schedule-file", PLAN, "--json"))
    return programs.serve("--out", maps, "--tasks", tasks, "--listen", "127.0.0.1:0")[0], programs


def screen(demo, take):
    pages, browser = browser_of_pages()
    programs = None
    try:
        url, programs = page_of(demo, pages)
        take(pages, browser, url)
        return Image.open(io.BytesIO(browser.driver.get_screenshot_as_png())).convert("RGB")
    finally:
        browser.driver.quit()
        if programs:
            programs.stop_all()


@picture(SCREENS, "page")
def page(demo):
    """Two dates compared."""
    def take(pages, browser, url):
        browser.open(f"{url}#storey=0&date={AFTER}&compare={BEFORE}&layers=planning,rooms,elements&view=plan&tab=changes")
        browser.wait_for_text("Rooms closed", "Came")
        browser.settled("body")
    return screen(demo, take)


@picture(SCREENS, "page-phone")
def page_phone(demo):
    """A room on a phone."""
    def take(pages, browser, url):
        browser.open(url, size=pages.PHONE)
        browser.named("[role=slider]", "Plan date").send_keys("\ue012")  # the key to the left
        browser.settled("#plan")
        office = pages.get_json(f"{url}data/site.json")["spaces"][OFFICE]
        browser.click_at(*browser.screen_of_map()(*office["centroid_m"]))
        browser.wait_for_text(OFFICE)
        browser.settled("body")
    return screen(demo, take)


@picture(SCREENS, "monitor")
def monitor(demo):
    """The monitor of a running site in a terminal of 120 columns, as a browser draws it."""
    import pyte

    columns, rows, cell = 120, 36, (8, 16)
    pages, browser = browser_of_pages()
    programs = pages.Programs(demo.programs)
    site = pages.LiveSite(programs)
    terminal, child = pyte.Screen(columns, rows), None
    try:
        site.run("date", "2024-04-29T10:00:00")
        site.wait_until_healthy()
        stream = pyte.ByteStream(terminal)
        child, end = pty.fork()
        if child == 0:
            os.environ["TERM"] = "xterm-256color"
            os.execv(demo.programs / "groundplan", ["groundplan", "monitor", "--config", str(site.config)])
        fcntl.ioctl(end, termios.TIOCSWINSZ, struct.pack("HHHH", rows, columns, 0, 0))
        until = time.monotonic() + 8
        while time.monotonic() < until:
            if select.select([end], [], [], 0.2)[0]:
                stream.feed(os.read(end, 1 << 16))
        os.write(end, b"q")
        os.waitpid(child, 0)
        lines = [[terminal.buffer[row][column] for column in range(columns)] for row in range(rows)]
        document = demo.folder / "monitor.html"
        document.write_text(page_of_terminal(lines, cell), encoding="utf-8")
        browser.command("Emulation.setDeviceMetricsOverride", width=columns * cell[0], height=rows * cell[1], deviceScaleFactor=1, mobile=False)
        browser.driver.get(f"file://{document}")
        return Image.open(io.BytesIO(browser.driver.get_screenshot_as_png())).convert("RGB")
    finally:
        browser.driver.quit()
        programs.stop_all()
        site.remove()


def page_of_terminal(lines, cell):
    """Cells of a terminal as a document."""
    named = {"default": None, "black": "#000000", "red": "#e06c75", "green": "#5fd75f", "brown": "#d7af5f", "yellow": "#ffff5f",
             "blue": "#6c9ee0", "magenta": "#c678dd", "cyan": "#56b6c2", "white": "#dddddd", "brightblack": "#808080"}

    def colour(name, otherwise):
        return named.get(name, f"#{name}") or otherwise

    body = ""
    for line in lines:
        for at in line:
            front, back = colour(at.fg, "#dddddd"), colour(at.bg, "#18181c")
            front, back = (back, front) if at.reverse else (front, back)
            body += f'<b style="color:{front};background:{back}">{html.escape(at.data or " ")}</b>'
        body += "<br>"
    return (f"<meta charset=utf-8><style>body{{margin:0;background:#18181c;font:13px/{cell[1]}px monospace;white-space:pre}}"
            f"b{{display:inline-block;width:{cell[0]}px;height:{cell[1]}px;overflow:hidden;font-weight:normal;vertical-align:top}}</style>{body}")


def differs(image, path):
    """True if a picture is not the one that is there."""
    if not path.is_file():
        return True
    images = [image.convert("RGB"), Image.open(path).convert("RGB")]
    return images[0].size != images[1].size or ImageChops.difference(*images).getbbox() is not None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "target/debug", help="folder of groundplan and groundplan-web")
    parser.add_argument("--only", default="", metavar="WORD")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    makers = {name: make for name, make in {**MAPS, **({} if options.check else SCREENS)}.items() if options.only in name}
    assert makers, f"no picture has {options.only!r} in its name"
    is_well = True
    with tempfile.TemporaryDirectory(prefix="groundplan-shots") as folder:
        demo = Demo(options.programs.resolve(), pathlib.Path(folder))
        for name, make in makers.items():
            path = DEMO / f"{name}.png"
            try:
                image = make(demo)
            except Exception as why:
                print(f"FAIL  {name}: {type(why).__name__}: {why}")
                is_well = False
                continue
            if options.check:
                if differs(image, path):
                    print(f"FAIL  {path.relative_to(ROOT)} is not what the program draws: scripts/shots.py makes it anew")
                    is_well = False
            elif name in SCREENS or differs(image, path):
                image.save(path, optimize=True)
                print(f"wrote {path.relative_to(ROOT)}")
    print(f"{len(makers)} pictures {'compared' if options.check else 'made'}")
    return 0 if is_well else 1


if __name__ == "__main__":
    sys.exit(main())
