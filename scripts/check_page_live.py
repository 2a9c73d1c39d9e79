"""Facts of the page of a running site, for scripts/check_page.py: its date, its daemons, its connection, its control."""
import json
import os
import pathlib
import shutil
import signal
import socket
import tempfile
import threading
import urllib.error
import urllib.request

from page_browser import DEADLINE_S, LiveSite, get, get_json, until
from selenium.webdriver.common.keys import Keys

FACTS = []
N_VIEWERS = 20
MAX_VIEWERS = 64


def fact(test):
    FACTS.append(test)
    return test


def follow(url, wanted, seen):
    """Reads events until one has the text."""
    with urllib.request.urlopen(f"{url}data/events", timeout=DEADLINE_S) as stream:
        seen.append("open")
        for line in stream:
            if wanted in line.decode():
                seen.append("told")
                return


def post_date(url, at, **headers):
    """The status of a request to set the date."""
    headers = {"Content-Type": "application/json", **headers}
    request = urllib.request.Request(f"{url}data/control/date", data=b'{"at": "%s"}' % at.encode(), headers=headers)
    try:
        with urllib.request.urlopen(request, timeout=DEADLINE_S) as answer:
            return answer.status
    except urllib.error.HTTPError as refused:
        return refused.code


def alerts(browser):
    return browser.run("return document.getElementById('alerts').innerText")


@fact
def a_date_set_on_the_site_appears_in_all_open_pages(browser, live):
    browser.open(live.url)
    browser.wait_for_text("8 Apr 2024")
    before = browser.settled("#plan")
    seen = [[] for _ in range(N_VIEWERS)]
    viewers = [threading.Thread(target=follow, args=(live.url, "2024-05-10T17:00", own), daemon=True) for own in seen]
    for viewer in viewers:
        viewer.start()
    until("all viewers are connected", lambda: all(seen))
    live.run("date", "2024-05-10T17:00:00")
    browser.wait_for_text("10 May 2024")
    browser.changed("#plan", before, 500)
    for viewer in viewers:
        viewer.join(DEADLINE_S)
    assert all("told" in own for own in seen), [len(own) for own in seen]
    browser.named("button", "3D").click()
    until("the building", lambda: len(set(browser.picture("#scene canvas").resize((64, 64)).getdata())) > 20)
    browser.named("button", "Plan").click()
    browser.shot("live")


@fact
def no_date_is_set_without_permission(browser, live):
    live.run("date", "2024-04-29T08:00:00")
    assert get_json(f"{live.url}data/site.json")["control"] is False
    assert post_date(live.url, "2024-05-10T17:00:00", **{"X-Groundplan": "1"}) == 403
    browser.open(live.url)
    browser.wait_for_text("29 Apr 2024")
    slider = browser.named("[role=slider]", "Plan date")
    assert slider.get_attribute("aria-disabled") == "true"
    slider.send_keys(Keys.ARROW_RIGHT)
    assert "2024-04-29" in live.run("date"), live.run("date")


@fact
def a_room_says_why_it_is_closed_and_a_way_leads_from_a_point_to_a_room(browser, live):
    live.run("date", "2024-05-01T00:00:00")
    rooms = get_json(f"{live.url}data/site.json")["spaces"]
    room = {space["name"]: global_id for global_id, space in rooms.items()}
    browser.open(f"{live.url}#storey=0&select={room['G.13']}")
    browser.wait_for_text("this robot may not enter it", "3.1 Windows", "2024-05-08T17:00:00")
    live.run("date", "2024-06-20T00:00:00")
    browser.wait_for_text("20 Jun 2024", "this robot may enter it")
    # The middle of the plan is in no wall.
    browser.open(f"{live.url}#storey=0&tab=way&to={room['G.02']}")
    browser.wait_for_text("20 Jun 2024")
    browser.named("button", "Point on the plan").click()
    browser.run("""const plan = document.getElementById("plan"), box = plan.getBoundingClientRect();
        const at = {bubbles: true, clientX: box.x + box.width / 2, clientY: box.y + box.height / 2};
        for (const kind of ["mousedown", "mouseup", "click"]) plan.dispatchEvent(new MouseEvent(kind, at));""")
    browser.wait_for_text("way from", "G.D04 plant room", "maps of epoch")
    browser.shot("live-way")


