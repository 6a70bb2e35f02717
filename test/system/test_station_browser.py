"""The station's pages in a real Chromium, with real mouse and key events (doc/station.md: data-test names)."""

import asyncio
import os
import shutil
import signal
import subprocess
import sys
import tarfile
import tempfile
import time

import numpy as np
import pytest
from stack import BUILD, ROOT, wait_until
from station_rig import Page, start, stop

sys.path.insert(0, os.path.join(ROOT, "scripts"))
import raven2_session  # noqa: E402
from raven2_station import words  # noqa: E402

webdriver = pytest.importorskip("selenium.webdriver", reason="python3-selenium is not installed")
from selenium.webdriver.chrome.service import Service  # noqa: E402
from selenium.webdriver.common.action_chains import ActionChains  # noqa: E402
from selenium.webdriver.common.by import By  # noqa: E402
from selenium.webdriver.common.keys import Keys  # noqa: E402
from selenium.webdriver.support.ui import Select  # noqa: E402

CHROMIUM, DRIVER = shutil.which("chromium"), shutil.which("chromedriver")
pytestmark = pytest.mark.skipif(not (CHROMIUM and DRIVER), reason="chromium or chromium-driver is not installed")
QUIET = ("--headless=new", "--no-sandbox", "--disable-gpu", "--disable-quic", "--no-first-run", "--disable-background-networking",
         "--disable-component-update", "--disable-sync", "--disable-dev-shm-usage")


SEEN = "const e = document.querySelector(arguments[0]); return e.checkVisibility() ? e.innerText.trim() : '';"


class Browser:
    """Chromium. Finds elements of the page by their data-test names."""

    def __init__(self, url):
        self._profile = tempfile.TemporaryDirectory(prefix="raven2_chromium_")
        options = webdriver.ChromeOptions()
        options.binary_location = CHROMIUM
        for word in (*QUIET, f"--user-data-dir={self._profile.name}"):
            options.add_argument(word)
        options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
        self.driver = webdriver.Chrome(service=Service(DRIVER), options=options)
        self.driver.set_window_size(1280, 1000)
        self.url = url

    def begin(self):
        """A window as of a new user; no other one stays."""
        ActionChains(self.driver).reset_actions()
        old = self.driver.window_handles
        self.driver.switch_to.new_window("window")
        new = self.driver.current_window_handle
        for handle in old:
            self.driver.switch_to.window(handle)
            self.driver.close()
        self.driver.switch_to.window(new)
        self.driver.set_window_size(1280, 1000)
        self.driver.get(self.url + "/static/icon.svg")
        self.driver.execute_script("localStorage.clear()")
        self.errors()

    def open(self, path="/"):
        self.driver.get(self.url + path)
        self.until(lambda: "Connecting" not in self.text("health"), 10, "the page is connected")

    def __getitem__(self, name):
        return self.driver.find_element(By.CSS_SELECTOR, f'[data-test="{name}"]')

    def text(self, name):
        """The visible text of an element. Asks the browser once; selenium asks twice."""
        return self.driver.execute_script(SEEN, f'[data-test="{name}"]')

    def choose(self, **choices):
        for name, value in choices.items():
            element = self[name]
            if element.tag_name == "select":
                Select(element).select_by_value(value)
            else:
                element.clear()
                element.send_keys(value)

    def click(self, name):
        """Scrolls to an element and clicks it, as a person would."""
        self.driver.execute_script("arguments[0].scrollIntoView({block: 'center'})", self[name])
        self[name].click()

    def until(self, condition, seconds, what):
        try:
            wait_until(condition, seconds, what, 0.05)  # each question takes time of the page, whose hands must not fall silent
        except AssertionError:
            raise AssertionError(f"{what}: {self.driver.find_element(By.TAG_NAME, 'body').text}") from None

    def errors(self):
        return [entry["message"] for entry in self.driver.get_log("browser") if entry["level"] in ("SEVERE", "WARNING")]

    def close(self):
        self.driver.quit()
        self._profile.cleanup()


@pytest.fixture(scope="module")
def chromium(station):
    started = Browser(station.url)
    yield started
    started.close()


@pytest.fixture
def browser(chromium):
    chromium.begin()
    yield chromium
    assert chromium.errors() == []


def end(browser):
    browser.click("stop")
    browser.until(lambda: browser.text("mode") == "No session", 20, "the session has ended")


