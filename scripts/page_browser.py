"""What the browser tests of the page stand on: Chromium, a page in it, the programs of groundplan."""
import io
import json
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import time
import urllib.request

from PIL import Image, ImageChops
from selenium import webdriver
from selenium.common.exceptions import NoSuchElementException, StaleElementReferenceException
from selenium.webdriver.common.action_chains import ActionChains
from selenium.webdriver.common.actions.action_builder import ActionBuilder
from selenium.webdriver.common.by import By

ROOT = pathlib.Path(__file__).resolve().parent.parent
# The one deadline of every wait: far beyond what any machine needs.
DEADLINE_S = 60
DESKTOP, PHONE = (1280, 900), (360, 740)
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--hide-scrollbars=false"]
# Runs before the page: what breaks its policy, what moves without being asked to, when the first map is seen, and how much of what
# was asked for is not there yet.
WATCH = """
window.watched = {violations: [], shift: 0, first_view_ms: null, awaited: 0};
const awaited = async (answer) => {
  watched.awaited += 1;
  try { return await answer(); } finally { watched.awaited -= 1; }
};
const plainFetch = window.fetch;
window.fetch = async (...what) => {
  const response = await awaited(() => plainFetch(...what));
  for (const read of ["arrayBuffer", "blob", "json", "text"]) {
    const plainRead = response[read].bind(response);
    response[read] = () => awaited(plainRead);
  }
  return response;
};
document.addEventListener("securitypolicyviolation", (e) => watched.violations.push(e.violatedDirective + " " + e.blockedURI));
new PerformanceObserver((list) => {
  for (const entry of list.getEntries()) if (!entry.hadRecentInput) watched.shift += entry.value;
}).observe({type: "layout-shift", buffered: true});
(function look() {
  const seen = [...document.querySelectorAll(".leaflet-tile")].some((tile) => tile.complete && tile.naturalWidth > 0);
  if (seen) watched.first_view_ms = performance.now(); else requestAnimationFrame(look);
})();
"""


class Skipped(Exception):
    """What a fact needs is not there."""


def until(what, is_so):
    """Waits for a condition and gives what it gave."""
    end = time.monotonic() + DEADLINE_S
    while True:
        try:
            found = is_so()
        except (NoSuchElementException, StaleElementReferenceException):
            found = None
        if found:
            return found
        assert time.monotonic() < end, f"never: {what}"
        time.sleep(0.05)


