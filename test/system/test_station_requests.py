"""Requests to the station over WebSocket, HTTP and ROS services, valid and invalid, with real programs and ROS master."""

import asyncio
import json
import os
import random
import shutil
import socket
import subprocess
import sys

import aiohttp
import pytest
import yaml
from stack import BUILD, ROOT, effort, free_ports, wait_until
from station_rig import STATION, Page, Station, start, stop

sys.path.insert(0, os.path.join(ROOT, "scripts"))
from raven2_station import access  # noqa: E402


def test_a_curriculum_starts_the_stage_of_its_trainee(station):
    with open(os.path.join(ROOT, "config/curricula/frs_basics.yaml"), encoding="utf-8") as file:
        stages = yaml.safe_load(file)["stages"]
    drill = next(i for i, stage in enumerate(stages) if stage["drill"] != "none")
    passes = [stage["exercise"] for stage in stages[:drill] for _ in range(stage["passes"] + stage["extra"])]
    index = os.path.join(station.sessions, "index.json")
    entries = [{"directory": f"s{i}", "start_time_utc": f"2020-01-01T10:{i:02d}:00Z", "trainee": "cal", "exercise": exercise, "drill": "",
                "attempts": [{"status": "done", "passed": True, "metrics": {}}]} for i, exercise in enumerate(passes)]
    os.makedirs(station.sessions, exist_ok=True)
    with open(index, "w", encoding="utf-8") as file:
        json.dump({"version": 1, "sessions": entries}, file)

    async def scenario():
        async with Page(station.url) as page:
            stage = (await page.ask("stage", curriculum="frs_basics", trainee="cal"))["more"]
            assert stage["current"] == drill and not (await page.ask("stage", curriculum="nonsense"))["ok"]
            for trainee, own in (("new", stages[0]), ("cal", stages[drill])):
                await start(page, curriculum="frs_basics", trainee=trainee, driver="expert")
                assert page.newest["station"]["choice"]["exercise"] == own["exercise"]
                await page.until(lambda: page.newest.get("session", {}).get("directory", "").endswith("_" + trainee), 10, "the daemon's session")
                session = page.newest["session"]
                assert (session["exercise"], session["drill"] or "none") == (own["exercise"], own["drill"]), session
                await stop(page)
    asyncio.run(scenario())
    os.remove(index)


def test_a_past_session_is_replayed_in_the_picture(station):
    async def scenario():
        async with Page(station.url) as page:
            await start(page, exercise="none", hazard="none", driver="scripted")
            await page.until(lambda: page.mode() == "teleoperating", 20, "the session moves")
            await asyncio.sleep(1.0)
            await stop(page)
            past = page.newest["station"]["last"]
            assert not (await page.ask("replay", session="../x"))["ok"]
            answer = await page.ask("replay", session=past, seconds=60)
            assert answer["ok"], answer
            await page.until(lambda: page.mode() == "replaying", 5, "the past session is shown")
            assert page.newest["station"]["choice"]["trainee"] == "", "a replay counts for no trainee"
            listed = (await page.ask("sessions"))["more"]["count"]
            assert (await page.ask("end-replay"))["ok"]
            await page.until(lambda: page.mode() == "pedal_up", 5, "the replay has ended")
            assert not (await page.ask("drive"))["ok"], "nothing of a replay is kept"
            await stop(page)
            assert (await page.ask("sessions"))["more"]["count"] == listed and page.newest["station"]["last"] == past
    asyncio.run(scenario())


