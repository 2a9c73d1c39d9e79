#!/usr/bin/env python3
"""Judges the page of groundplan-web in Chromium: served from files, exported, and live with daemons.

    python3 scripts/check_page.py [--programs target/debug] [--only WORD]   every fact, or those whose name has a word
    python3 scripts/check_page.py --url http://127.0.0.1:8000/              facts of a page of the demo that is served already

Needs Chromium with its driver (installed for root on Debian, else the check is skipped), selenium, Pillow and pypdfium2; axe-core lies in
target/page, where scripts/build_page puts it. WebGL runs in software. Prints a line for each fact. Pictures of the page for a
person lie in target/page/screenshots. Times are printed and not judged. Exit codes: 0 all facts hold, 1 one does not.
"""
import argparse
import base64
import os
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import time
import traceback

try:
    import check_page_live
    import check_page_site
    import pypdfium2
    from page_browser import PHONE, ROOT, Browser, LiveSite, Programs, Skipped, differing, get, get_json, until
    from selenium.common.exceptions import WebDriverException
    from selenium.webdriver.common.by import By
    from selenium.webdriver.common.keys import Keys
    from selenium.webdriver.support.select import Select
except ImportError as missing:
    sys.exit(f"scripts/check_page.py: {missing}: run it with target/venv/bin/python after scripts/python-env selenium pillow pypdfium2")

MARKUP = {"space": '<script>document.title="pwned"</script>', "wall": '<img src=x onerror=document.title="pwned">'}
OFFICE, KITCHEN, STORE = "1sKGhI2trIeezvns$ocK_O", "2EWU3Hv_5RCxl$FiuD4RiW", "1mnVXnBrXMz9YSS4DuE$rM"
STORE_DOOR = "0rThZouwLILwRsmcDeTEXK"
N_VIEWERS = 20
# Milliseconds from a key on the slider to the map of the next date.
STEP = """
const [key, done] = arguments, slider = document.querySelector("[role=slider]"), before = location.hash, begun = performance.now();
const shown = () => [...document.querySelectorAll(".leaflet-tile")].every((tile) => tile.complete);
slider.dispatchEvent(new KeyboardEvent("keydown", {key, bubbles: true}));
(function look() {
  if (location.hash !== before && shown()) requestAnimationFrame(() => done(performance.now() - begun));
  else requestAnimationFrame(look);
})();
"""
FACTS = []


def fact(test):
    FACTS.append(test)
    return test


class Site:
    """The demo building with its schedule, served from files."""

    def __init__(self, browser, url, programs, maps):
        self.browser, self.url, self.programs, self.maps = browser, url, programs, maps
        self.site = get_json(f"{url}data/site.json")
        self.last = self.site["dates"][-1]["key"]

    def link(self, **state):
        given = {"storey": 0, "date": -1, "layers": "planning,rooms,elements", "view": "plan", **state}
        if str(given["date"]).lstrip("-").isdigit():
            given["date"] = self.at(int(given["date"]))
        return f"{self.url}#" + "&".join(f"{key}={value}" for key, value in given.items() if value is not None)

    def at(self, number):
        """A date as links name it."""
        return self.site["dates"][number]["at"][:16]

    def need_programs(self):
        if self.programs is None:
            raise Skipped("there is only a page that is served already")

    def name(self, global_id):
        """Words of which the page makes the name."""
        found = self.site["spaces"].get(global_id) or self.site["elements"][global_id]
        return [word for word in (found["name"], found.get("long_name")) if word]


@fact
def the_page_opens_without_errors_and_loads_from_its_own_server_only(browser, site):
    browser.open(site.url)
    assert "demo" in browser.text()
    loaded = browser.run("return performance.getEntriesByType('resource').map((entry) => entry.name)")
    assert loaded and all(name.startswith(site.url) for name in loaded), loaded
    told = browser.run("return watched.first_view_ms")
    browser.shot("desktop")
    return f"first view after {told:.0f} ms"


@fact
def storeys_are_chosen_by_keyboard(browser, site):
    browser.open(site.link())
    before = browser.settled("#plan")
    storeys = browser.named("[role=listbox]", "Storeys")
    assert len(storeys.find_elements(By.CSS_SELECTOR, "[role=option]")) == len(site.site["storeys"])
    storeys.send_keys(Keys.HOME)
    until("the uppermost storey", lambda: browser.fragment()["storey"] == "1")
    chosen = storeys.find_elements(By.CSS_SELECTOR, "[aria-selected=true]")
    assert [option.text.split("\n")[0] for option in chosen] == ["Upper floor"], [option.text for option in chosen]
    browser.changed("#plan", before, 2000)


