#!/usr/bin/python3
"""Figures of the station (doc/station.md), measured with real programs and a real Chromium.

    test/system/station_benchmark.py latency [--samples N]     # hand to picture: from a mouse event to the frame that shows the motion
    test/system/station_benchmark.py load [--seconds S]        # processor time of the station with an instructor's and a trainee's page
    test/system/station_benchmark.py watchers [--runs N] [--seconds S]   # on-time ratio of the 1 kHz loops with and without ten watchers
    test/system/station_benchmark.py answers                   # from a click on each of the instructor's buttons to its answer
    test/system/station_benchmark.py pedal [--samples N]       # from a lost focus to the pedal that is up, as the page sees it

Needs the built programs, chromium, chromium-driver and python3-selenium. Exit status: 0 measured, 1 not.
"""

import argparse
import asyncio
import json
import os
import statistics
import subprocess
import sys
import time

import psutil

sys.path.insert(0, os.path.dirname(os.path.abspath(__file__)))
from stack import BUILD  # noqa: E402
from station_rig import Page, Station  # noqa: E402
from test_station_browser import ActionChains, Browser, By, Keys, Select, press_pedal  # noqa: E402

# Returns a number that changes with the picture. Reads the area right of the status text, where only arms move.
PRINT = """
const canvas = document.querySelector('[data-test="picture"]');
const w = canvas.width, h = canvas.height;
const data = canvas.getContext("2d").getImageData(Math.floor(w * 0.36), Math.floor(h * 0.3), Math.floor(w * 0.6), Math.floor(h * 0.65)).data;
let sum = 0;
for (let i = 0; i < data.length; i += 16) sum = (sum * 31 + data[i]) % 1000000007;
return sum;
"""
WATCH = """
const done = arguments[arguments.length - 1];
const print = () => { %s };
const before = print();
let begun = null;
const screen = document.getElementById("screen");
screen.addEventListener("mousemove", () => { if (begun === null) begun = performance.now(); }, { once: true });
window.latency = null;
const look = () => {
  if (begun !== null && print() !== before) { window.latency = performance.now() - begun; return; }
  requestAnimationFrame(look);
};
requestAnimationFrame(look);
done(before);
""" % PRINT


def start_browser_session(browser):
    browser.open()
    Select(browser["exercise"]).select_by_value("none")
    browser.choose(hazard="none", driver="browser")
    browser.click("start")
    browser.until(lambda: browser.text("mode").startswith("Ready"), 25, "the robot is ready")
    browser.driver.switch_to.new_window("window")
    browser.open("/trainee")
    browser.until(lambda: browser["drive"].is_enabled(), 5, "a page may drive")
    browser.click("drive")
    time.sleep(0.3)
    ActionChains(browser.driver).move_to_element(browser.driver.find_element(By.ID, "screen")).click().perform()
    time.sleep(0.5)
    ActionChains(browser.driver).key_down(Keys.SPACE).perform()
    browser.until(lambda: browser.text("mode").startswith("The hands move"), 5, "the pedal engages")


def still(browser):
    """Waits until the arms rest: the picture must not change for half a second."""
    last, since = None, time.monotonic()
    while time.monotonic() - since < 0.5:
        now = browser.driver.execute_script(PRINT)
        if now != last:
            last, since = now, time.monotonic()
        time.sleep(0.05)


def latency(options):
    found = []
    with Station() as station:
        browser = Browser(station.url)
        start_browser_session(browser)
        for i in range(options.samples):
            still(browser)
            browser.driver.execute_async_script(WATCH)
            ActionChains(browser.driver, duration=0).move_by_offset(30 if i % 2 == 0 else -30, 0).perform()
            end = time.monotonic() + 2
            value = None
            while value is None and time.monotonic() < end:
                value = browser.driver.execute_script("return window.latency")
            if value is not None:
                found.append(value)
            print(f"{i + 1}/{options.samples}: {value and round(value)} ms", file=sys.stderr, flush=True)
        browser.close()
    found.sort()
    print(json.dumps({"samples": len(found), "median_ms": round(statistics.median(found), 1),
                      "p95_ms": round(found[int(0.95 * (len(found) - 1))], 1), "largest_ms": round(found[-1], 1)}))