def test_a_trainer_of_a_launch_file_is_used_and_not_doubled(station):
    ports = dict(zip(("--master-port", "--robot-port", "--force-port", "--sight-port", "--state-port"), map(str, free_ports(5))))
    common = [word for pair in ports.items() for word in pair]
    output = ["--output", os.path.join(station.folder, "foreign")]
    programs = [subprocess.Popen([os.path.join(BUILD, "devel/lib/raven2_trainer", name), *options, *common], env=station.environment,
                                 stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                for name, options in (("virtual_raven", ["--homing", "quick"]), ("master_console", ["--motion", "scripted"]),
                                      ("simulator", ["--duration", "0", *output]))]

    async def scenario():
        async with Page(station.url) as page:
            await page.until(lambda: page.newest.get("station", {}).get("foreign"), 15, "the station finds the trainer")
            refused = await page.ask("start", exercise="none")
            assert not refused["ok"] and "did not start" in refused["text"], refused
            await page.until(lambda: page.mode() == "teleoperating", 20, "the trainer moves")
            assert (await page.ask("emergency-stop"))["ok"]
            await page.until(lambda: page.mode() == "stopped", 2, "stopped")
            assert not (await page.ask("stop"))["ok"] and all(p.poll() is None for p in programs), "foreign programs live on"
            for program in reversed(programs):
                program.terminate()
                program.wait(15)
            await page.until(lambda: not page.newest["station"]["foreign"], 5, "the station notices the trainer's end")
            refused = await page.ask("start", exercise="nonsense")
            assert "nonsense" in refused["text"], "only the exercise is wrong now"
    try:
        asyncio.run(scenario())
    finally:
        for program in programs:
            program.kill()
            program.wait()


@pytest.mark.parametrize("origin, cookie", [("http://evil.example", True), ("null", True), (None, False)])
def test_strangers_get_no_socket(station, origin, cookie):
    async def scenario():
        with pytest.raises(aiohttp.WSServerHandshakeError) as refused:
            async with Page(station.url, origin=origin, cookie=cookie):
                pass
        assert refused.value.status == 403
    asyncio.run(scenario())


@pytest.mark.parametrize("path", ["/sessions/../etc/passwd", "/sessions/%2e%2e/index.json", "/sessions/x/report.html",
                                  "/sessions/%2e%2e%2findex.json/report.html", "/static/../station", "/static/station.py", "/ws/../x"])
def test_paths_that_lead_elsewhere_are_refused(station, path):
    async def scenario():
        async with Page(station.url) as page:
            from yarl import URL
            async with page.http.get(URL(station.url + path, encoded=True)) as answer:
                assert answer.status in (400, 403, 404), answer.status
    asyncio.run(scenario())


def test_answers_carry_the_headers_and_foreign_names_are_sent_away(station):
    async def scenario():
        async with aiohttp.ClientSession() as http:
            async with http.get(station.url + "/") as answer:
                assert "default-src 'none'" in answer.headers["Content-Security-Policy"]
                assert answer.headers["X-Content-Type-Options"] == "nosniff"
                cookie = answer.headers["Set-Cookie"]
                assert "HttpOnly" in cookie and "SameSite=Lax" in cookie and cookie.startswith(f"raven2_station_{station.port}=")
            async with http.get(station.url + "/", headers={"Host": "evil.example"}) as answer:
                assert answer.status == 421
            async with http.get(station.url + "/sessions/x/report.html", cookies={}) as answer:
                assert answer.status in (403, 404)
    asyncio.run(scenario())


@pytest.fixture
def guarded(tmp_path):
    """Open to other computers: password and TLS."""
    if not shutil.which("openssl"):
        pytest.skip("openssl is not installed")
    key, certificate, password = (tmp_path / name for name in ("key.pem", "certificate.pem", "password"))
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:P-256", "-nodes", "-days", "2", "-subj",
                    "/CN=localhost", "-keyout", key, "-out", certificate], check=True, capture_output=True)
    password.write_text(access.make_hash("operating room 3"))
    password.chmod(0o600)
    with Station("--bind", "0.0.0.0", "--password-file", str(password), "--tls-certificate", str(certificate), "--tls-key", str(key)) as started:
        yield started