@fact
def layers_are_switched_by_their_names(browser, site):
    browser.open(site.link(layers="planning"))
    names = ["Planning map", "Semantic map", "Keep-out mask", "Localization map"]
    names += ["Rooms", "Elements", "Waypoints", "Scans", "Tour", "Route graph"]
    browser.named("input[type=checkbox]", names[0]).click()
    without = browser.settled("#plan")
    for name in names:
        browser.named("input[type=checkbox]", name).click()
        until(f"{name} is seen", lambda: differing(without, browser.picture("#plan")) > 50)
        browser.named("input[type=checkbox]", name).click()
        until(f"{name} is gone", lambda: differing(without, browser.picture("#plan")) < 50)
    browser.named("input[type=checkbox]", "Planning map").click()
    planning = browser.changed("#plan", without, 50)
    browser.named("input[type=checkbox]", "Localization map").click()
    browser.changed("#plan", planning, 50)
    for name in names[5:]:
        browser.named("input[type=checkbox]", name).click()
    browser.settled("#plan")
    browser.shot("layers")


@fact
def the_plan_date_moves_by_keyboard_and_by_pointer(browser, site):
    browser.open(site.link())
    slider = browser.named("[role=slider]", "Plan date")
    maps, texts = [browser.settled("#plan")], [slider.get_attribute("aria-valuetext")]
    for key in [Keys.HOME] + 6 * [Keys.ARROW_RIGHT]:
        slider.send_keys(key)
    until("the seventh date", lambda: browser.fragment()["date"] == site.at(6))
    maps.append(browser.changed("#plan", maps[-1], 500))
    texts.append(slider.get_attribute("aria-valuetext"))
    browser.drag(slider, 200, 0)
    until("another date", lambda: browser.fragment()["date"] != site.at(6))
    maps.append(browser.changed("#plan", maps[-1], 500))
    texts.append(slider.get_attribute("aria-valuetext"))
    assert len(set(texts)) == 3 and "25 March 2024" in texts[1], texts
    slider.send_keys(Keys.HOME)
    until("the first date", lambda: browser.fragment()["date"] == site.at(0))
    times = sorted(browser.driver.execute_async_script(STEP, "ArrowRight") for _ in site.site["dates"][1:])
    return f"a step takes {times[len(times) // 2]:.0f} ms, at most {times[-1]:.0f} ms"


@fact
def a_click_on_a_room_tells_its_name_and_global_id(browser, site):
    browser.open(site.link(date=12, layers="planning,rooms"))
    until("no movement", lambda: browser.settled("#plan"))
    browser.click_at(*browser.screen_of_map()(*site.site["spaces"][OFFICE]["centroid_m"]))
    browser.wait_for_text(OFFICE, *site.name(OFFICE))
    assert browser.fragment()["select"] == OFFICE
    assert "before the room's date" in browser.text()


@fact
def a_way_between_two_rooms_has_a_length_and_doors(browser, site):
    browser.open(site.link(select=OFFICE))
    browser.named("button", "Way from here").click()
    Select(browser.named("select", "To")).select_by_value(KITCHEN)
    way = until("a way", lambda: re.search(r"\d+\.\d m\b(?s:.*)Doors passed(?s:.*)", browser.text()))
    doors = {door for room in (OFFICE, KITCHEN) for door in site.site["spaces"][room]["doors"]}
    named = [site.site["elements"][door]["name"] for door in doors]
    assert sum(name in way.group() for name in named) >= 2, (named, way.group())
    assert {"from": OFFICE, "to": KITCHEN}.items() <= browser.fragment().items()
    browser.shot("way")


@fact
def a_room_that_cannot_be_reached_names_its_door(browser, site):
    door = site.site["elements"][STORE_DOOR]["name"]
    browser.open(site.link(select=STORE))
    browser.wait_for_text(door, "0.56 m clear, the robot needs 0.70 m")
    browser.named("button", "Way to here").click()
    Select(browser.named("select", "From")).select_by_value(OFFICE)
    browser.wait_for_text("No way at this date", door)