@fact
def reported_progress_is_shown_beside_what_is_planned(browser, live):
    live.run("date", "2024-05-10T17:00:00")
    before = {task["global_id"]: task for task in get_json(f"{live.url}data/tasks.json")["tasks"]}
    door = next(part["global_id"] for part in before["3.3"]["elements"])
    wall = next(key for key, e in get_json(f"{live.url}data/site.json")["elements"].items() if e["class"] == "wall" and e["schedule"]["task"] == "2.1")
    table = live.home / "progress.csv"
    table.write_text(f"id,start,finish\n3.3,2024-05-15T08:00:00,\n{wall},2024-04-09T08:00:00,2024-04-10T17:00:00\n")
    live.run("actuals", table)
    told = until("what was reported", lambda: get_json(f"{live.url}data/tasks.json")["progress"]["elements"].get(wall) and get_json(f"{live.url}data/tasks.json"))
    planned = {key: before["3.3"][key] for key in ("start", "finish")}
    assert told["progress"]["tasks"]["3.3"] == {"planned": planned, "reported": {"start": "2024-05-15T08:00:00", "finish": None}}, told["progress"]["tasks"]["3.3"]
    assert told["progress"]["elements"][wall]["observed"] is None
    browser.open(f"{live.url}#storey=0")
    browser.wait_for_text("10 May 2024")
    browser.named("[role=tab], button", "Tasks").click()
    until("the task", lambda: browser.all("[data-task='3.3']"))[0].click()
    browser.wait_for_text("13 May 2024, 08:00 – 17 May 2024, 17:00", "15 May 2024, 08:00 – …", "nothing observed")
    browser.shot("live-progress")
    browser.open(f"{live.url}#storey=0&select={wall}")
    browser.wait_for_text("9 Apr 2024, 08:00 – 10 Apr 2024, 17:00")
    browser.open(f"{live.url}#storey=0&select={door}")
    browser.wait_for_text("15 May 2024, 08:00 – … (as its task)")
    live.run("actuals", "--clear")
    until("nothing is reported", lambda: not get_json(f"{live.url}data/tasks.json")["progress"]["elements"])


@fact
def two_dates_of_a_running_site_are_compared_by_its_schedule(browser, live):
    live.run("date", "2024-05-13T08:00:00")
    told = json.loads(live.programs.groundplan("changes", live.home / "demo.ifc", "--schedule-file", live.home / "demo-schedule.xer", "--json",
                                               "--diff", "2024-04-15T08:00:00", "2024-05-13T08:00:00"))
    browser.open(f"{live.url}#storey=0&tab=changes&compare=2024-04-15T08:00")
    browser.wait_for_text("13 May 2024", "Doors are not compared")
    came = lambda: browser.run("return document.querySelector('[data-kind=came] summary .count')?.innerText")
    until("what came", lambda: came() == str(len(told["elements_added"])))


@fact
def a_killed_daemon_is_told_and_told_well_again(browser, live):
    browser.open(live.url)
    until("the site is well", lambda: browser.run("return document.getElementById('services-state').textContent") and not alerts(browser))
    live.kill("rasterize", lambda: until("it is told", lambda: "rasterize" in alerts(browser)))
    until("the page tells that all is well", lambda: not alerts(browser))


@fact
def a_lost_connection_is_told_and_mended(browser, live):
    live.run("date", "2024-05-10T17:00:00")
    browser.open(live.url)
    browser.wait_for_text("10 May 2024")
    live.kill("web", lambda: browser.wait_for_text("Connection lost"))
    live.run("date", "2024-04-29T08:00:00")
    browser.wait_for_text("29 Apr 2024")
    until("no alert", lambda: "Connection lost" not in browser.text())
    # The browser tells of the connection too.
    browser.errors()


FLEET_ROBOT = {
    "written_ms": 0, "maps_of": "scout", "storeys": 2, "epoch": 7, "newest_epoch": 7, "plan_time": "2024-04-08T08:00:00", "valid_until": None,
    "asked_ms": None, "daemons": {}, "alignment": None, "progress": None, "observations": None,
}


def fleet(place):
    """What a server knows of three robots: one shows an older index, one is silent where it was, one was never heard."""
    told = {"observation": "absent", "verdict": "late", "since": "2024-04-08T06:00:00Z"}
    return {
        "site": "tower", "written": "2024-04-08T08:00:00Z", "error": None, "epoch": 8,
        "robots": {
            "scout-1": {"state": "behind", "findings": ["it shows the maps of epoch 7, 8 is the newest"], "here": True,
                        "told": "2024-04-08T08:00:00Z", "report": {**FLEET_ROBOT, "place": place}},
            "scout-2": {"state": "silent", "findings": ["it told nothing for 300 s"], "here": False,
                        "told": "2024-04-08T07:00:00Z", "report": {**FLEET_ROBOT, "place": None}},
            "scout-3": {"state": "never_heard", "findings": [], "here": False, "told": None, "report": None},
        },
        "elements": [{"id": "0T8xbPmeHQFhEy1wPGGLbq", "is_conflict": True, "absent": {},
                      "told": {"scout-1": told, "scout-2": {**told, "observation": "observed"}}}],
        "n_elements": 1,
    }


