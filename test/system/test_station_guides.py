"""The numbered steps of the guides for assistants and educators, carried out in a real Chromium (long form)."""

import asyncio
import csv
import io
import os
import threading
import time
import urllib.request

import pytest
from stack import FULL
from station_rig import Page
from test_station_browser import ActionChains, Keys, browser, chromium, end  # noqa: F401: fixtures

pytestmark = pytest.mark.skipif(not FULL, reason="the long form alone: RAVEN2_TRAINER_FULL=1")


class Surgeon:
    """Moves the arms from a trainee's page, in another thread: a click on the instructor's page would take the focus from a second
    window. Use as a context manager."""

    def __init__(self, url):
        self._url, self._over = url, threading.Event()
        self.pedal = self.wants_hands = False
        self.mode = None
        self._thread = threading.Thread(target=lambda: asyncio.run(self._work()))

    async def _work(self):
        async with Page(self._url, "trainee") as page:
            while not self._over.is_set():
                if self.wants_hands:
                    self.wants_hands = not (await page.ask("drive"))["ok"]
                way = 0.0003 if int(time.monotonic()) % 2 else -0.0003  # to and fro
                await page.socket.send_json({"do": "hands", "with": {"pedal": self.pedal, "arms": {"gold": {"move": [way, 0, 0]}}}})
                self.mode = page.mode()
                await asyncio.sleep(1 / 60)

    def __enter__(self):
        self._thread.start()
        return self

    def __exit__(self, *_):
        self._over.set()
        self._thread.join(10)


def press(browser, surgeon):  # noqa: F811
    """As a person does: a moment after the page says so, and again if a busy machine let the pedal come up.

    A press in the robot's first 0.3 s does not count (start_delay of config/console.yaml). The next one counts after the
    pedal was seen up."""
    for _ in range(3):
        time.sleep(0.5)
        surgeon.pedal = True
        try:
            browser.until(lambda: browser.text("mode").startswith("The hands move the robot"), 3, "the hands move the robot")
            return
        except AssertionError:
            surgeon.pedal = False
            browser.until(lambda: not browser.text("mode").startswith("The hands"), 3, "the pedal is up")
    raise AssertionError("the pedal never counted")


def said(browser, words, seconds=3):  # noqa: F811
    browser.until(lambda: words in browser.text("said"), seconds, words)


def test_the_assistants_steps(station, browser):  # noqa: F811
    browser.open()
    assert browser.text("health") == "No session: choose and press Start."
    browser.choose(trainee="ann", exercise="pick_hand_over_place", hazard="sudden_jump", when="instructor", driver="browser")
    browser.click("start")
    browser.until(lambda: browser.text("mode") == "Ready: press the pedal", 25, "the robot is ready")
    browser.until(lambda: int(browser["picture"].get_attribute("data-frames") or 0) > 5, 10, "the picture appears")
    with Surgeon(station.url) as surgeon:
        surgeon.wants_hands = True
        browser.until(lambda: not surgeon.wants_hands, 5, "the surgeon has the hands")
        press(browser, surgeon)
        assert "not begun" in browser.text("task"), "it begins when the tool leaves its place"
        browser.click("inject")
        said(browser, "acts")
        browser.click("stop-hazard")
        said(browser, "cleared")
        browser.click("pause")
        said(browser, "Paused")
        browser.until(lambda: browser.text("mode").startswith("PAUSED"), 2, "PAUSED")
        surgeon.pedal = False
        browser.until(lambda: browser.text("mode") == "PAUSED: press the pedal", 2, "the pedal is up")
        press(browser, surgeon)
        surgeon.pedal = False
        browser.until(lambda: browser.text("mode").startswith("Ready"), 3, "the pedal is up")
        browser.click("restart")
        said(browser, "Done")
        browser.click("take-hands")
        said(browser, "moves no arm")
        surgeon.wants_hands = True
        browser.until(lambda: browser["take-hands"].get_attribute("aria-pressed") == "true", 2, "the hands are away")
        assert surgeon.wants_hands, "the page must not take them"
        browser.click("take-hands")
        browser.until(lambda: not surgeon.wants_hands, 5, "the surgeon has the hands again")
        press(browser, surgeon)
        browser.click("emergency-stop")
        browser.until(lambda: browser.text("mode").startswith("STOPPED"), 2, "stopped")
        browser.click("clear-stop")
        said(browser, "The pedal is down")
        surgeon.pedal = False
        browser.until(lambda: surgeon.mode == "stopped", 2, "the pedal is up")
        browser.click("clear-stop")
        said(browser, "Done")
        browser.until(lambda: browser.text("mode").startswith("Ready"), 15, "ready again")
        press(browser, surgeon)
        surgeon.pedal = False
    end(browser)
    browser.until(lambda: browser.text("verdict").startswith("Not"), 60, "the verdict")
    first = browser["report"].get_attribute("href")
    assert first.endswith("_ann/report.html")
    browser.click("next")
    said(browser, "next attempt runs", 15)
    browser.until(lambda: browser.text("mode") == "Ready: press the pedal", 25, "the next attempt is ready")
    with Surgeon(station.url) as surgeon:
        surgeon.wants_hands = True
        browser.until(lambda: not surgeon.wants_hands, 5, "the surgeon has the hands")
        press(browser, surgeon)
    end(browser)
    assert len([name for name in os.listdir(station.sessions) if name.endswith("_ann")]) == 2
    browser.until(lambda: browser["report"].is_displayed() and browser["report"].get_attribute("href") != first, 60, "the next attempt's report")
    browser.click("video")
    link = browser.driver.find_element("id", "video-link")
    browser.until(link.is_displayed, 200, "the video is there")
    assert link.get_attribute("href").endswith("_ann/video.mp4")


def test_the_educators_steps(station, browser):  # noqa: F811
    browser.open()
    browser.choose(trainee="", curriculum="", exercise="camera_clutch", hazard="none", driver="expert")
    browser.click("start")
    browser.until(lambda: browser.text("mode").startswith("The hands move"), 25, "the demonstration moves")
    browser.until(lambda: browser.text("mode") == "No session", 240, "the demonstration ends by itself")
    browser.choose(trainee="bea", curriculum="frs_basics")
    browser.until(lambda: "1 of 8" in browser.text("stage") or "camera" in browser.text("stage").lower(), 5, "the trainee's stage")
    browser.click("start")
    browser.until(lambda: browser.text("mode") == "No session" and browser.text("verdict").startswith(("Passed", "Not")), 300, "a result")
    browser.click("tab-history")
    browser.choose(**{"history-trainee": "bea"})
    browser.until(lambda: "camera" in browser.text("history-table").lower(), 5, "the attempt")
    browser.click("tab-class")
    browser.until(lambda: "bea" in browser.text("class-table"), 5, "the class")
    address = browser["class-csv"].get_attribute("href")
    cookies = "; ".join(f"{c['name']}={c['value']}" for c in browser.driver.get_cookies())
    with urllib.request.urlopen(urllib.request.Request(address, headers={"Cookie": cookies})) as answer:
        rows = list(csv.DictReader(io.StringIO(answer.read().decode())))
    assert "bea" in [row["trainee"] for row in rows] and "" not in [row["trainee"] for row in rows]
    ActionChains(browser.driver).send_keys(Keys.SPACE).perform()
    said(browser, "No session is running")
