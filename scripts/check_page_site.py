"""Facts of the page as people on site use it, for scripts/check_page.py: ten tasks of three clicks at most, filters, areas."""
import io
import json
import math
import pathlib
import re
import subprocess
import tempfile
import xml.etree.ElementTree as ElementTree
import zipfile
from datetime import datetime

from page_browser import PHONE, ROOT, differing, get_json, until
from PIL import Image
from selenium.webdriver.common.by import By
from selenium.webdriver.common.keys import Keys
from selenium.webdriver.support.select import Select

FACTS = []
TOLD = {}  # answers of the client by what it was asked
MAX_CLICKS = 3
BEFORE, AFTER = "2024-04-15T08:00:00", "2024-05-13T08:00:00"
OFFICE, KITCHEN, STORE_DOOR = "1sKGhI2trIeezvns$ocK_O", "2EWU3Hv_5RCxl$FiuD4RiW", "0rThZouwLILwRsmcDeTEXK"
DOORS_TASK = "3.3"


def fact(test):
    FACTS.append(test)
    return test


class Clicks:
    """What a person presses, counted."""

    def __init__(self, browser):
        self.browser, self.n = browser, 0

    def press(self, css, name):
        self.n += 1
        self.browser.named(css, name).click()

    def node(self, css):
        self.n += 1
        until(css, lambda: self.browser.all(css))[0].click()

    def at(self, x, y):
        self.n += 1
        self.browser.click_at(x, y)

    def choose(self, name, value):
        """Opens a list and takes an entry."""
        self.n += 2
        Select(self.browser.named("select", name)).select_by_value(value)

    def within_three(self):
        assert self.n <= MAX_CLICKS, f"{self.n} clicks"
        return f"{self.n} clicks"


def demo(site, *arguments):
    """What the client says of the demo building; a door that is closed ends it with 1."""
    site.need_programs()
    if arguments in TOLD:
        return TOLD[arguments]
    demo = ROOT / "config/demo"
    command = [site.programs.folder / "groundplan", *arguments, demo / "demo.ifc", "--schedule-file", demo / "demo-schedule.xer", "--json"]
    TOLD[arguments] = json.loads(subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout)
    return TOLD[arguments]


def stop_of(site, at):
    return str(next(k for k, date in enumerate(site.site["dates"]) if date["at"] == at))


def text_of(browser, css):
    return browser.run("return document.querySelector(arguments[0])?.innerText ?? ''", css)


def count_after(browser, title):
    """The number beside a heading of the panel of changes; 0 without it."""
    found = re.search(rf"^{re.escape(title)}\s*(\d+)$", text_of(browser, "#panel-changes"), re.MULTILINE)
    return int(found.group(1)) if found else 0


def coloured(picture, is_so):
    return sum(is_so(*pixel) for pixel in picture.convert("RGB").getdata())


is_came = lambda r, g, b: g > 100 and g > 1.6 * r and g > 1.3 * b
is_task = lambda r, g, b: r > 80 and b > 150 and b > 1.5 * g and r > 1.1 * g
is_went = lambda r, g, b: r > 120 and r > 2 * g and b > 1.1 * g


def wait_for_building(browser):
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    return browser.settled("#scene canvas")


def hanging(doors):
    """How many of these hang at both dates."""
    return sum("absent" not in (door["before"], door["after"]) for door in doors)