def test_an_instructor_runs_an_exercise_and_reads_the_verdict(station, browser):
    browser.open()
    stops = {"ann": lambda: browser.click("emergency-stop"),
             "bea": lambda: ActionChains(browser.driver).send_keys(Keys.SPACE).perform()}  # right after a click on another button
    for trainee, emergency_stop in stops.items():
        browser.choose(exercise="pick_hand_over_place", hazard="sudden_jump", when="instructor", driver="expert", trainee=trainee)
        browser.click("start")
        browser.until(lambda: browser.text("mode").startswith("The hands move"), 25, "the expert moves")
        browser.until(lambda: int(browser["picture"].get_attribute("data-frames") or 0) > 20, 10, "pictures come")
        browser.until(lambda: "running" in browser.text("task"), 40, "the exercise runs")
        browser.click("inject")
        browser.until(lambda: "acts" in browser.text("said"), 3, "the hazard acts")
        browser.until(lambda: browser["health"].get_attribute("data-level") is not None, 3, "health")
        emergency_stop()
        browser.until(lambda: browser.text("mode").startswith("STOPPED"), 2, "stopped")
        end(browser)
    browser.until(lambda: browser.text("verdict").startswith("Not"), 60, "the verdict")
    assert browser["report"].get_attribute("href").endswith("_bea/report.html")
    browser.click("tab-class")
    browser.until(lambda: "bea" in browser.text("class-table"), 5, "the class")
    rows = browser.text("class-table").splitlines()
    assert [row.split()[0] for row in rows[1:]] == ["ann", "bea"]
    browser.click("tab-sessions")
    browser.until(lambda: browser.text("session-table").count("_ann") == 1, 5, "the sessions")
    for close in (lambda: browser.click("sure-no"), lambda: ActionChains(browser.driver).send_keys(Keys.ESCAPE).perform()):
        browser.driver.execute_script("document.getElementById('said').textContent = ''")
        browser.click("delete")
        browser.until(lambda: browser["sure-yes"].is_displayed(), 3, "a question")
        close()
        ActionChains(browser.driver).send_keys(Keys.SPACE).perform()
        browser.until(lambda: "stop is not confirmed. No session is running." in browser.text("said"), 3, "the space bar stops")
        assert not browser["sure-yes"].is_displayed(), "the space bar asks nothing"
    browser["delete"].send_keys(Keys.ENTER)
    browser.until(lambda: browser["sure-yes"].is_displayed(), 3, "a question")
    ActionChains(browser.driver).send_keys(Keys.ESCAPE).perform()
    assert browser.driver.switch_to.active_element.get_attribute("data-test") == "delete", "the keyboard's user goes on there"
    assert len([n for n in os.listdir(station.sessions) if n.endswith(("_ann", "_bea"))]) == 2


def test_a_report_opens_its_video(station, browser):
    """A report is in a sandbox: a browser takes its link for a link of another site, and sends no cookie that is strict."""
    directory = os.path.join(station.sessions, "2020-01-01T00-00-00Z_video")
    os.makedirs(directory)
    for name, text in (("session.rlog", "x"), ("video.mp4", "x"), ("report.html", '<a id="link" href="video.mp4#t=1.00">1 s</a>')):
        with open(os.path.join(directory, name), "w", encoding="utf-8") as file:
            file.write(text)
    browser.open()
    driver = browser.driver
    driver.get(f"{browser.url}/sessions/2020-01-01T00-00-00Z_video/report.html")
    driver.find_element(By.ID, "link").click()
    browser.until(lambda: driver.current_url.endswith("/video.mp4#t=1.00"), 5, "the link is followed")
    assert driver.execute_script("return document.contentType") == "video/mp4"
    shutil.rmtree(directory)
    browser.errors()  # these two pages have no icon, and the video no pictures


def test_a_key_that_the_browser_needs_is_refused(browser):
    browser.open("/trainee")
    browser.click("key-arm")
    for key, name in ((Keys.CONTROL, "Control Left"), (Keys.ALT, "Alt Left"), (Keys.TAB, "Tab"), (Keys.ENTER, "Enter")):
        ActionChains(browser.driver).send_keys(key).perform()
        browser.until(lambda: f"{name} cannot be chosen" in browser.text("said"), 3, name)
        assert browser.text("key-arm") == "press a key"
    held = {"type": "keyDown", "key": "l", "code": "KeyL", "windowsVirtualKeyCode": 76, "autoRepeat": True}
    browser.driver.execute_cdp_cmd("Input.dispatchKeyEvent", held)
    assert browser.text("key-arm") == "press a key", "a key that was held before"
    ActionChains(browser.driver).send_keys("k").perform()
    browser.until(lambda: browser.text("key-arm") == "K", 3, "the new key")