def processes_of(station):
    parent = psutil.Process(station.process.pid)
    return [parent, *[p for p in parent.children(recursive=True) if "ros_side" in " ".join(p.cmdline())]]


def frames_of(browser, window):
    browser.driver.switch_to.window(window)
    return int(browser["picture"].get_attribute("data-frames") or 0)


def load(options):
    """Both pages are visible: in windows of one headless Chromium."""
    with Station() as station:
        browser = Browser(station.url)
        start_browser_session(browser)
        ours, windows = processes_of(station), browser.driver.window_handles
        shown = [-frames_of(browser, window) for window in windows]
        before = [sum(p.cpu_times()[:2]) for p in ours]
        begun = time.monotonic()
        while time.monotonic() - begun < options.seconds:
            ActionChains(browser.driver, duration=20).move_by_offset(4, 0).move_by_offset(-4, 0).perform()
        spent, wall = [sum(p.cpu_times()[:2]) - b for p, b in zip(ours, before)], time.monotonic() - begun
        shown = [(frames + frames_of(browser, window)) / wall for frames, window in zip(shown, windows)]
        browser.close()
    print(json.dumps({"server_share": round(spent[0] / wall, 3), "ros_side_share": round(sum(spent[1:]) / wall, 3),
                      "together": round(sum(spent) / wall, 3),
                      "pictures_per_second": {"instructor": round(shown[0], 1), "trainee": round(shown[1], 1)}}))


def on_time(directory):
    with open(os.path.join(directory, "metrics.json"), encoding="utf-8") as file:
        timing = json.load(file)["timing"]
    return min(loop["on_time"] / loop["ticks"] for name, loop in timing.items() if name in ("physics", "haptic"))


def bare_threads(folder, seconds):
    """Empty 1 kHz threads while the session runs. @return the process and its file of figures."""
    figures = os.path.join(folder, "bare.json")
    command = [os.path.join(BUILD, "devel/lib/raven2_trainer/timing_check"), "--bare", "--calibrate", str(seconds), "--json", figures]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL), figures


def bare_on_time(process, figures):
    assert process.wait(60) == 0
    with open(figures, encoding="utf-8") as file:
        return min(loop["on_time"] / loop["ticks"] for loop in json.load(file).values())


async def watched(station, watchers, seconds):
    pages = [Page(station.url, "trainee") for _ in range(watchers)]
    async with Page(station.url) as page:
        answer = await page.ask("start", exercise="none", hazard="none", driver="scripted")
        assert answer["ok"], answer
        for each in pages:
            await each.__aenter__()
        bare = bare_threads(station.folder, seconds)
        await asyncio.sleep(seconds)
        pictures = [each.pictures / seconds for each in pages]
        for each in pages:
            await each.__aexit__()
        await page.ask("stop")
        await page.until(lambda: page.phase() == "idle", 20, "the session has ended")
    return on_time(answer["more"]), bare_on_time(*bare), (min(pictures) if pictures else None)


def watchers(options):
    shares, bare = {0: [], 10: []}, {0: [], 10: []}
    with Station() as station:
        for run in range(2 * options.runs):
            count = 10 * (run % 2)
            share, empty, rate = asyncio.run(watched(station, count, options.seconds))
            shares[count].append(share)
            bare[count].append(empty)
            print(f"{run + 1}/{2 * options.runs}: {count} watchers, on time {share:.5f}, bare threads {empty:.5f}, pictures {rate}",
                  file=sys.stderr, flush=True)
    median = statistics.median
    print(json.dumps({"without": median(shares[0]), "with_ten": median(shares[10]),
                      "bare_without": median(bare[0]), "bare_with_ten": median(bare[10])}))