@fact
def a_room_is_called_open_only_if_the_robot_gets_there(browser, site):
    reason = "0.56 m clear, the robot needs 0.70 m"
    doc = get_json(f"{site.url}data/dates/{site.last}.json")
    no_way = [room for room, now in doc["spaces"].items() if now["state"] == "no_way"]
    assert STORE in no_way and doc["spaces"][OFFICE]["state"] == "reached", no_way
    assert all(doc["spaces"][room]["no_way"] for room in no_way), "each has a reason"
    browser.open(site.link(layers="planning,rooms"))
    rows = lambda: {row.find_element(By.CSS_SELECTOR, ".link-name").text.split("\n")[0]: row.text
                    for row in browser.driver.find_elements(By.CSS_SELECTOR, "#panel-details .links .link")}
    name = lambda room: " ".join(site.name(room))
    listed = until("the rooms", rows)
    door = site.site["elements"][STORE_DOOR]["name"]
    assert "no way" in listed[name(STORE)] and reason in listed[name(STORE)] and door in listed[name(STORE)], listed
    assert listed[name(OFFICE)].split("\n")[-1] == "open", listed[name(OFFICE)]
    legend = browser.run("return document.getElementById('legend').innerText")
    assert "open by the schedule, no way for this robot" in legend and "open, and the robot gets there" in legend, legend
    # On the plan: the middle of a room's floor beside its label.
    colour = lambda room: colour_in_room(browser, site, room)
    assert colour(STORE)[0] - colour(STORE)[2] > 60, f"yellow where no way leads: {colour(STORE)}"
    assert colour(OFFICE)[2] > colour(OFFICE)[0], f"blue where the robot gets to: {colour(OFFICE)}"
    browser.named("button", "Calendar of rooms").click()
    strip = until("the calendar", lambda: browser.run(
        "const row = document.querySelector(`[data-room='${arguments[0]}'] .strip`);"
        "return row && row.getAttribute('aria-label') + ' ' + row.querySelector('.strip-no_way').getAttribute('d')", STORE))
    assert "no way" in strip and "H1000" in strip, strip
    since = next(states[-1][0] for room, states in get_json(f"{site.url}data/calendar.json")["spaces"].items() if room == STORE)
    browser.open(site.link(date=str(since)))
    browser.named("[role=tab], button", "Changes").click()
    browser.wait_for_text("Open, no way for the robot", name(STORE), reason)


def colour_in_room(browser, site, room):
    """The colour that most of a room's floor has on the plan."""
    plan = browser.settled("#plan").convert("RGB")
    place, box = browser.screen_of_map(), browser.run("const r = document.getElementById('plan').getBoundingClientRect();"
                                                      "return [r.left, r.top, r.width]")
    points = [point for polygon in site.site["spaces"][room]["polygon_m"] for ring in polygon for point in ring]
    (x0, x1), (y0, y1) = ((min(axis), max(axis)) for axis in zip(*points))
    ratio = plan.width / box[2]
    seen = []
    for k in range(1, 20):
        for j in range(1, 20):
            x, y = place(x0 + (x1 - x0) * k / 20, y0 + (y1 - y0) * j / 20)
            seen.append(plan.getpixel((int((x - box[0]) * ratio), int((y - box[1]) * ratio))))
    return max(set(seen), key=seen.count)


@fact
def doors_in_3d_have_the_colours_of_the_robot(browser, site):
    browser.open(site.link(view="3d"))
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    picture = browser.settled("#scene canvas").convert("RGB")
    is_red = lambda r, g, b: r > 90 and r > 2 * g and r > 2 * b
    is_green = lambda r, g, b: g > 60 and g > 1.5 * r and g > 1.3 * b
    counts = [sum(test(*pixel) for pixel in picture.getdata()) for test in (is_red, is_green)]
    assert min(counts) > 5, f"red and green pixels of doors: {counts}"


@fact
def the_search_finds_classes_tasks_materials_and_global_ids_in_any_case(browser, site):
    elements = site.site["elements"]
    task = next(part["schedule"]["task"] for part in elements.values() if part["schedule"].get("task"))
    material = next(name for part in elements.values() for name in part["attributes"].get("materials", []))
    browser.open(site.link())
    search = browser.named("input", "Search")

    def found(typed):
        search.clear()
        search.send_keys(typed)
        return browser.run("return document.getElementById('results').innerText")
    for typed, wanted in (("ifcslab", "IfcSlab"), (task.lower(), task), (material.upper(), material)):
        until(f"{typed} finds {wanted}", lambda: wanted in found(typed))
    until("windows by their class", lambda: "window" in found("WINDOW"))
    found(STORE_DOOR.swapcase())
    search.send_keys(Keys.ENTER)
    until("the door", lambda: browser.fragment().get("select") == STORE_DOOR)


@fact
def the_search_finds_rooms_without_accents_and_elements_by_global_id(browser, site):
    browser.open(site.link())
    search = browser.named("input", "Search")
    search.send_keys("kuche", Keys.ENTER)
    until("the kitchen", lambda: browser.fragment().get("select") == KITCHEN)
    search.send_keys(STORE_DOOR, Keys.ENTER)
    until("the door", lambda: browser.fragment().get("select") == STORE_DOOR)


@fact
def a_link_restores_storey_date_layers_and_selection(browser, site):
    room = next(key for key, space in site.site["spaces"].items() if space["storey"] == 1)
    link = site.link(storey=1, date=20, layers="semantic,waypoints", select=room)
    browser.open(link)
    wanted = {"storey": "1", "date": site.at(20), "layers": "semantic,waypoints", "select": room, "view": "plan"}
    until("the state", lambda: wanted.items() <= browser.fragment().items())
    assert browser.named("input", "Semantic map").is_selected() and not browser.named("input", "Planning map").is_selected()
    assert "3 May 2024" in browser.named("[role=slider]", "Plan date").get_attribute("aria-valuetext")
    browser.wait_for_text(room)
    first = browser.settled("#plan")
    browser.open(site.url + "#" + browser.run("return location.hash.slice(1)"))
    browser.restored("the same picture", "#plan", first)
    browser.open(site.link(**{"from": OFFICE, "to": KITCHEN}))
    browser.wait_for_text("Doors passed")