def test_other_computers_need_the_password(guarded):
    url = guarded.url.replace("http:", "https:")

    async def scenario():
        async with aiohttp.ClientSession(cookie_jar=aiohttp.CookieJar(), connector=aiohttp.TCPConnector(ssl=False)) as http:
            async def refused(path):
                async with http.get(url + path) as answer:
                    return answer.status == 403
            async with http.get(url + "/") as answer:
                assert "password" in await answer.text() and not answer.cookies
            async with http.get(url + "/trainee") as answer:
                assert 'value="/trainee" selected' in await answer.text(), "who came for this page gets it after the login"
            async with http.post(url + "/login", data={"password": "wrong", "next": "/trainee"}, headers={"Origin": url}) as answer:
                text = await answer.text()
                assert answer.status == 403 and "Wrong password." in text and 'value="/trainee" selected' in text
            assert await refused("/ws?page=instructor") and await refused("/class.csv") and await refused("/sessions/x/report.html")
            for given, origin, status in (("wrong", url, 403), ("operating room 3", "https://evil.example", 403), ("operating room 3", url, 303)):
                async with http.post(url + "/login", data={"password": given}, headers={"Origin": origin}, allow_redirects=False) as answer:
                    assert answer.status == status, given
            for wanted, leads in (("/trainee", "/trainee"), ("/", "/"), ("https://evil.example", "/"), ("//evil.example", "/")):
                async with http.post(url + "/login", data={"password": "operating room 3", "next": wanted}, headers={"Origin": url},
                                     allow_redirects=False) as answer:
                    assert answer.headers["Location"] == leads
            cookie = answer.cookies[f"raven2_station_{guarded.port}"]
            assert cookie["secure"] and cookie["httponly"]
            async with http.get(url + "/") as answer:
                assert "Emergency stop" in await answer.text()
            async with http.ws_connect(url + "/ws?page=instructor", origin=url) as socket:
                assert json.loads((await socket.receive()).data)["t"] == "hello"
    asyncio.run(scenario())


def junk(source):
    """A random message that no page sends."""
    value = [None, True, -1, 1e308, "x" * source.randint(0, 200), [], {}, [[[]]], {"a": {"b": [1, None]}}]
    names = ["start", "stop", "next", "inject", "drive", "hands", "delete", "verdict", "watch", "take-hands", "history", "class",
             "report", "video", "view", "plan", "__init__", "do", "../x", ""]
    kind = source.random()
    if kind < 0.15:
        return bytes(source.randrange(256) for _ in range(source.randint(0, 60)))
    if kind < 0.3:
        return json.dumps(source.choice(value))
    message = {"id": source.choice(value), "do": source.choice(names + value), "with": source.choice(value + [
        {k: source.choice(value) for k in source.sample(["trainee", "exercise", "session", "sure", "hazard", "pedal", "arms", "seed"], 3)}])}
    return json.dumps(message)


def test_messages_that_no_page_sends_end_nothing(station):
    async def scenario():
        source = random.Random(int(os.environ.get("RAVEN2_TRAINER_SEED", 33)))
        async with Page(station.url) as page, Page(station.url, "trainee") as trainee:
            for i in range(effort(300, 5000)):
                message = junk(source)
                to = page if i % 2 else trainee
                await (to.socket.send_bytes(message) if isinstance(message, bytes) else to.socket.send_str(message))
                await asyncio.sleep(0.006)
            assert (await page.ask("sessions"))["ok"]
            await page.until(lambda: page.phase() in ("idle", "running"), 30, "a requested session has begun")
            if page.phase() == "running":  # a start without choices is valid, and so is a stop that waits behind it
                answer = await page.ask("stop")
                assert answer["ok"] or answer["text"] == "no session is running", answer
                await page.until(lambda: page.phase() == "idle", 20, "the session has ended")
        assert "Traceback" not in station.log(), station.log()[-3000:]
    asyncio.run(scenario())


def test_floods_and_giants_are_cut_off(station):
    async def scenario():
        async with Page(station.url) as other:
            async with Page(station.url) as fast:
                for _ in range(1500):
                    await fast.socket.send_str('{"do": "hands", "with": {}}')
                await fast.until(lambda: "too many messages" in fast.newest.get("reply", {}).get("text", ""), 10, "the page learns why")
            page = Page(station.url)
            async with page:
                try:
                    for _ in range(10000):
                        await page.socket.send_str('{"do": "hands", "with": {}}')
                except (ConnectionError, aiohttp.ClientError):
                    pass
                await page.until(lambda: page.socket.closed, 10, "a flood is cut off")
                assert page.socket.close_code in (1008, 1006), "1006: closed while the page still sent"
            giant = Page(station.url)
            async with giant:
                try:
                    await giant.socket.send_str("x" * (1 << 20))
                except (ConnectionError, aiohttp.ClientError):
                    pass
                await giant.until(lambda: giant.socket.closed, 10, "a giant is cut off")
            assert (await other.ask("sessions"))["ok"]
    asyncio.run(scenario())