@fact
def two_dates_are_compared_in_three_clicks_and_say_what_the_client_says(browser, site):
    told = demo(site, "changes", "--diff", BEFORE, AFTER)
    assert len(told["elements_added"]) > 50 and told["spaces_blocked"], "the demo changes between these dates"
    browser.open(site.link(date=stop_of(site, AFTER), layers="planning,rooms,elements"))
    before, clicks = browser.settled("#plan"), Clicks(browser)
    clicks.press("[role=tab], button", "Changes")
    clicks.choose("Compare with", BEFORE)
    until("what came", lambda: browser.all("[data-kind=came]"))
    listed = {kind: int(text_of(browser, f"[data-kind={kind}] summary .count") or 0) for kind in ("came", "went")}
    assert listed == {"came": len(told["elements_added"]), "went": len(told["elements_removed"])}, listed
    closed = {space["name"] for space in told["spaces_blocked"]}
    assert count_after(browser, "Rooms closed") == len(closed), text_of(browser, "#panel-changes")[:600]
    assert all(name in text_of(browser, "#panel-changes") for name in closed)
    calendar = get_json(f"{site.url}data/calendar.json")["spaces"]
    opened = {space["global_id"] for space in told["spaces_unblocked"]}
    state = lambda room, at: [s for since, s in calendar[room] if since <= int(stop_of(site, at))][-1]
    assert {room for room in calendar if state(room, BEFORE) == "blocked" != state(room, AFTER)} == opened
    names = [site.site["spaces"][room]["name"] for room in opened]
    assert all(name in text_of(browser, "#panel-changes") for name in names)
    assert (count_after(browser, "Doors passable now"), count_after(browser, "Doors no longer passable")) == (
        hanging(told["doors_opened"]), hanging(told["doors_closed"]))
    assert "hang at one of the dates only" in text_of(browser, "#panel-changes")
    plan = browser.changed("#plan", before, 500)
    more = coloured(plan, is_came) - coloured(before, is_came)
    assert more > 300, f"{more} pixels of what came"
    assert browser.fragment()["compare"] == BEFORE[:16]
    browser.shot("compare")
    told_of = clicks.within_three()
    browser.named("button", "3D").click()
    building = wait_for_building(browser)
    assert coloured(building, is_came) > 500, f"{coloured(building, is_came)} pixels of what came in 3D"
    browser.shot("compare-3d")
    # The other way round all of it goes: it is in the model of the date compared with alone.
    browser.open(site.link(date=stop_of(site, BEFORE), view="3d", compare=AFTER[:16]))
    wait_for_building(browser)
    until("what went, in 3D", lambda: coloured(browser.picture("#scene canvas"), is_went) > 500)
    return told_of


@fact
def the_next_week_is_listed_in_two_clicks_as_the_client_has_it(browser, site):
    at, end = "2024-05-06T08:00:00", "2024-05-15T17:00:00"
    tasks = demo(site, "tasks")["tasks"]
    stop = max(k for k, date in enumerate(site.site["dates"]) if date["at"] <= at)
    begin = site.site["dates"][stop]["at"]
    browser.open(site.link(date=str(stop)))
    clicks = Clicks(browser)
    clicks.press("[role=tab], button", "Tasks")
    clicks.press("button", "Next week")
    shown = until("the tasks", lambda: [row.get_attribute("data-task") for row in browser.all("#task-list [data-task]")])
    week = f"{begin[:8]}{int(begin[8:10]) + 7:02}{begin[10:]}"
    assert begin[:7] == week[:7] == end[:7] and week[8:10] <= "31", "the window is in one month"
    expected = {task["global_id"] for task in tasks if not task["is_summary"] and task["start"] and task["start"] < week and task["finish"] > begin}
    assert len(expected) > 1 and set(shown) == expected, (shown, expected)
    assert browser.fragment()["look"] == "1"
    browser.shot("look-ahead")
    return clicks.within_three()


@fact
def a_click_on_a_closed_room_says_why_as_the_client_does(browser, site):
    at = "2024-04-08T08:00:00"
    why = demo(site, "states", "--date", at)["spaces"][OFFICE]["why"]
    task = next(code[5:] for code in why if code.startswith("task:"))
    browser.open(site.link(date=stop_of(site, at), layers="planning,rooms"))
    until("no movement", lambda: browser.settled("#plan"))
    clicks = Clicks(browser)
    clicks.at(*browser.screen_of_map()(*site.site["spaces"][OFFICE]["centroid_m"]))
    name = next(entry["name"] for entry in demo(site, "tasks")["tasks"] if entry["global_id"] == task)
    browser.wait_for_text(*site.name(OFFICE), f"work: task {task} {name}")
    assert ("before_room_date" in why) == ("before the room's date" in browser.text())
    return clicks.within_three()