class Browser:
    """A page in Chromium."""

    def __init__(self):
        options = webdriver.ChromeOptions()
        options.binary_location = shutil.which("chromium")
        for flag in FLAGS:
            options.add_argument(flag)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(options=options, service=webdriver.ChromeService(shutil.which("chromedriver")))
        self.driver.set_script_timeout(DEADLINE_S)
        self.command("Page.addScriptToEvaluateOnNewDocument", source=WATCH)
        self.agent = self.run("return navigator.userAgent")

    def command(self, name, **values):
        return self.driver.execute_cdp_cmd(name, values)

    def run(self, script, *values):
        return self.driver.execute_script(script, *values)

    def open(self, url, size=DESKTOP, dark=False, language="en-GB"):
        """Opens a page anew and waits for its first map."""
        self.driver.get("about:blank")
        width, height = size
        self.command("Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=size == PHONE)
        theme = {"name": "prefers-color-scheme", "value": "dark" if dark else "light"}
        self.command("Emulation.setEmulatedMedia", features=[theme, {"name": "prefers-reduced-motion", "value": "reduce"}])
        self.command("Emulation.setUserAgentOverride", userAgent=self.agent, acceptLanguage=language)
        self.driver.get_log("browser")
        self.driver.get(url)
        until("the first map is seen", lambda: self.run("return watched.first_view_ms"))

    def errors(self):
        """Errors on the console and breaches of the policy since the page was opened."""
        told = [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] == "SEVERE"]
        return told + self.run("return watched.violations")

    def leave(self):
        """Closes a page whose server ends, so that it asks for nothing more. Its errors are judged before."""
        told = self.errors()
        assert not told, f"errors in the browser: {told}"
        self.driver.get("about:blank")
        self.driver.get_log("browser")

    def all(self, css):
        return [element for element in self.driver.find_elements(By.CSS_SELECTOR, css) if element.is_displayed()]

    def named(self, css, name):
        """The element that is shown and has an accessible name."""
        return until(f"{css} named {name}", lambda: next((e for e in self.all(css) if e.accessible_name == name), None))

    def text(self):
        return self.run("return document.body.innerText")

    def wait_for_text(self, *texts):
        until(f"text {texts}", lambda: all(text in self.text() for text in texts))

    def shown(self):
        """What tells most of a page that is not as expected: its date, messages, a question, and errors."""
        told = {name: self.run("return document.getElementById(arguments[0])?.innerText", name) for name in ("date", "alerts", "toast", "dialog")}
        return {"url": self.driver.current_url, **told, "errors": self.errors()}

    def fragment(self):
        """State that a link keeps."""
        pairs = (pair.split("=", 1) for pair in self.run("return location.hash.slice(1)").split("&") if "=" in pair)
        return {key: value.replace("%24", "$") for key, value in pairs}

    def click_at(self, x, y):
        actions = ActionBuilder(self.driver)
        actions.pointer_action.move_to_location(round(x), round(y)).click()
        actions.perform()

    def move_to(self, x, y):
        actions = ActionBuilder(self.driver)
        actions.pointer_action.move_to_location(round(x), round(y))
        actions.perform()

    def drag(self, element, dx, dy):
        ActionChains(self.driver).move_to_element(element).click_and_hold().move_by_offset(dx, dy).release().perform()

    def picture(self, css):
        """Pixels of an element, as they are shown."""
        png = self.driver.find_element(By.CSS_SELECTOR, css).screenshot_as_png
        return Image.open(io.BytesIO(png)).convert("RGB")

    def settled(self, css):
        """Pixels of an element once all pictures and answers are there and two looks are the same."""
        arrived = "return watched.awaited === 0 && [...document.images].every((image) => image.complete)"
        until("all pictures and answers", lambda: self.run(arrived))
        self.driver.execute_async_script("const done = arguments[0]; requestAnimationFrame(() => requestAnimationFrame(() => done()))")
        last = [self.picture(css)]

        def same():
            last.append(self.picture(css))
            return last[-1].size == last[-2].size and differing(last[-1], last[-2]) == 0
        until(f"{css} stands still", same)
        return last[-1]

    def changed(self, css, before, pixels):
        """Pixels of an element once so many of them are others than before."""
        until(f"{css} changes", lambda: differing(before, self.picture(css)) > pixels)
        return self.settled(css)

    def restored(self, what, css, before):
        """Waits until an element shows what it showed before; keeps both pictures if it never does. Where a cell of a map ends between
        two pixels, Chromium draws it now on this one and now on that."""
        looks = [before]

        def is_restored():
            looks[1:] = [self.settled(css)]
            return differing_areas(*looks) < 50
        try:
            until(what, is_restored)
        except AssertionError as never:
            for name, look in zip(("before", "after"), looks):
                look.save(self.folder() / f"failed-{what.replace(' ', '-')}-{name}.png")
            raise AssertionError(f"{never}: {differing(*looks)} pixels differ, {differing_areas(*looks)} of them in areas") from never

    def screen_of_map(self):
        """A function from metres to pixels of the screen: read from the coordinates under the pointer at two places."""
        box = self.run("const r = document.getElementById('plan').getBoundingClientRect(); return [r.left, r.top, r.width, r.height]")
        ends = [(box[0] + box[2] * f, box[1] + box[3] * f) for f in (0.3, 0.7)]
        read = []
        for x, y in ends:
            self.move_to(x, y)
            read.append(until("coordinates", self.coordinates))
        (x0, y0), (x1, y1) = [(round(x), round(y)) for x, y in ends]
        (u0, v0), (u1, v1) = read
        return lambda u, v: (x0 + (u - u0) * (x1 - x0) / (u1 - u0), y0 + (v - v0) * (y1 - y0) / (v1 - v0))

    def coordinates(self):
        words = self.run("return document.getElementById('coordinates').textContent").replace(",", ".").split()
        return (float(words[1]), float(words[3])) if len(words) > 3 else None

    def shot(self, name):
        """A picture of the page for a person."""
        self.driver.save_screenshot(str(self.folder() / f"{name}.png"))

    @staticmethod
    def folder():
        folder = ROOT / "target/page/screenshots"
        folder.mkdir(parents=True, exist_ok=True)
        return folder


def differing(a, b):
    """Number of pixels that differ visibly."""
    return differences(a, b).histogram()[255]


def differences(a, b):
    """A picture that is white where two differ visibly, and black elsewhere."""
    return ImageChops.difference(a, b).convert("L").point(lambda v: 255 if v > 16 else 0)


def differing_areas(a, b):
    """Number of pixels that differ visibly together with three neighbours: a line of one pixel is none of them."""
    mask = differences(a, b)
    for x, y in ((1, 0), (0, 1)):
        mask = ImageChops.darker(mask, ImageChops.offset(mask, x, y))
    return mask.histogram()[255]