# Clicks a button and waits for the next text at the bottom of the page, and for the one behind it that is not "Button ...".
ASK = """
const done = arguments[arguments.length - 1];
const said = document.getElementById("said");
said.textContent = "";
const begun = performance.now();
let first = null;
const watch = new MutationObserver(() => {
  if (!said.textContent) return;
  first ??= performance.now() - begun;
  if (said.textContent.endsWith("\u2026")) return;
  watch.disconnect();
  done([first, performance.now() - begun, said.textContent]);
});
watch.observe(said, { childList: true, characterData: true, subtree: true });
document.querySelector(`[data-test="${arguments[0]}"]`).click();
"""
BUTTONS = ("inject", "stop-hazard", "pause", "restart", "view", "take-hands", "take-hands", "plan", "execute", "cancel-plan", "begin-simulation",
           "end-simulation", "disengage", "engage", "emergency-stop", "clear-stop", "next")


def answers(_):
    found = {}
    with Station() as station:
        browser = Browser(station.url)
        browser.open()
        browser.choose(exercise="pick_hand_over_place", hazard="sudden_jump", when="instructor", driver="browser")
        browser.click("start")
        browser.until(lambda: browser.text("mode").startswith("Ready"), 25, "the robot is ready")
        browser.driver.set_script_timeout(60)
        for name in BUTTONS:
            first, answer, text = browser.driver.execute_async_script(ASK, name)
            found[name] = {"first_ms": round(first), "answer_ms": round(answer), "answer": text}
            print(f"{name}: {first:.0f} ms, answer {answer:.0f} ms: {text}", file=sys.stderr, flush=True)
            time.sleep(0.5)
        browser.close()
    print(json.dumps({"largest_first_ms": max(each["first_ms"] for each in found.values()), "buttons": found}))


# Notes when the page loses the focus, and when it learns that the pedal is up.
LOSE = """
window.took = null;
let blurred = null;
const mode = document.getElementById("mode"), isDown = () => mode.textContent.startsWith("The hands");
window.addEventListener("blur", () => { if (isDown()) blurred = performance.now(); }, { once: true });
if (window.watch) window.watch.disconnect();
window.watch = new MutationObserver(() => { if (blurred !== null && !isDown()) window.took ??= performance.now() - blurred; });
window.watch.observe(mode, {childList: true});
"""


def pedal(options):
    found = []
    with Station() as station:
        browser = Browser(station.url)
        start_browser_session(browser)
        driver = browser.driver
        page = driver.current_window_handle
        for i in range(options.samples):
            time.sleep(0.5)
            driver.execute_script(LOSE)
            driver.switch_to.new_window("tab")
            time.sleep(0.5)
            driver.close()
            driver.switch_to.window(page)
            took = driver.execute_script("return window.took")
            if took is not None:  # else the pedal was up before: a busy machine had stalled the page or the console
                found.append(took)
            print(f"{i + 1}/{options.samples}: {took and round(took)} ms", file=sys.stderr, flush=True)
            screen = driver.find_element(By.ID, "screen")
            ActionChains(driver).move_to_element(screen).click().perform()
            press_pedal(browser)
        browser.close()
    print(json.dumps({"samples": len(found), "median_ms": round(statistics.median(found)), "largest_ms": round(max(found))}))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    kinds = parser.add_subparsers(required=True)
    for name, function in (("latency", latency), ("load", load), ("watchers", watchers), ("answers", answers), ("pedal", pedal)):
        kind = kinds.add_parser(name)
        kind.set_defaults(run=function)
        kind.add_argument("--samples", type=int, default=40)
        kind.add_argument("--runs", type=int, default=4)
        kind.add_argument("--seconds", type=float, default=60.0 if name == "watchers" else 20.0)
    options = parser.parse_args()
    options.run(options)


if __name__ == "__main__":
    main()