@fact
def a_click_on_a_door_says_whether_it_can_be_passed(browser, site):
    door = site.site["elements"][STORE_DOOR]
    told = demo(site, "door", STORE_DOOR, "--date", site.site["dates"][-1]["at"])
    assert told["can_pass"] is False and told["passage"] == "too_narrow", told
    browser.open(site.link())
    box, clicks = door["aabb_m"], Clicks(browser)
    until("no movement", lambda: browser.settled("#plan"))
    clicks.at(*browser.screen_of_map()((box["min"][0] + box["max"][0]) / 2, (box["min"][1] + box["max"][1]) / 2))
    browser.wait_for_text(door["name"], *(reason["text"] for reason in told["reasons"]))
    return clicks.within_three()


def shortest_m(graph, start, goal):
    """Length of the shortest way between the nodes of two rooms, by relaxing every edge until nothing gets shorter."""
    far = {node["id"]: 0.0 if node["of"] == start else math.inf for node in graph["nodes"]}
    edges = [(e["from"], e["to"], e["length_m"]) for e in graph["edges"] if e["usable"]]
    changed = True
    while changed:
        changed = False
        for a, b, length in edges + [(b, a, length) for a, b, length in edges]:
            if far[a] + length < far[b] - 1e-9:
                far[b], changed = far[a] + length, True
    return min(far[node["id"]] for node in graph["nodes"] if node["of"] == goal)


@fact
def the_way_between_two_rooms_is_asked_for_with_three_clicks_on_the_plan(browser, site):
    told = demo(site, "way", OFFICE, KITCHEN, "--date", site.site["dates"][-1]["at"])
    browser.open(site.link(layers="planning,rooms"))
    until("no movement", lambda: browser.settled("#plan"))
    place, clicks = browser.screen_of_map(), Clicks(browser)
    clicks.at(*place(*site.site["spaces"][OFFICE]["centroid_m"]))
    clicks.press("button", "Way from here")
    clicks.at(*place(*site.site["spaces"][KITCHEN]["centroid_m"]))
    browser.wait_for_text("Doors passed", *(door["name"] for leg in told["legs"] for door in leg["doors"]))
    length = float(re.search(r"(\d+\.\d) m\b", text_of(browser, "#way-result")).group(1))
    # The page goes over the route graph, the client over the cells of the map.
    of_graph = shortest_m(get_json(f"{site.url}data/dates/{site.last}.json")["graph"], OFFICE, KITCHEN)
    assert abs(length - of_graph) < 0.06 and length > 0.95 * told["length_m"], (length, of_graph, told["length_m"])
    return clicks.within_three()


@fact
def a_task_selects_its_elements_and_an_element_leads_to_its_task(browser, site):
    task = next(entry for entry in demo(site, "tasks")["tasks"] if entry["global_id"] == DOORS_TASK)
    browser.open(site.link(layers="planning,rooms,elements"))
    before, clicks = browser.settled("#plan"), Clicks(browser)
    clicks.press("[role=tab], button", "Tasks")
    bars = until("the strips", lambda: browser.run(
        "return [...document.querySelectorAll('#task-list [data-task]')].map((row) => [row.dataset.task, ...['x', 'width'].map((a) =>"
        "Number(row.querySelector('.bar').getAttribute(a)))])"))
    dated = [entry for entry in demo(site, "tasks")["tasks"] if entry["start"]]
    day = lambda at: datetime.fromisoformat(f"{at}+00:00").timestamp()
    first, last = min(day(entry["start"]) for entry in dated), max(day(entry["finish"]) for entry in dated)
    place = lambda at: 1000 * (day(at) - first) / (last - first)
    assert [bar[0] for bar in bars] == [entry["global_id"] for entry in dated], "every task has its strip"
    for (_, x, width), entry in zip(bars, dated):
        assert abs(x - place(entry["start"])) < 0.2 and abs(x + width - place(entry["finish"])) < 4.2, (entry["name"], x, width)
    clicks.node(f"#task-list [data-task='{DOORS_TASK}']")
    until("its elements", lambda: re.search(rf"Elements\s*{len(task['elements'])}\b", text_of(browser, "#panel-tasks")))
    plan = browser.changed("#plan", before, 100)
    assert coloured(plan, is_task) > 150 > coloured(before, is_task), (coloured(plan, is_task), coloured(before, is_task))
    assert browser.fragment()["task"] == DOORS_TASK
    browser.shot("task")
    told = clicks.within_three()
    browser.open(site.link())
    until("no movement", lambda: browser.settled("#plan"))
    door = next(part["global_id"] for part in task["elements"] if 0 in site.site["elements"][part["global_id"]]["storeys"])
    box, back = site.site["elements"][door]["aabb_m"], Clicks(browser)
    back.at(*browser.screen_of_map()((box["min"][0] + box["max"][0]) / 2, (box["min"][1] + box["max"][1]) / 2))
    back.node(f"#panel-details [data-task='{DOORS_TASK}']")
    until("its task", lambda: task["name"] in text_of(browser, "#task-name"))
    back.within_three()
    return told