def get(url):
    with urllib.request.urlopen(url, timeout=DEADLINE_S) as answer:
        return answer.read()


def get_json(url):
    return json.loads(get(url))


class Programs:
    """The folder with groundplan and groundplan-web, and what runs of them."""

    def __init__(self, folder):
        self.folder = folder
        self.running = []

    def groundplan(self, *arguments):
        done = subprocess.run([self.folder / "groundplan", *arguments], text=True, stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        assert done.returncode == 0, f"groundplan {arguments}: {done.stderr}"
        return done.stdout

    def start(self, program, *arguments, **options):
        child = subprocess.Popen([self.folder / program, *arguments], text=True, stderr=subprocess.DEVNULL, **options)
        self.running.append(child)
        return child

    def serve(self, *arguments):
        """The address of a page that is served, and the server."""
        child = self.start("groundplan-web", *arguments, stdout=subprocess.PIPE)
        url = child.stdout.readline().strip()
        assert url.startswith("http"), f"groundplan-web {arguments} does not say its address: {url!r}"
        return url, child

    def stop(self, child):
        child.terminate()
        try:
            child.wait(DEADLINE_S)
        except subprocess.TimeoutExpired:
            child.kill()
            child.wait()
        self.running.remove(child)

    def stop_all(self):
        for child in list(reversed(self.running)):
            self.stop(child)


class LiveSite:
    """Daemons with a state and a bus of their own, as `tests/src/live.rs` has them."""

    def __init__(self, programs, web="", more=""):
        self.programs = programs
        self.home = pathlib.Path(tempfile.mkdtemp(prefix="groundplan-page"))
        self.root = pathlib.Path(tempfile.mkdtemp(prefix="gppage", dir="/dev/shm"))
        self.prefix = f"{self.root.name.replace('_', 'x')}_"
        for name in ("demo.ifc", "demo-schedule.xer"):
            shutil.copyfile(ROOT / "config/demo" / name, self.home / name)
        with socket.create_server(("127.0.0.1", 0)) as free:
            address = "127.0.0.1:%d" % free.getsockname()[1]
        self.url, self.config = f"http://{address}/", self.home / "site.toml"
        self.config.write_text(
            'state = "state"\nmodels = ["demo.ifc"]\n'
            '[schedule]\nplan_time = "2024-04-08T08:00:00"\nfiles = ["demo-schedule.xer"]\n'
            f'[bus]\nprefix = "{self.prefix}"\nroot = "{self.root}"\n'
            f'[web]\nenabled = true\nlisten = "{address}"\nallow_control = false\n{web}{more}'
        )
        self.up = programs.start("groundplan", "up", "--config", self.config, stdout=subprocess.DEVNULL)
        self.wait_until_healthy()

    def wait_until_healthy(self):
        until("the daemons are healthy", lambda: self.status().get("healthy"))
        until("the site is served", self.answers)

    def answers(self):
        try:
            return get(f"{self.url}data/site.json")
        except OSError:
            return None

    def daemon(self, word):
        return next(facts for name, facts in self.status()["daemons"].items() if word in name)

    def kill(self, word, meanwhile=lambda: None):
        """Kills a daemon, keeps it from being started again until something was done, and waits for its successor."""
        self.wait_until_healthy()
        before = self.daemon(word)["process_id"]
        # A silent daemon has the number 0, and that would be this process and all its relatives.
        assert before > 1
        self.up.send_signal(signal.SIGSTOP)
        try:
            os.kill(before, signal.SIGKILL)
            meanwhile()
        finally:
            self.up.send_signal(signal.SIGCONT)
        until("a successor", lambda: self.status().get("healthy") and self.daemon(word)["process_id"] not in (0, before))
        self.wait_until_healthy()

    def allow_control(self):
        self.config.write_text(self.config.read_text().replace("allow_control = false", "allow_control = true"))
        self.kill("web")

    def status(self):
        command = [self.programs.folder / "groundplan", "status", "--json", "--config", self.config]
        told = subprocess.run(command, text=True, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL).stdout
        return json.loads(told) if told.strip() else {}

    def run(self, *arguments):
        return self.programs.groundplan(*arguments, "--config", self.config)

    def remove(self):
        """After its daemons have ended."""
        for folder in (self.home, self.root, pathlib.Path(f"{self.root}-relay")):
            shutil.rmtree(folder, ignore_errors=True)
        for segment in pathlib.Path("/dev/shm").glob(f"{self.prefix}*"):
            segment.unlink(missing_ok=True)