@fact
def a_link_restores_the_part_of_the_plan_the_tab_the_camera_and_the_cut(browser, site):
    browser.open(site.link(layers="planning"))
    browser.settled("#plan")
    assert "centre" not in browser.fragment(), "all of the storey needs no part of the plan in its link"
    browser.named("button", "Zoom in").click()
    browser.drag(browser.driver.find_element(By.ID, "plan"), 60, 40)
    until("the part of the plan", lambda: {"centre", "zoom"} <= browser.fragment().keys())
    browser.named("[role=tab], button", "Mission").click()
    until("the tab", lambda: browser.fragment().get("tab") == "mission")
    looks = []

    def stands_still():
        # The plan glides on after a drag, and its link is written where it ends.
        looks.append((browser.settled("#plan"), browser.run("return location.hash")))
        return len(looks) > 1 and looks[-1][1] == looks[-2][1] and differing(looks[-1][0], looks[-2][0]) == 0
    until("the plan stands still", stands_still)
    plan, kept = looks[-1]
    browser.open(site.url + kept)
    browser.restored("the same part", "#plan", plan)
    assert browser.named("[role=tab]", "Mission").get_attribute("aria-selected") == "true"
    browser.named("button", "3D").click()
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    browser.drag(browser.driver.find_element(By.CSS_SELECTOR, "#scene canvas"), 120, 30)
    browser.run("const cut = document.getElementById('cut'); cut.value = 4; cut.dispatchEvent(new Event('input'))")
    until("camera and cut", lambda: {"camera", "cut"} <= browser.fragment().keys())
    browser.settled("#scene canvas")
    ends = [key for key, e in site.site["elements"].items() if e["type"] == "IfcWall"][::20]
    where = lambda: [browser.run("return groundplanView3d.project(arguments[0])", wall) for wall in ends]
    seen, kept = where(), browser.run("return location.hash")
    browser.driver.get("about:blank")
    browser.open(site.url + kept)
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    until("the same view", lambda: all(abs(a - b) < 1 for now, then in zip(where(), seen) if then
                                             for a, b in zip(now or (-1e9, -1e9), then)))
    until("the same cut", lambda: browser.run("return Number(document.getElementById('cut').value)") == 4)


@fact
def a_link_names_its_date_and_says_if_it_is_gone(browser, site):
    toast = lambda: browser.run("return document.getElementById('toast').innerText")
    browser.open(site.link(date="12"))
    assert browser.fragment()["date"] == site.at(12) and "T" in site.at(12), browser.fragment()
    assert toast() == "", toast()
    # Nothing changes between two dates: the maps of the first hold.
    day = "2024-03-26T03:00"
    held = max(k for k, date in enumerate(site.site["dates"]) if date["at"] <= f"{day}:00")
    browser.open(site.link(date=day))
    until("the date that holds", lambda: browser.fragment()["date"] == site.at(held))
    assert toast() == "", toast()
    for gone in ("1999-01-01T08:00", "12"):
        browser.open(site.url + f"#storey=0&date={gone}")
        until("that it is gone", lambda: "no maps of it any more" in toast() and gone in toast())
    field = browser.driver.find_element(By.ID, "date-field")
    browser.run("arguments[0].value = arguments[1]; arguments[0].dispatchEvent(new Event('change'))", field, site.at(7))
    until("the date of the field", lambda: browser.fragment()["date"] == site.at(7))


@fact
def the_first_storey_is_the_one_with_the_entrance(browser, site):
    entrance = site.site["entrance"]
    assert entrance is not None
    browser.open(site.url)
    until("its storey", lambda: browser.fragment()["storey"] == str(entrance))


@fact
def findings_are_on_the_page_with_links_to_their_elements(browser, site):
    site.need_programs()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        # Without its type a door has an assumed width; without a date the schedule of the model is not used.
        text = (ROOT / "config/demo/demo.ifc").read_text()
        (folder / "model.ifc").write_text(re.sub(r"#\d+=IFCDOORPANELPROPERTIES\(.*\);\n", "", text))
        site.programs.groundplan("convert", folder / "model.ifc", "-o", folder / "maps")
        url, server = site.programs.serve("--out", folder / "maps", "--listen", "127.0.0.1:0")
        found = get_json(f"{url}data/site.json")["findings"]
        browser.open(f"{url}#tab=findings")
        browser.wait_for_text("The schedule is not used: everything is shown as built")
        panel = lambda: browser.run("return document.getElementById('panel-findings').innerText")
        about = [f for kind in found.values() for f in kind["list"] if f["global_id"]]
        assert about, found
        known = get_json(f"{url}data/site.json")
        linked = next(f for f in about if f["global_id"] in known["elements"] or f["global_id"] in known["spaces"])
        until("its text", lambda: (linked["text"] or linked["name"]) in panel())
        count = sum(kind["n"] for kind in found.values())
        assert f"Findings: {count}" in browser.text(), browser.text()[:300]
        name = linked["name"] or linked["global_id"]
        next(row for row in browser.all("#panel-findings .link") if name in row.text).click()
        until("what it is about", lambda: browser.fragment().get("select"))
        browser.leave()
        site.programs.stop(server)