@fact
def a_length_is_measured_between_corners_and_cells_and_says_which(browser, site):
    browser.open(site.link(layers="planning,rooms"))
    until("no movement", lambda: browser.settled("#plan"))
    place, clicks = browser.screen_of_map(), Clicks(browser)
    ring = site.site["spaces"][OFFICE]["polygon_m"][0][0]
    a, b = min(ring), max(ring)
    clicks.press("button", "Measure")
    # Some pixels beside the corners, inside of the room: corners attract.
    (ax, ay), (bx, by) = place(*a), place(*b)
    clicks.at(ax + 3, ay - 3)
    clicks.at(bx - 3, by + 3)
    said = until("the length", lambda: re.search(r"(\d+\.\d\d) m, from (.*) to (.*)", text_of(browser, "#measure-text")))
    assert abs(float(said.group(1)) - math.dist(a, b)) < 0.006, (said.group(), math.dist(a, b))
    assert said.group(2).startswith("a corner of ") and said.group(3).startswith("a corner of ")
    assert "cell" not in said.group(), said.group()
    browser.shot("measure")
    x, y = site.site["spaces"][OFFICE]["centroid_m"]
    browser.click_at(*place(x, y))
    browser.click_at(*place(x + 1.0, y))
    said = until("the next length", lambda: re.search(r"(\d+\.\d\d) m, from a corner of a cell to a corner of a cell", text_of(browser, "#measure-text")))
    assert abs(float(said.group(1)) - 1.0) < 0.08, said.group()
    # The same on the keyboard: the plan moves below its middle.
    plan = browser.driver.find_element(By.ID, "plan")
    plan.send_keys(Keys.ENTER, Keys.ARROW_RIGHT)
    browser.settled("#plan")
    plan.send_keys(Keys.ENTER)
    until("a length by keyboard", lambda: (lambda found: found and float(found.group(1)) > 1)(re.match(r"(\d+\.\d\d) m, from", text_of(browser, "#measure-text"))))
    plan.send_keys(Keys.ESCAPE)
    until("the end", lambda: text_of(browser, "#measure-text") == "")
    return clicks.within_three()


@fact
def planned_dates_are_beside_what_is_not_known_of_files(browser, site):
    task = next(entry for entry in demo(site, "tasks")["tasks"] if entry["global_id"] == DOORS_TASK)
    browser.open(site.link())
    clicks = Clicks(browser)
    clicks.press("[role=tab], button", "Tasks")
    clicks.node(f"#task-list [data-task='{DOORS_TASK}']")
    table = until("the table", lambda: text_of(browser, "#panel-tasks .progress"))
    day = lambda at: f"{int(at[8:10])} May 2024, {at[11:16]}"
    assert f"{day(task['start'])} – {day(task['finish'])}" in table, table
    assert table.count("not known on this page") == 2, table
    return clicks.within_three()