def test_two_sessions_at_once_are_refused_and_so_is_what_cannot_be(station):
    async def scenario():
        async with Page(station.url) as page:
            for choice in ({"exercise": "nonsense"}, {"trainee": "Not An Id"}, {"driver": "expert"}):
                answer = await page.ask("start", **choice)
                assert not answer["ok"] and len(answer["text"]) > 10
            assert page.phase() == "idle" and station.programs() == {}
            assert not (await page.ask("stop"))["ok"]
            await start(page, exercise="none", hazard="none", driver="scripted")
            answer = await page.ask("start", exercise="none")
            assert not answer["ok"] and "stop it first" in answer["text"]
            await page.until(lambda: page.mode() == "teleoperating", 20, "the session moves")
            assert (await page.ask("pause"))["ok"]
            await page.until(lambda: page.mode() == "paused", 2, "paused")
            assert (await page.ask("emergency-stop"))["ok"]
            await page.until(lambda: page.mode() == "stopped", 2, "stopped")
            answer = await page.ask("pause")
            assert (answer["ok"], answer["text"]) == (False, "Nothing to pause in mode stopped.")
            before = page.newest["station"]["session"]
            assert (await page.ask("next", seconds=60))["ok"]
            await page.until(lambda: page.newest["station"]["session"] not in (None, before), 10, "the next attempt")
            await stop(page)
    asyncio.run(scenario())


def has_services(station):
    listed = subprocess.run(["rosservice", "list"], env=station.environment, capture_output=True, text=True, check=False, timeout=20)
    return "/station/start_session" in listed.stdout


def test_a_master_that_starts_again_at_once_is_noticed(station):
    async def scenario():
        async with Page(station.url) as page:
            station.master.kill()
            station.master.start()
            await page.until(lambda: has_services(station), 15, "the station's services are at the new master")
            await start(page, driver="scripted")
            await page.until(lambda: page.mode() is not None, 20, "the trainer is heard")
            assert (await page.ask("emergency-stop"))["ok"]
            await stop(page)
    asyncio.run(scenario())


def test_a_second_station_waits_and_takes_nothing_away(station):
    port = free_ports(1)[0]
    with open(station.log_file, "ab") as log:
        second = subprocess.Popen([STATION, "--port", str(port), "--sessions", station.sessions + "_2"], env=station.environment,
                                  stdout=log, stderr=log)
    try:
        async def scenario():
            wait_until(lambda: socket.socket().connect_ex(("127.0.0.1", port)) == 0, 20, "the second station answers")
            async with Page(station.url) as first, Page(f"http://localhost:{port}") as other:
                await other.until(lambda: "Another station" in other.newest.get("health", {}).get("text", ""), 10, "it says why it waits")
                await start(first, driver="scripted")
                await first.until(lambda: first.mode() is not None, 20, "the first one hears its trainer")
                assert (await first.ask("emergency-stop"))["ok"]
                await stop(first)
        asyncio.run(scenario())
    finally:
        second.terminate()
        second.wait(20)


def test_the_services_do_what_the_page_does(station):
    master = station.master
    call = ["rosservice", "call", "--wait", "/station/start_session"]
    arguments = "{exercise: none, hazard: none, driver: scripted, link: none, when: own, seed: 3}"
    answer = master.run(*call, arguments, seconds=60)
    assert "success: True" in answer.stdout, answer
    refused = master.run(*call, arguments, seconds=60)
    assert "success: False" in refused.stdout and "stop it first" in refused.stdout
    wait_until(lambda: "simulator" in station.programs(), 5, "the daemon runs")
    assert "success: True" in master.run("rosservice", "call", "/station/end_session", seconds=60).stdout
    assert station.programs() == {}