@fact
def what_changed_since_the_date_before_is_listed_by_task(browser, site):
    calendar = get_json(f"{site.url}data/calendar.json")["elements"]
    stop = next(k for k in range(20, 30) if sum(any(s[0] == k for s in states) for states in calendar.values()) > 3)
    changed = [key for key, states in calendar.items() if any(s[0] == stop for s in states)]
    tasks = {task for key in changed for task in [(site.site["elements"][key]["schedule"] or {}).get("task")] if task}
    browser.open(site.link(date=str(stop)))
    browser.named("[role=tab], button", "Changes").click()
    until("the tasks", lambda: tasks and all(task in browser.text() for task in tasks))


@fact
def the_3d_view_shows_the_building_and_picks_what_the_plan_picks(browser, site):
    browser.open(site.link())
    browser.named("button", "3D").click()
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    whole = browser.settled("#scene canvas")
    sofa = next(k for k, e in site.site["elements"].items() if e["type"] == "IfcFurniture" and 0 in e["storeys"])
    browser.click_at(*browser.run("return groundplanView3d.project(arguments[0])", sofa))
    until("the element", lambda: browser.fragment().get("select") == sofa)
    browser.wait_for_text(sofa)
    browser.changed("#scene canvas", whole, 20)
    browser.shot("3d")
    browser.named("button", "Plan").click()
    plan = browser.settled("#plan")
    box = site.site["elements"][sofa]["aabb_m"]
    at = browser.screen_of_map()((box["min"][0] + box["max"][0]) / 2, (box["min"][1] + box["max"][1]) / 2)
    browser.named("button", "All").click()
    until("no selection", lambda: "select" not in browser.fragment())
    browser.changed("#plan", plan, 20)
    browser.click_at(*at)
    until("the same element", lambda: browser.fragment().get("select") == sofa)


@fact
def the_3d_view_is_cut_and_keeps_its_camera_from_date_to_date(browser, site):
    browser.open(site.link(view="3d"))
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    cut = browser.settled("#scene canvas")
    browser.run("document.getElementById('cut').value = 99; document.getElementById('cut').dispatchEvent(new Event('input'))")
    whole = browser.changed("#scene canvas", cut, 5000)
    wall = next(k for k, e in site.site["elements"].items() if e["type"] == "IfcSlab")
    before = browser.run("return groundplanView3d.project(arguments[0])", wall)
    slider = browser.named("[role=slider]", "Plan date")
    for _ in range(12):
        slider.send_keys(Keys.ARROW_LEFT)
    browser.changed("#scene canvas", whole, 200)
    assert browser.run("return groundplanView3d.project(arguments[0])", wall) == before


@fact
def the_3d_view_has_waypoints_and_says_when_there_is_no_webgl(browser, site):
    browser.open(site.link(view="3d"))
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    without = browser.settled("#scene canvas")
    browser.named("input[type=checkbox]", "Scans").click()
    browser.changed("#scene canvas", without, 100)
    browser.run("HTMLCanvasElement.prototype.getContext = new Proxy(HTMLCanvasElement.prototype.getContext, {"
                "apply: (get, canvas, [kind, ...more]) => kind.startsWith('webgl') ? null : get.call(canvas, kind, ...more)})")
    said = browser.run("const box = document.createElement('div'); document.body.append(box);"
                       "groundplanScene(box).load(new ArrayBuffer(8)); return box.innerText")
    assert "WebGL" in said, said


@fact
def texts_and_names_are_german_for_german_browsers_and_by_the_address(browser, site):
    for url, language in ((site.link(), "de-DE"), (site.link().replace("#", "?lang=de#"), "en-GB")):
        browser.open(url, language=language)
        assert browser.run("return document.documentElement.lang") == "de"
        browser.named("[role=slider]", "Plandatum")
        browser.named("[role=listbox]", "Geschosse")
        browser.wait_for_text("Juni 2024", "Planungskarte")
        left = [word for word in ("Planning map", "Storeys", "Layers", "Rooms", "Search") if word in browser.text()]
        assert not left, left
    browser.shot("german")