@fact
def a_print_has_a_scale_bar_and_the_dates_compared(browser, site):
    browser.open(site.link(date=stop_of(site, AFTER), compare=BEFORE[:16]))
    browser.settled("#plan")
    browser.run("window.print = () => { const bar = document.querySelector('.scale-bar'), drawn = bar.querySelector('svg').getBoundingClientRect();"
                "watched.printed = {text: document.getElementById('print-side').innerText, metres: Number(bar.dataset.metres), px: drawn.width} }")
    clicks = Clicks(browser)
    clicks.press("button", "Print")
    told = until("the print", lambda: browser.run("return watched.printed"))
    scale = int(re.search(r"1 : (\d+)", told["text"]).group(1))
    assert abs(told["px"] / 96 * 0.0254 * scale - told["metres"]) < 0.02 * told["metres"], told
    wanted = ("13 May 2024", "15 April 2024", site.site["title"], "Ground floor", "came", "room closed")
    assert all(word in told["text"] for word in wanted), (wanted, told["text"])
    return clicks.within_three()


@fact
def a_link_and_a_saved_view_restore_tasks_dates_filters_and_what_is_hidden(browser, site):
    wall = next(key for key, e in site.site["elements"].items() if e["class"] == "wall" and 0 in e["storeys"])
    browser.open(site.link(date=stop_of(site, AFTER), layers="planning,rooms,elements", task=DOORS_TASK, tab="tasks", look="2", compare=BEFORE[:16],
                           classes="wall,door", states="built,in_progress", hide=wall))
    keys = ("task", "tab", "look", "compare", "classes", "states", "hide", "date", "layers", "storey")
    kept = until("the link", lambda: (lambda f: {key: f.get(key) for key in keys} if all(f.get(key) for key in keys) else None)(browser.fragment()))
    until("what came", lambda: coloured(browser.picture("#plan"), is_came) > 50)
    picture = browser.settled("#plan")
    browser.run("navigator.clipboard.writeText = async (text) => { watched.copied = text }")
    clicks = Clicks(browser)
    clicks.press("button", "Copy link")
    link = until("the copy", lambda: browser.run("return watched.copied"))
    told = clicks.within_three()
    browser.open(link)
    browser.restored("the same picture", "#plan", picture)
    assert {key: browser.fragment().get(key) for key in keys} == kept
    # A view is saved, left and used again.
    clicks = Clicks(browser)
    clicks.press("[role=tab], button", "Views")
    browser.named("input", "Name of the view").send_keys("Doors in May")
    clicks.press("button", "Save view")
    until("it is listed", lambda: "Doors in May" in text_of(browser, "#view-list"))
    clicks.within_three()
    browser.open(site.link())
    clicks = Clicks(browser)
    clicks.press("[role=tab], button", "Views")
    clicks.press("button", "Doors in May")
    until("the view", lambda: all(browser.fragment().get(key) == value for key, value in kept.items() if key != "tab"))
    browser.restored("the same picture", "#plan", picture)
    clicks.within_three()
    with tempfile.TemporaryDirectory() as folder:
        downloads_to(browser, folder)
        browser.named("button", "Save as file").click()
        saved = downloaded(folder, ".json")
        document = json.loads(saved.read_text())
        assert [view["name"] for view in document["views"]] == ["Doors in May"], document
        browser.named("button", "Remove Doors in May").click()
        until("it is gone", lambda: "Doors in May" not in text_of(browser, "#view-list"))
        browser.driver.find_element(By.ID, "read-file").send_keys(str(saved))
        until("it is read", lambda: "Doors in May" in text_of(browser, "#view-list"))
        browser.shot("views")
        wrong = pathlib.Path(folder) / "wrong.json"
        wrong.write_text("[1]")
        browser.driver.find_element(By.ID, "read-file").send_keys(str(wrong))
        until("that it is wrong", lambda: "wrong.json cannot be used" in browser.run("return document.getElementById('toast').innerText"))
    browser.run("localStorage.clear()")
    return told


def downloads_to(browser, folder):
    browser.command("Browser.setDownloadBehavior", behavior="allow", downloadPath=str(folder))


def downloaded(folder, ending):
    found = until(f"a file {ending}", lambda: [p for p in pathlib.Path(folder).iterdir() if p.name.endswith(ending)])
    return found[0]


def vector(node, name):
    return [float(node.find(f".//{name}/{axis}").text) for axis in "XYZ"]