# Prints a pose when asked. `rostopic echo` prints every one, and comes later and later on a busy machine.
TIP = """
import sys
import rospy
from geometry_msgs.msg import PoseStamped
rospy.init_node("tip", anonymous=True, disable_signals=True)
for _ in sys.stdin:
    pose = rospy.wait_for_message(sys.argv[1] + "/measured_cp", PoseStamped).pose
    p, q = pose.position, pose.orientation
    print(p.x, p.y, p.z, q.x, q.y, q.z, q.w, flush=True)
"""


class Tip:
    """The published pose of an arm's tip in the world: position [m] and rotation matrix. Use as a context manager. It listens only
    when asked: the machine has other work."""

    def __init__(self, master, arm="arm1"):
        self._process = master.popen(sys.executable, "-c", TIP, f"/{arm}", stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.pose()

    def pose(self):
        self._process.stdin.write("\n")
        self._process.stdin.flush()
        values = [float(value) for value in self._process.stdout.readline().split()]
        return np.array(values[:3]), rotation_of(values[3:])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()


def press_pedal(browser):
    """Presses the pedal. Presses again if the page asks for it, because a busy machine delayed the console."""
    for _ in range(3):
        ActionChains(browser.driver).key_up(Keys.SPACE).pause(0.3).key_down(Keys.SPACE).perform()
        browser.until(lambda: browser.text("mode").startswith("The hands move") or is_refused(browser), 5, "the pedal counts or is refused")
        if not is_refused(browser):
            return
    raise AssertionError("the page asked for another press three times")


def is_refused(browser):
    return browser["pedal"].get_attribute("data-down") == "refused"


WATCH_PEDAL = """
const mode = document.getElementById("mode");
window.lifted = false;
new MutationObserver(() => { window.lifted ||= !mode.textContent.startsWith("The hands move"); }).observe(mode, {childList: true});
"""


def came_up(browser):
    """Whether the pedal came up since WATCH_PEDAL, because a busy machine stalled page or console. Motion was lost then."""
    return is_refused(browser) or browser.driver.execute_script("return window.lifted")


PAD = """
const buttons = Array.from({length: 17}, () => ({pressed: false, value: 0}));
window.pad = {connected: true, id: "test pad", axes: [0, 0, 0, 0], buttons};
navigator.getGamepads = () => [window.pad];
"""


class TestHandsOfAPage:
    """In one session, which is not watched by an instructor's page but where the test opens one."""

    @pytest.fixture(scope="class", autouse=True)
    def session(self, station):
        async def until_it_is_ready():
            async with Page(station.url) as page:
                await start(page, exercise="pick_hand_over_place", driver="browser")
                await page.until(lambda: page.mode() == "pedal_up", 25, "the robot is ready")

        async def to_its_end():
            async with Page(station.url) as page:
                await stop(page)

        asyncio.run(until_it_is_ready())
        yield
        asyncio.run(to_its_end())

    @pytest.fixture(scope="class")
    def tips(self, station, session):
        with Tip(station.master, "arm1") as gold, Tip(station.master, "arm2") as green:
            yield gold, green

    def test_a_mouse_moves_the_tool_and_lost_focus_lifts_the_pedal(self, station, browser, tips):
        tip = tips[0]
        driver = browser.driver
        browser.open("/trainee")
        browser.until(lambda: browser["drive"].is_enabled(), 5, "a page may drive")
        browser.click("drive")
        browser.until(lambda: "Click the picture" in browser.text("said"), 3, "the hands are there")
        picture = driver.find_element(By.ID, "screen")
        ActionChains(driver).move_to_element(picture).click().perform()
        browser.until(lambda: driver.execute_script("return document.pointerLockElement !== null"), 3, "the mouse is locked")
        time.sleep(0.3)  # the console watches a device for 0.2 s before its pedal counts
        before = tip.pose()[0]  # the tip moves only with the pedal down: motion of all presses adds up
        for _ in range(3):  # again if a busy machine delayed the console until the pedal came up
            press_pedal(browser)
            driver.execute_script(WATCH_PEDAL)
            for _ in range(30):
                ActionChains(driver, duration=10).move_by_offset(6, 0).perform()
            time.sleep(1.0)
            if not came_up(browser):
                break
        moved = 1e3 * (tip.pose()[0] - before)
        assert moved[1] < -5.0 and abs(moved[0]) < 3.0 and abs(moved[2]) < 3.0, f"right is -y of the world: {moved} mm"
        if not browser.text("mode").startswith("The hands move"):  # the pedal must count when the stall begins
            press_pedal(browser)
        driver.execute_script("const end = performance.now() + 400; while (performance.now() < end);")
        browser.until(lambda: browser.text("mode").startswith("The hands move"), 3, "a page that stalled goes on")
        console = station.programs()["master_console"]
        os.kill(console, signal.SIGSTOP)
        time.sleep(0.5)
        os.kill(console, signal.SIGCONT)
        browser.until(lambda: is_refused(browser), 3, "the page asks for another press")
        assert browser.text("mode").startswith("Ready") and "press it again" in browser.text("pedal")
        press_pedal(browser)

        async def until_the_pedal_is_up():
            async with Page(station.url) as page:
                await page.until(lambda: page.mode() == "teleoperating", 2, "the pedal is down")
                driver.switch_to.new_window("tab")  # hides the page
                await page.until(lambda: page.mode() == "pedal_up", 2, "a hidden page holds no pedal")

        asyncio.run(until_the_pedal_is_up())

    def test_a_mouse_that_the_browser_does_not_lock_needs_another_click(self, browser):
        browser.open("/trainee")
        browser.until(lambda: browser["drive"].is_enabled(), 5, "a page may drive")
        browser.click("drive")
        browser.until(lambda: "Click the picture" in browser.text("said"), 3, "the hands are there")
        browser.driver.execute_script("document.getElementById('screen').requestPointerLock = () => Promise.reject(new Error('too early'));")
        ActionChains(browser.driver).move_to_element(browser.driver.find_element(By.ID, "screen")).click().perform()
        browser.until(lambda: "click the picture again" in browser.text("said"), 3, "the page asks for another click")

    def test_a_gamepad_moves_both_arms(self, browser, tips):
        browser.open("/trainee")
        browser.driver.execute_script(PAD)
        browser.until(lambda: browser["drive"].is_enabled(), 5, "a page may drive")
        browser.click("drive")
        time.sleep(0.4)  # the console watches a device for 0.2 s before its pedal counts
        for _ in range(3):  # as a person does, presses again if the page asks for it: a busy machine stalled the page
            before = [tip.pose()[0] for tip in tips]
            browser.driver.execute_script("pad.buttons[4].pressed = true")
            browser.until(lambda: browser.text("mode").startswith("The hands move"), 5, "the shoulder button is the pedal")
            browser.driver.execute_script(WATCH_PEDAL)
            browser.driver.execute_script("pad.axes = [0.6, 0, -0.6, 0]")
            time.sleep(1.0)
            has_come_up = came_up(browser)
            browser.driver.execute_script("pad.axes = [0, 0, 0, 0]; pad.buttons[4].pressed = false")
            browser.until(lambda: browser.text("mode").startswith("Ready"), 2, "the pedal is up")
            if not has_come_up:
                break
        gold, green = (1e3 * (tip.pose()[0] - old) for tip, old in zip(tips, before))
        assert gold[1] < -5.0 and green[1] > 5.0, f"gold right, green left: {gold}, {green} mm"


def rotation_of(q):
    x, y, z, w = np.asarray(q) / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def rotation_vector(rotation):
    angle = np.arccos(np.clip((np.trace(rotation) - 1) / 2, -1, 1))
    axis = np.array([rotation[2, 1] - rotation[1, 2], rotation[0, 2] - rotation[2, 0], rotation[1, 0] - rotation[0, 1]])
    return angle * axis / max(2 * np.sin(angle), 1e-9)


class Mouse:
    """Real mouse events on the locked picture, small enough for the tool to follow."""

    def __init__(self, driver, place):
        self._driver, self._place = driver, place

    def send(self, kind, **more):
        self._driver.execute_cdp_cmd("Input.dispatchMouseEvent", {"type": kind, "x": self._place[0], "y": self._place[1], **more})

    def move(self, dx, dy, buttons=0):
        self._place = (self._place[0] + dx, self._place[1] + dy)
        self.send("mouseMoved", buttons=buttons)

    def roll(self, notches, buttons=0):
        self.send("mouseWheel", deltaX=0, deltaY=-100 * notches, buttons=buttons)


def rest(tip, end):
    """Pose of the tip once it rests: how long a motion takes depends on the machine. @param end monotonic clock."""
    time.sleep(0.12)
    p, R = tip.pose()
    while True:
        time.sleep(0.06)
        before_p, before_R = p, R
        p, R = tip.pose()
        moved = np.linalg.norm(p - before_p) > 3e-5 or np.linalg.norm(rotation_vector(R @ before_R.T)) > 3e-3
        if not moved or time.monotonic() > end:
            return p, R


def steer(browser, mouse, tip, goal_p, goal_R, seconds):
    """Moves and rotates the tool to a pose in the world with the mouse alone: the page's axes are right, forward, up. The
    endoscope looks 40 degrees down."""
    sine, cosine = 0.649, 0.761
    axes = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    end = time.monotonic() + seconds
    while time.monotonic() < end:
        if not browser.text("mode").startswith("The hands move"):
            press_pedal(browser)
        p, R = rest(tip, end)
        off, turn = axes @ (goal_p - p), axes @ rotation_vector(goal_R @ R.T)
        if np.linalg.norm(off) < 2e-4 and np.linalg.norm(turn) < 0.02:
            return True
        # The device moves ten times as far as the tool. Most of the distance, then measure again.
        x, y, z = np.clip(10.0 * 0.7 * off, -0.06, 0.06)
        mouse.move(round(x / 0.001), round(-(sine * y + cosine * z) / 0.001))
        mouse.roll(float(np.clip((cosine * y - sine * z) / 0.012, -3, 3)))
        if np.linalg.norm(turn) > 0.015:
            a, b, c = np.clip(0.7 * turn, -0.15, 0.15)
            mouse.send("mousePressed", button="right", buttons=2)
            mouse.move(round(-c / 0.004), round(-a / 0.004), buttons=2)
            mouse.roll(float(np.clip(b / 0.12, -3, 3)), buttons=2)
            mouse.send("mouseReleased", button="right", buttons=0)
    return False


def expert_waypoints(folder):
    """Poses [base] of the expert's tip in the same exercise: at the start, near the ring, at the grip, lifted."""
    output = os.path.join(folder, "expert")
    subprocess.run([os.path.join(BUILD, "devel/lib/raven2_trainer/simulate"), "--exercise", "pick_hand_over_place", "--motion", "expert",
                    "--seconds", "9", "--homing", "quick", "--seed", "2", "--output", output], check=True, capture_output=True, timeout=120)
    ticks = raven2_session.Session(output).log.ticks
    ticks = ticks[ticks["model"]["session_tick"] >= 0]
    gold = ticks["model"]["arms"][:, 0]
    held = int(np.flatnonzero(gold["contacts"] > 0)[0])
    path = np.linalg.norm(gold["p_BT"] - gold["p_BT"][held], axis=1)
    near = int(np.flatnonzero(path > 0.012)[np.flatnonzero(path > 0.012) < held][-1])
    lifted = int(np.flatnonzero(ticks["model"]["exercise"]["done"].reshape(len(ticks), -1)[:, 0] > 0)[0])
    return [(gold["p_BT"][k].copy(), rotation_of(gold["q_BT"][k])) for k in (0, near, held, min(lifted + 300, len(ticks) - 1))]


def test_a_mouse_lifts_the_ring(station, browser):
    """The mouse alone moves the tool to the expert's grip of the ring, closes it with the left button, and lifts it.
    That completes the exercise's first step."""
    start, *waypoints = expert_waypoints(station.folder)
    base = np.array([[0.0, -1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]])  # world axes in the gold base: x up, y to the surgeon, z right
    browser.open()
    browser.choose(exercise="pick_hand_over_place", hazard="none", driver="browser", trainee="")
    browser.click("start")
    browser.until(lambda: browser.text("mode").startswith("Ready"), 25, "the robot is ready")
    driver = browser.driver
    driver.get("about:blank")  # the instructor's page is drawn on another computer
    driver.switch_to.new_window("window")
    browser.open("/trainee")
    browser.until(lambda: browser["drive"].is_enabled(), 5, "a page may drive")
    browser.click("drive")
    browser.until(lambda: browser.text("drive").startswith("Give"), 5, "the page has the hands")  # only then a click locks the mouse
    box = driver.find_element(By.ID, "screen").rect
    ActionChains(driver).move_to_element(driver.find_element(By.ID, "screen")).click().perform()
    browser.until(lambda: driver.execute_script("return document.pointerLockElement !== null"), 3, "the mouse is locked")
    mouse = Mouse(driver, (box["width"] / 2, box["height"] / 2))
    with Tip(station.master) as tip:
        origin, orientation = tip.pose()
        time.sleep(0.3)
        press_pedal(browser)
        for number, (p, R) in enumerate(waypoints):
            goal_p, goal_R = origin + base @ (p - start[0]), base @ R @ start[1].T @ base.T @ orientation
            if number == 2:
                mouse.send("mousePressed", button="left", buttons=1)
                time.sleep(1.0)  # the jaws close
            assert steer(browser, mouse, tip, goal_p, goal_R, 20) or number == 2, f"waypoint {number}: {goal_p - tip.pose()[0]}"
        browser.until(lambda: driver.find_elements(By.CSS_SELECTOR, "#steps li.done"), 5, "the ring is lifted")
    driver.switch_to.window(driver.window_handles[0])
    browser.open()
    end(browser)


LAYOUT = """
const said = (id, text) => { document.getElementById(id).textContent = text; };
return arguments[0].map((mode, i) => {
  said("mode", mode);
  said("health", arguments[1][i % arguments[1].length]);
  if (document.getElementById("robot")) said("robot", arguments[2][i % arguments[2].length]);
  return [...document.querySelectorAll("button, input, select")].map((e) => [e.id, e.getBoundingClientRect().x, e.getBoundingClientRect().y]);
});
"""


@pytest.mark.parametrize("width", [1280, 820, 420])
@pytest.mark.parametrize("path", ["/", "/trainee"])
def test_pages_fit_their_window_and_no_button_moves_under_the_pointer(browser, path, width):
    browser.open(path)
    browser.driver.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": False})
    browser.driver.execute_script("for (const part of document.querySelectorAll('details')) part.open = true;")
    time.sleep(0.3)
    assert browser.driver.execute_script("return document.documentElement.scrollWidth") <= width
    for element in browser.driver.find_elements(By.CSS_SELECTOR, "button, input, select"):
        label = element.accessible_name
        assert label or not element.is_displayed(), element.get_attribute("outerHTML")
    healths = ["Everything works.", *("{1} ({2})".format(*words.health([
        (name, 1, "10 Hz, 640 x 360: less than configured, drawing takes too long")])) for name in words.ADVICE)]
    layouts = browser.driver.execute_script(LAYOUT, list(words.MODES.values()), healths, ["", *words.ROBOT.values()])
    assert len(layouts[0]) > 5 and all(layout == layouts[0] for layout in layouts), "mode, health or robot has moved a button"


AXE = "axe-core@4.10.2"  # from the npm registry; not shipped


@pytest.fixture(scope="module")
def axe(tmp_path_factory):
    """The source of axe-core. Its rules check whether everybody can use a page."""
    if not shutil.which("npm"):
        pytest.skip("npm is not installed: no axe-core")
    folder = tmp_path_factory.mktemp("axe")
    try:
        subprocess.run(["npm", "pack", "--silent", AXE], cwd=folder, check=True, capture_output=True, timeout=30)
    except (subprocess.SubprocessError, OSError):
        pytest.skip(f"{AXE} cannot be had from the npm registry")
    with tarfile.open(next(folder.glob("*.tgz"))) as archive:
        return archive.extractfile("package/axe.min.js").read().decode()


@pytest.mark.parametrize("path", ["/", "/trainee"])
def test_pages_keep_the_rules_of_axe(browser, axe, path):
    browser.open(path)
    browser.driver.execute_script(axe + "; window.axe = axe;")
    found = browser.driver.execute_async_script("const done = arguments[arguments.length - 1]; axe.run(document).then((r) => done(r.violations));")
    assert [(each["id"], each["help"], each["nodes"][0]["html"]) for each in found] == []


def test_the_keyboard_alone_is_enough(browser):
    browser.open()
    seen = set()
    for _ in range(45):
        ActionChains(browser.driver).send_keys(Keys.TAB).perform()
        seen.add(browser.driver.switch_to.active_element.get_attribute("data-test"))
    assert {"emergency-stop", "trainee", "exercise", "hazard", "driver", "start", "tab-class", "tab-sessions"} <= seen