@fact
def a_phone_of_360_pixels_shows_all_without_scrolling_sideways_or_moving(browser, site):
    browser.open(site.url, size=PHONE)
    browser.settled("#plan")
    browser.shot("phone")
    wide = browser.run("return Math.max(document.documentElement.scrollWidth, document.body.scrollWidth)")
    assert wide <= PHONE[0], f"{wide} pixels wide"
    small = browser.run("""return [...document.querySelectorAll("button, select, input, [role=slider], [role=option]")]
        .map((e) => [e, (e.closest("label") || e).getBoundingClientRect()])
        .filter(([e, r]) => r.width > 0 && (r.height < 40 || r.width < 40)).map(([e, r]) => `${e.id || e.textContent} ${r.width}x${r.height}`)""")
    assert not small, f"smaller than a finger: {small}"
    browser.named("[role=slider]", "Plan date").send_keys(Keys.ARROW_LEFT)
    browser.settled("#plan")
    browser.click_at(*browser.screen_of_map()(*site.site["spaces"][OFFICE]["centroid_m"]))
    browser.wait_for_text(OFFICE)
    browser.shot("phone-room")
    shift = browser.run("return watched.shift")
    assert shift < 0.01, f"layout shift of {shift}"
    return f"layout shift {shift:.4f}"


@fact
def the_theme_follows_the_machine(browser, site):
    looks = []
    for dark in (False, True):
        browser.open(site.link(), dark=dark)
        browser.settled("#plan")
        page = browser.picture("body").convert("L").resize((32, 32))
        looks.append(sum(page.getdata()) / 1024)
    browser.shot("dark")
    assert looks[0] > 150 and looks[1] < 110, looks


@fact
def axe_finds_nothing_serious(browser, site):
    axe = ROOT / "target/page/node_modules/axe-core/axe.min.js"
    if not axe.is_file():
        subprocess.run([sys.executable, ROOT / "scripts/build_page", "--check"], stdout=subprocess.DEVNULL)
    if not axe.is_file():
        raise Skipped("axe-core is not in target/page")
    views = [(site.link(select=OFFICE), {}), (site.link(view="3d"), {}), (site.link(**{"from": OFFICE, "to": KITCHEN}), {"dark": True})]
    views += [(site.link(select=OFFICE), {"size": PHONE}), (site.link(date=12), {"dark": True, "language": "de-DE"})]
    views += [(site.link(tab="tasks", classes="wall", compare=site.at(3)), {}), (site.link(tab="views"), {"dark": True})]
    wrong = set()
    for url, how in views:
        browser.open(url, **how)
        browser.settled("body")
        browser.run(axe.read_text(encoding="utf-8"))
        found = browser.driver.execute_async_script("const done = arguments[0]; axe.run().then(done)")
        assert len(found["passes"]) > 20
        for violation in found["violations"]:
            if violation["impact"] in ("serious", "critical"):
                wrong.update(f"{violation['id']} at {' '.join(map(str, node['target']))}" for node in violation["nodes"])
    assert not wrong, sorted(wrong)


@fact
def names_with_markup_are_text(browser, site):
    site.need_programs()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        text = (ROOT / "config/demo/demo.ifc").read_text()
        wall = next(e["name"] for e in site.site["elements"].values() if e["type"] == "IfcWall" and 0 in e["storeys"])
        for old, new in (("G.07", MARKUP["space"]), (wall, MARKUP["wall"])):
            assert f"'{old}'" in text, old
            text = text.replace(f"'{old}'", f"'{new}'")
        (folder / "hostile.ifc").write_text(text)
        site.programs.groundplan("convert", folder / "hostile.ifc", "--schedule-file", ROOT / "config/demo/demo-schedule.xer", "-o", folder / "maps")
        url, server = site.programs.serve("--out", folder / "maps", "--listen", "127.0.0.1:0")
        wall = next(key for key, e in get_json(f"{url}data/site.json")["elements"].items() if e["name"] == MARKUP["wall"])
        for key, shown in ((OFFICE, MARKUP["space"]), (wall, MARKUP["wall"])):
            browser.open(f"{url}#storey=0&select={key}")
            browser.wait_for_text(shown)
            search = browser.named("input", "Search")
            search.send_keys(shown[:4])
            until("found as text", lambda: shown in browser.run("return document.getElementById('results').innerText"))
        assert browser.run("return document.title") != "pwned"
        assert browser.run("return document.querySelectorAll('img[src=x], script:not([src])').length") == 0
        browser.leave()
        site.programs.stop(server)


@fact
def twenty_viewers_get_their_pages_at_once(browser, site):
    hashes = get_json(f"{site.url}data/dates/{site.last}.json")["storeys"][0]["layers"]
    paths = ["", "app.js", "scene.js", "style.css", "data/site.json", "data/calendar.json"]
    paths += [f"data/dates/{date['key']}.json" for date in site.site["dates"]]
    paths += [f"data/tiles/0/{layer}/{hashed}/0/{column}/0.png" for layer, hashed in hashes.items() for column in (0, 1)]
    wanted, wrong = {path: get(site.url + path) for path in paths}, []

    def view():
        try:
            wrong.extend(path for path in paths if get(site.url + path) != wanted[path])
        except OSError as error:
            wrong.append(str(error))
    threads = [threading.Thread(target=view) for _ in range(N_VIEWERS)]
    begun = time.monotonic()
    for thread in threads:
        thread.start()
    browser.open(site.link())
    for thread in threads:
        thread.join()
    assert not wrong, wrong
    return f"{N_VIEWERS * len(paths)} answers in {time.monotonic() - begun:.1f} s"