@fact
def a_topic_is_written_as_bcf_and_leads_back_to_its_view(browser, site):
    browser.open(site.link(view="3d", select=STORE_DOOR, date=stop_of(site, AFTER)))
    wait_for_building(browser)
    browser.drag(browser.driver.find_element(By.CSS_SELECTOR, "#scene canvas"), 90, 25)
    camera = until("the camera", lambda: browser.fragment().get("camera"))
    whole = browser.settled("#scene canvas")
    where = browser.run("return groundplanView3d.project(arguments[0])", STORE_DOOR)
    with tempfile.TemporaryDirectory() as folder:
        downloads_to(browser, folder)
        clicks = Clicks(browser)
        clicks.press("[role=tab], button", "Views")
        clicks.press("button", "Save topic as BCF")
        path = downloaded(folder, ".bcf")
        told = clicks.within_three()
        with zipfile.ZipFile(path) as bcf:
            assert bcf.testzip() is None
            names = bcf.namelist()
            read = lambda ending: bcf.read(next(name for name in names if name.endswith(ending)))
            assert b'VersionId="2.1"' in read("bcf.version")
            markup, view = ElementTree.fromstring(read("markup.bcf")), ElementTree.fromstring(read("viewpoint.bcfv"))
            picture = Image.open(io.BytesIO(read("snapshot.png"))).convert("RGB")
        assert [part.get("IfcGuid") for part in view.findall(".//Selection/Component")] == [STORE_DOOR]
        assert markup.find(".//Header/File/Filename").text == "demo.ifc" and site.site["elements"][STORE_DOOR]["name"] in markup.find(".//Title").text
        numbers = [float(n) for n in camera.split(",")]
        # The frame of the demo's maps is its world.
        frame = site.site["frames"]["map_from_world"]
        assert all(abs(frame[key]) < 1e-9 for key in ("x_m", "y_m", "z_m", "yaw_rad")), frame
        assert math.dist(vector(view, "CameraViewPoint"), numbers[:3]) < 0.002
        towards = [b - a for a, b in zip(numbers[:3], numbers[3:])]
        assert math.dist(vector(view, "CameraDirection"), [c / math.hypot(*towards) for c in towards]) < 1e-4
        up = vector(view, "CameraUpVector")
        assert abs(sum(a * b for a, b in zip(up, towards))) < 1e-3 and up[2] > 0 and abs(math.hypot(*up) - 1) < 1e-5
        assert picture.size == whole.size and len(set(picture.resize((64, 64)).getdata())) > 20
        # Somebody else reads it.
        browser.open(site.link())
        browser.named("[role=tab], button", "Views").click()
        back = Clicks(browser)
        back.press("[role=tab], button", "Views")
        browser.driver.find_element(By.ID, "read-file").send_keys(str(path))
        back.n += 1
        until("the topic", lambda: browser.all("#topic-list .topic"))
        browser.shot("topics")
        back.node("#topic-list .topic")
        until("its selection", lambda: browser.fragment().get("select") == STORE_DOOR and browser.fragment()["date"] == AFTER[:16])
        wait_for_building(browser)
        until("its view", lambda: (lambda now: now and all(abs(a - b) < 1.5 for a, b in zip(now, where)))(
            browser.run("return groundplanView3d.project(arguments[0])", STORE_DOOR)))
        back.within_three()
    return told


OTHER_BCF = {
    "bcf.version": '<Version VersionId="2.1"/>',
    "one/markup.bcf": '<b:Markup xmlns:b="urn:x"><b:Topic Guid="one"><b:Title>&lt;b&gt;From above</b:Title></b:Topic>'
                      '<b:Viewpoints Guid="v"><b:Viewpoint>view.bcfv</b:Viewpoint></b:Viewpoints></b:Markup>',
    "one/view.bcfv": '<VisualizationInfo><Components><Selection><Component IfcGuid="KITCHEN"/><Component IfcGuid="0000000000000000000000"/>'
                     '</Selection><Visibility DefaultVisibility="true"/></Components><OrthogonalCamera>'
                     '<CameraViewPoint><X>12.4</X><Y>2.5</Y><Z>20</Z></CameraViewPoint><CameraDirection><X>0</X><Y>0</Y><Z>-1</Z></CameraDirection>'
                     '<CameraUpVector><X>0</X><Y>1</Y><Z>0</Z></CameraUpVector><ViewToWorldScale>8</ViewToWorldScale>'
                     '</OrthogonalCamera></VisualizationInfo>',
    "two/markup.bcf": "<Markup><Topic>",
    "three/markup.bcf": '<!DOCTYPE x [<!ENTITY e "e">]><Markup><Topic><Title>&e;</Title></Topic></Markup>',
}