@fact
def robots_of_a_served_site_are_listed_and_drawn_where_they_say(browser, live):
    with socket.create_server(("127.0.0.1", 0)) as free:
        link = "127.0.0.1:%d" % free.getsockname()[1]
    keys = pathlib.Path(tempfile.mkdtemp(prefix="groundplan-keys"))
    root, signing = keys / "root.pem", keys / "signing.pem"
    for key in (root, signing):
        live.programs.groundplan("key", "new", key)
    public = live.programs.groundplan("key", "show", signing).strip()
    live.programs.groundplan("key", "list", "--site", "tower", "--number", "1", "--root", root, "--key", public, "-o", keys / "keys.jsonl")
    served = LiveSite(
        live.programs,
        'robot = "scout"\n',
        f'[[robots]]\nname = "scout"\n[serve]\nstore = "{keys}/store"\nsite = "tower"\nkey = "{signing}"\nkeys = "{keys}/keys.jsonl"\n'
        f'[serve.link]\nlisten = ["tcp/{link}"]\nrobots = ["scout-1", "scout-2", "scout-3"]\n',
    )
    try:
        document = served.home / "state/fleet.json"
        until("the server tells of its robots", lambda: "never_heard" in get(f"{served.url}data/fleet.json").decode())
        browser.open(f"{served.url}#storey=0")
        browser.wait_for_text("8 Apr 2024")
        browser.named("button", "Live").click()
        browser.wait_for_text("Robots of the site", "scout-1", "never heard")
        # From here on the document says what a test wants: its writer stands still.
        stopped = served.daemon("site-server")["process_id"]
        os.kill(stopped, signal.SIGSTOP)
        try:
            document.write_text(json.dumps(fleet(None)))
            browser.wait_for_text("shows older maps", "8 is the newest", "silent: this is of before", "Robots contradict each other", "site-server does not run")
            before = browser.settled("#plan")
            document.write_text(json.dumps(fleet({"map_storey": 0, "pose": {"x_m": 6.0, "y_m": 6.0, "yaw_rad": 0.5}, "age_s": 1.0})))
            browser.changed("#plan", before, 60)
            browser.shot("live-fleet")
        finally:
            os.kill(stopped, signal.SIGCONT)
    finally:
        browser.driver.get("about:blank")
        served.programs.stop(served.up)
        served.remove()
        shutil.rmtree(keys)
        browser.errors()


def place_of_viewer(live):
    """The events of the site; None while there is no place."""
    try:
        return urllib.request.urlopen(f"{live.url}data/events")
    except urllib.error.HTTPError as refusal:
        assert refusal.code == 503, refusal
        return None


@fact
def the_viewer_who_is_one_too_many_is_told_so(browser, live):
    browser.driver.get("about:blank")  # the page of before had a place, too
    viewers = [until("a place", lambda: place_of_viewer(live)) for _ in range(MAX_VIEWERS)]
    browser.driver.get(live.url)
    until("it is told", lambda: "Too many viewers" in alerts(browser))
    assert "Connection lost" not in browser.text()
    viewers.pop().close()
    until("there is a place", lambda: not alerts(browser))
    for viewer in viewers:
        viewer.close()
    browser.errors()  # the browser tells of the refusals, too


@fact
def with_permission_the_slider_sets_the_date_after_a_question(browser, live):
    live.allow_control()
    live.run("date", "2024-04-29T08:00:00")
    browser.open(live.url)
    browser.wait_for_text("29 Apr 2024")
    slider = browser.named("[role=slider]", "Plan date")
    slider.send_keys(Keys.ARROW_RIGHT)
    browser.named("dialog button", "Cancel").click()
    assert "2024-04-29" in live.run("date")
    slider.send_keys(Keys.ARROW_RIGHT)
    # The next question comes before the browser tells the page that the last one has ended.
    browser.run("""const [cancel, slider] = arguments;
        cancel.click();
        slider.dispatchEvent(new KeyboardEvent("keydown", {key: "ArrowRight"}));""", browser.named("dialog button", "Cancel"), slider)
    browser.named("dialog button", "Set date").click()
    until("the date is set", lambda: "2024-05-03" in live.run("date"))
    until("the page shows it", lambda: "3 May 2024" in slider.get_attribute("aria-valuetext"))
    assert post_date(live.url, "2024-05-10T17:00:00") == 403, "a form of another page may set the date"
    assert 400 <= post_date(live.url, "no date", **{"X-Groundplan": "1"}) < 500