@fact
def an_exported_folder_works_from_files(browser, site):
    site.need_programs()
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder) / "shared folder"
        done = subprocess.run([site.programs.folder / "groundplan-web", "--out", site.maps, "--export", folder], stderr=subprocess.PIPE, text=True)
        assert done.returncode == 0, done.stderr
        size = sum(path.stat().st_size for path in (folder / "data").rglob("*") if path.is_file())
        maps = sum(path.stat().st_size for path in site.maps.rglob("*") if path.is_file())
        url = (folder / "index.html").as_uri()
        browser.open(f"{url}#storey=0&date={site.at(-1)}&layers=planning,rooms&view=plan")
        before = browser.settled("#plan")
        browser.named("[role=slider]", "Plan date").send_keys(Keys.HOME, *(8 * [Keys.ARROW_RIGHT]))
        until("another date", lambda: browser.fragment()["date"] == site.at(8))
        browser.changed("#plan", before, 500)
        browser.click_at(*browser.screen_of_map()(*site.site["spaces"][OFFICE]["centroid_m"]))
        browser.wait_for_text(OFFICE)
        browser.named("button", "3D").click()
        until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
        assert not browser.errors()
        assert size <= 3 * maps, f"{size} bytes for {maps} bytes of maps"
        return f"{size / 1e6:.1f} MB for {maps / 1e6:.1f} MB of maps"