@fact
def topics_of_other_programs_are_read_and_broken_ones_counted(browser, site):
    browser.open(site.link(tab="views"))
    toast = lambda: browser.run("return document.getElementById('toast').innerText")
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "other.bcfzip"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as bcf:
            for name, text in OTHER_BCF.items():
                bcf.writestr(name, text.replace("KITCHEN", KITCHEN))
        field = browser.driver.find_element(By.ID, "read-file")
        field.send_keys(str(path))
        until("the topic", lambda: [row.text for row in browser.all("#topic-list .topic")] == ["<b>From above"])
        assert "2 entries of other.bcfzip" in toast(), toast()
        browser.all("#topic-list .topic")[0].click()
        until("its view", lambda: browser.fragment().get("select") == KITCHEN and browser.fragment().get("centre", "").startswith("12.4"))
        assert "1 of its elements" in toast(), toast()
        x, y = map(float, browser.fragment()["centre"].split(","))
        assert math.dist((x, y), (12.4, 2.5)) < 0.05, (x, y)
        (pathlib.Path(folder) / "cut.bcf").write_bytes(path.read_bytes()[:200])
        field.send_keys(str(pathlib.Path(folder) / "cut.bcf"))
        until("that it is broken", lambda: "cut.bcf cannot be used" in toast())
    # What the browser writes in place of a broken document has a style, which the policy of the page refuses and tells.
    browser.open(site.link())


@fact
def filters_hide_isolate_and_colour_by_state(browser, site):
    elements = site.site["elements"]
    browser.open(site.link(layers="planning,elements"))
    browser.driver.find_element(By.CSS_SELECTOR, "#filter-box summary").click()
    whole = browser.settled("#plan")
    browser.named("button", "wall").click()
    walls = browser.changed("#plan", whole, 300)
    n_walls = sum(e["class"] == "wall" for e in elements.values())
    until("the number", lambda: f"{n_walls} of {len(elements)} elements are shown" in text_of(browser, "#shown-note"))
    browser.named("button", "Show all").click()
    browser.restored("everything", "#plan", whole)
    browser.named("button", "not started").click()
    until("nothing is not started at the end", lambda: f"0 of {len(elements)}" in text_of(browser, "#shown-note"))
    browser.named("button", "Show all").click()
    Select(browser.named("select", "Task")).select_by_value(DOORS_TASK)
    task = next(entry for entry in get_json(f"{site.url}data/tasks.json")["tasks"] if entry["global_id"] == DOORS_TASK)
    until("those of the task", lambda: f"{len(task['elements'])} of {len(elements)}" in text_of(browser, "#shown-note"))
    browser.shot("filter")
    browser.open(site.link(layers="planning,elements", select=STORE_DOOR))
    browser.named("button", "Hide").click()
    until("one less", lambda: f"{len(elements) - 1} of {len(elements)}" in text_of(browser, "#shown-note"))
    assert browser.fragment()["hide"] == STORE_DOOR
    browser.open(site.link(view="3d", date=stop_of(site, AFTER)))
    building = wait_for_building(browser)
    browser.driver.find_element(By.CSS_SELECTOR, "#filter-box summary").click()
    browser.named("input[type=checkbox]", "Colour by state").click()
    by_state = browser.changed("#scene canvas", building, 500)
    is_amber = lambda r, g, b: r > 150 and 0.45 * r < g < 0.85 * r and b < 0.4 * r
    assert coloured(by_state, is_amber) > coloured(building, is_amber) + 50, (coloured(by_state, is_amber), coloured(building, is_amber))
    browser.shot("by-state")
    browser.named("button", "slab").click()
    slabs = browser.changed("#scene canvas", by_state, 500)
    assert differing(walls, whole) > 300 and slabs.size == by_state.size


@fact
def open_areas_are_those_of_the_maps_and_rooms(browser, site):
    site.need_programs()
    folder = site.maps / site.site["dates"][-1]["at"].replace(":", "-")
    semantic, waypoints = (json.loads((folder / name).read_text()) for name in ("semantic.json", "waypoints.json"))
    free = {}
    for storey in json.loads((folder / "manifest.json").read_text())["storeys"]:
        planning = Image.open(folder / storey["directory"] / "planning.pgm")
        free[storey["index"]] = sum(value == 254 for value in planning.getdata()) * site.site["resolution_m"] ** 2
    rooms = {}
    for room, space in semantic["spaces"].items():
        if space["storey"] is not None and not space.get("external") and not space.get("metadata_only"):
            state = "blocked" if space["state"] == "blocked" else waypoints["spaces"][room]["access"]
            rooms[state] = rooms.get(state, 0) + space["area_m2"]
    browser.open(site.link())
    row = lambda key: [float(n) for n in re.findall(r"([\d.]+) m²", text_of(browser, f"[data-area={key}]").replace(",", ""))]
    until("the areas", lambda: row("free"))
    assert abs(row("free")[0] - free[0]) < 0.01 and abs(row("free")[1] - sum(free.values())) < 0.03, (row("free"), free)
    assert abs(row("reached")[1] - rooms["reached"]) < 0.05, (row("reached"), rooms)
    assert abs(row("no_way")[1] - rooms["no_way"]) < 0.05, (row("no_way"), rooms)
    return f"{sum(free.values()):.1f} m² free"


@fact
def tasks_comparisons_and_views_fit_a_phone(browser, site):
    for name, wanted in (("Tasks", "1.1 Ground slabs"), ("Changes", "Compare with"), ("Views", "Save topic as BCF")):
        browser.open(site.link(), size=PHONE)
        browser.named("#sheet-bar button", name).click()
        browser.wait_for_text(wanted)
        until("the sheet stands still", lambda: browser.settled("body"))
        wide = browser.run("return Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)")
        assert wide <= PHONE[0], f"{name}: {wide} pixels wide"
        small = browser.run("""return [...document.querySelectorAll("#right button, #right select, #right input, #sheet-bar button")]
            .map((e) => [e, (e.closest("label") || e).getBoundingClientRect()])
            .filter(([e, r]) => r.width > 0 && (r.height < 40 || r.width < 40)).map(([e, r]) => `${e.id || e.textContent} ${r.width}x${r.height}`)""")
        assert not small, f"{name}, smaller than a finger: {small}"
        browser.shot(f"phone-{name.lower()}")
    browser.open(site.link(), size=PHONE)
    until("no movement", lambda: browser.settled("#plan"))
    clicks = Clicks(browser)
    clicks.press("button", "Measure")
    box = browser.run("const r = document.getElementById('plan').getBoundingClientRect(); return [r.left + r.width / 2, r.top + r.height / 2]")
    clicks.at(*box)
    clicks.at(box[0] + 40, box[1])
    until("a length", lambda: re.search(r"\d+\.\d\d m, from", text_of(browser, "#measure-text")))
    browser.shot("phone-measure")
    return clicks.within_three()


@fact
def without_a_list_of_tasks_the_page_says_what_it_does_not_know(browser, site):
    site.need_programs()
    url, server = site.programs.serve("--out", site.maps, "--listen", "127.0.0.1:0")
    browser.open(f"{url}#storey=0&tab=tasks")
    browser.wait_for_text("Known from the elements on the maps alone")
    told = {task["global_id"]: task for task in demo(site, "tasks")["tasks"] if task["elements"]}
    shown = browser.run("return [...document.querySelectorAll('#task-list [data-task]')].map((row) => row.dataset.task)")
    known = {task["global_id"]: task for task in get_json(f"{url}data/tasks.json")["tasks"]}
    assert set(shown) == set(known) <= set(told) and len(known) > 5, (shown, set(told))
    assert all(len(task["elements"]) <= len(told[key]["elements"]) for key, task in known.items())
    assert all((task["start"], task["finish"]) == (told[key]["start"], told[key]["finish"]) for key, task in known.items())
    browser.leave()
    site.programs.stop(server)