def printed(browser):
    """The picture of the page that Ctrl-P prints: no script of the page runs but that of `beforeprint`."""
    told = browser.command("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
    pdf = pypdfium2.PdfDocument(base64.b64decode(told["data"]))
    assert len(pdf) == 1, f"{len(pdf)} pages"
    return pdf[0].render(scale=1.5).to_pil().convert("RGB"), pdf[0].get_textpage().get_text_bounded()


def whole_sheet(browser):
    """The sheet, once it does not say that parts of the map are missing."""
    picture, text = printed(browser)
    return None if "not loaded" in text else (picture, text)


@fact
def ctrl_p_prints_the_map_also_from_3d(browser, site):
    # Far from the whole storey: none of the tiles on the screen are those of the sheet.
    browser.open(site.link(layers="planning"))
    browser.settled("#plan")
    for _ in range(4):
        browser.named("button", "Zoom in").click()
    browser.settled("#plan")
    picture, text = until("a sheet with all of the map", lambda: whole_sheet(browser))
    plan = picture.crop((0, 0, int(picture.width * 0.72), picture.height))
    dark = sum(max(pixel) < 90 for pixel in plan.getdata()) / (plan.width * plan.height)
    white = sum(min(pixel) > 250 for pixel in plan.getdata()) / (plan.width * plan.height)
    assert dark > 0.01 and white > 0.2, f"{dark:.3f} of the sheet is occupied, {white:.3f} free"
    picture.save(ROOT / "target/page/screenshots/printed.png")
    browser.named("button", "3D").click()
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    from_3d, text = until("a sheet with all of the map", lambda: whole_sheet(browser))
    assert "the 3D view is not printed" in text.replace("\r\n", " ").replace("\n", " "), text
    assert differing(picture, from_3d) < 0.02 * picture.width * picture.height, "the same plan"


@fact
def maps_that_are_converted_into_the_folder_are_shown_under_their_own_date(browser, site):
    site.need_programs()
    with tempfile.TemporaryDirectory() as folder:
        maps = pathlib.Path(folder) / "maps"
        convert = ("convert", ROOT / "config/demo/demo.ifc", "--schedule-file", ROOT / "config/demo/demo-schedule.xer", "-o", maps, "--date")
        site.programs.groundplan(*convert, "2024-04-15T08:00:00")
        url, server = site.programs.serve("--out", maps, "--listen", "127.0.0.1:0")
        browser.open(f"{url}#storey=0&layers=planning&view=plan")
        browser.wait_for_text("15 Apr 2024")
        before = browser.settled("#plan")
        site.programs.groundplan(*convert, "2024-05-13T08:00:00")
        # A picture that is gone: the page begins anew, and is not left blank.
        browser.named("input[type=checkbox]", "Localization map").click()
        browser.wait_for_text("13 May 2024")
        assert "15 Apr 2024" not in browser.text()
        browser.changed("#plan", before, 500)
        browser.errors()  # the browser tells of the picture, too
        browser.leave()
        site.programs.stop(server)


@fact
def documents_come_compressed(browser, site):
    browser.open(site.link())
    sizes = browser.run("""return performance.getEntriesByType("resource").filter((entry) => /site.json|app.js/.test(entry.name))
        .map((entry) => [entry.encodedBodySize, entry.decodedBodySize])""")
    assert len(sizes) >= 2 and all(0 < encoded < decoded / 2 for encoded, decoded in sizes), sizes
    return f"{sum(encoded for encoded, _ in sizes)} of {sum(decoded for _, decoded in sizes)} bytes"


@fact
def it_prints_one_page_of_a3_across(browser, site):
    browser.open(site.link(select=OFFICE))
    browser.settled("#plan")
    browser.run("window.print = () => (watched.printed = document.getElementById('print-block').innerText)")
    browser.named("button", "Print").click()
    told = until("the print begins", lambda: browser.run("return watched.printed"))
    assert "Scale" in told and "not loaded" not in told, told
    told = browser.command("Page.printToPDF", preferCSSPageSize=True, printBackground=True)
    pdf = base64.b64decode(told["data"])
    (ROOT / "target/page/print.pdf").write_bytes(pdf)
    boxes = [[float(v) for v in box.split()] for box in re.findall(rb"/MediaBox\s*\[([^\]]*)\]", pdf)]
    assert len(boxes) == 1, f"{len(boxes)} pages"
    wide, high = boxes[0][2] / 72 * 25.4, boxes[0][3] / 72 * 25.4
    assert abs(wide - 420) < 1 and abs(high - 297) < 1, f"{wide:.0f} x {high:.0f} mm"


def chromium():
    """True if there is a browser with its driver; root on Debian installs it."""
    def found():
        return shutil.which("chromium") and shutil.which("chromedriver")
    if not found() and os.geteuid() == 0 and shutil.which("apt-get"):
        subprocess.run(["apt-get", "install", "-y", "-q", "chromium", "chromium-driver"], stdout=subprocess.DEVNULL)
    return found()


def served(browser, url, programs, maps):
    """The page to be judged; without an address, that of the demo's maps."""
    if url is None:
        demo = ROOT / "config/demo"
        schedule = ["--date", "all", "--schedule-file", demo / "demo-schedule.xer"]
        programs.groundplan("convert", demo / "demo.ifc", *schedule, "--world", "-o", maps)
        tasks = maps.with_name("tasks.json")
        tasks.write_text(programs.groundplan("tasks", demo / "demo.ifc", "--schedule-file", demo / "demo-schedule.xer", "--json"))
        url, _ = programs.serve("--out", maps, "--tasks", tasks, "--listen", "127.0.0.1:0")
    return Site(browser, url, programs, maps)


def judge(test, browser, site):
    """True if the fact holds, None if it could not be judged."""
    name, begun = test.__name__.replace("_", " "), time.monotonic()
    try:
        said = test(browser, site)
        errors = browser.errors()
        assert not errors, f"errors in the browser: {errors}"
    except Skipped as why:
        print(f"** SKIPPED: {name}: {why}", flush=True)
        return None
    except Exception as error:
        browser.shot(f"failed-{test.__name__}")
        at = traceback.extract_tb(error.__traceback__)
        lines = [frame.lineno for frame in at if frame.filename.endswith(".py") and "check_page" in frame.filename][1:]
        print(f"  FAIL  {name}: {type(error).__name__} at line {lines}: {str(error)[:1500]}", flush=True)
        print(f"        the page shows: {browser.shown()}", flush=True)
        return False
    print(f"  ok    {name} ({time.monotonic() - begun:.1f} s){f': {said}' if said else ''}", flush=True)
    return True


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--programs", type=pathlib.Path, default=ROOT / "target/debug", help="folder of groundplan and groundplan-web")
    parser.add_argument("--url", help="a page of the demo that is served already")
    parser.add_argument("--only", default="", metavar="WORD", help="facts whose name has this word")
    options = parser.parse_args()
    if not chromium():
        print("\n** SKIPPED: the page in a browser: there is no chromium with chromedriver")
        return 0
    wanted = lambda facts: [test for test in facts if options.only in test.__name__.replace("_", " ")]
    facts, live_facts = wanted(FACTS + check_page_site.FACTS), wanted([] if options.url else check_page_live.FACTS)
    programs = None if options.url else Programs(options.programs.resolve())
    for old in (ROOT / "target/page/screenshots").glob("failed-*"):
        old.unlink()
    try:
        browser, live = Browser(), None
    except WebDriverException as why:
        print(f"\n** SKIPPED: the page in a browser: Chromium does not start here: {why}")
        return 0
    with tempfile.TemporaryDirectory() as folder:
        try:
            site = served(browser, options.url, programs, pathlib.Path(folder) / "maps")
            verdicts = [judge(test, browser, site) for test in facts]
            if live_facts:
                live = LiveSite(programs)
                verdicts += [judge(test, browser, live) for test in live_facts]
        finally:
            browser.driver.quit()
            if programs:
                programs.stop_all()
            if live:
                live.remove()
    print(f"in Chromium {verdicts.count(True)} facts hold, {verdicts.count(False)} do not, {verdicts.count(None)} were skipped")
    return 1 if False in verdicts else 0


if __name__ == "__main__":
    sys.exit(main())
