"""render_session as a user starts it: sessions made in lockstep, drawn, killed, drawn on, and read back by ffprobe and ffmpeg."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import time

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"
SECONDS = 60 if FULL else 10
KILLS = 10 if FULL else 3
FPS = 30
PART_FRAMES = 4 * FPS  # SessionRenderer::kPartSeconds
SMALL = ("--size", "128x72")

pytestmark = pytest.mark.skipif(not (PROGRAMS / "simulate").exists() or not (PROGRAMS / "render_session").exists(),
                                reason="simulate or render_session is not built")


def run(program, *arguments, code=0):
    done = subprocess.run([PROGRAMS / program, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                          text=True, check=False, timeout=900)
    assert done.returncode == code, done.stdout
    return done.stdout


def render(*arguments, code=0):
    return run("render_session", *SMALL, *arguments, code=code)


def probe(video, *arguments):
    done = subprocess.run(["ffprobe", "-v", "error", *arguments, "-of", "json", video], capture_output=True, text=True,
                          check=True)
    assert done.stderr == "", done.stderr
    return json.loads(done.stdout)


def frame_hashes(video):
    done = subprocess.run(["ffmpeg", "-v", "error", "-i", video, "-map", "0:v", "-f", "framemd5", "-"],
                          capture_output=True, text=True, check=True)
    assert done.stderr == "", done.stderr
    return [line for line in done.stdout.splitlines() if not line.startswith("#")]


@pytest.fixture(scope="module", name="recorded")
def record(tmp_path_factory):
    """A session with a hazard; nothing of it is changed by tests."""
    directory = tmp_path_factory.mktemp("render") / "recorded"
    run("simulate", "--seconds", SECONDS, "--homing", "quick", "--hazard", "sudden_jump", "--seed", 7, "--output", directory)
    return directory


@pytest.fixture(name="session")
def copy(recorded, tmp_path):
    return pathlib.Path(shutil.copytree(recorded, tmp_path / "a session"))


@pytest.fixture(scope="module", name="whole")
def drawn_at_once(recorded):
    """The video of a render that nobody disturbed, by one process; and how long it took [s]."""
    video = recorded.parent / "whole.mp4"
    begin = time.monotonic()
    render(recorded, "--processes", 1, "--output", video)
    return video, time.monotonic() - begin


def test_frames_length_and_chapters_are_those_of_the_session(session):
    render(session)
    video = session / "video.mp4"
    metrics = json.loads((session / "metrics.json").read_text())
    frames = round(SECONDS * FPS)
    assert abs(metrics["duration_s"] - SECONDS) < 1e-6 and metrics["frames"] == frames
    stream = probe(video, "-count_frames", "-select_streams", "v", "-show_streams")["streams"][0]
    assert int(stream["nb_read_frames"]) == frames and stream["r_frame_rate"] == f"{FPS}/1"
    assert float(stream["duration"]) == pytest.approx(SECONDS, abs=1e-3)
    chapters = probe(video, "-show_chapters")["chapters"]
    assert chapters[0]["start_time"] == "0.000000" and chapters[0]["tags"]["title"].startswith("Beginning")
    assert float(chapters[-1]["end_time"]) == pytest.approx(SECONDS, abs=1e-3)
    for one, other in zip(chapters, chapters[1:]):
        assert one["end_time"] == other["start_time"] and float(one["start_time"]) < float(one["end_time"])
    faults = json.loads((session / "faults.json").read_text())["faults"]
    hazards = [chapter for chapter in chapters if "Hazard: sudden jump" in chapter["tags"]["title"]]
    assert len(hazards) == len(faults) > 0
    for chapter, fault in zip(hazards, faults):  # the model learns of it some ticks later
        assert 0.0 <= float(chapter["start_time"]) - fault["model"]["first_tick"] / 1000 < 0.1
    assert not (session / "video.parts").exists()


def test_the_number_of_processes_changes_nothing(recorded, whole, tmp_path):
    for processes in (2, 3):
        render(recorded, "--processes", processes, "--output", tmp_path / f"{processes}.mp4")
        assert (tmp_path / f"{processes}.mp4").read_bytes() == whole[0].read_bytes()


def parts_of(session):
    """{name: when it was written} of the finished parts."""
    return {part.name: part.stat().st_mtime_ns for part in (session / "video.parts").glob("part_*.mp4")}


def processes_at(session):
    """Command lines of living processes that name this session."""
    found = []
    for entry in pathlib.Path("/proc").iterdir():
        try:
            if entry.name.isdigit() and str(session) in (entry / "cmdline").read_text() and \
                    (entry / "stat").read_text().rsplit(")", 1)[1].split()[0] != "Z":
                found.append(entry.name)
        except OSError:
            pass
    return found


def start(session, processes):
    return subprocess.Popen([PROGRAMS / "render_session", *SMALL, session, "--processes", str(processes)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)


def kill(worker, session):
    """All that it started ends with it."""
    worker.send_signal(signal.SIGKILL)
    worker.wait()
    end = time.monotonic() + 120
    while processes_at(session) and time.monotonic() < end:
        time.sleep(0.05)
    assert not processes_at(session), "a killed render leaves no process behind"


def kill_after(session, seconds, processes):
    """Whether it was still at work."""
    worker = start(session, processes)
    try:
        worker.wait(seconds)
        return False
    except subprocess.TimeoutExpired:
        kill(worker, session)
        return True


def test_a_render_that_is_killed_at_any_moment_gives_the_same_file(session, whole):
    chance = random.Random(20_260)
    video, took = whole
    killed, kept = 0, {}
    while killed < KILLS:
        if not kill_after(session, chance.uniform(0.05, 0.6) * took, processes=1 + killed % 2):
            (session / "video.mp4").unlink()  # the machine has become faster, or little was left
            took, kept = 0.7 * took, {}
            continue
        killed += 1
        assert not (session / "video.mp4").exists(), "no video before it is whole"
        if (session / "video.parts").exists():
            parts = parts_of(session)
            assert kept.items() <= parts.items(), "what was finished is not drawn again"
            kept = parts
    told = render(session)
    if kept:
        frames = sum(min(PART_FRAMES, round(SECONDS * FPS) - PART_FRAMES * int(name.split("_")[1])) for name in kept)
        assert f"{frames} of them drawn before" in told, (told, kept)
    assert frame_hashes(session / "video.mp4") == frame_hashes(video)
    assert len(frame_hashes(video)) == round(SECONDS * FPS)
    assert (session / "video.mp4").read_bytes() == video.read_bytes()


@pytest.mark.parametrize("damage", ["flipped", "half"])
def test_a_damaged_part_is_drawn_again(session, whole, damage):
    worker = start(session, processes=1)
    while not parts_of(session):
        assert worker.poll() is None
        time.sleep(0.01)
    kill(worker, session)
    part = session / "video.parts" / sorted(parts_of(session))[0]
    content = bytearray(part.read_bytes())
    if damage == "flipped":
        content[random.Random(3).randrange(len(content))] ^= 0x04
    else:
        del content[len(content) // 2:]
    part.write_bytes(content)
    whole_parts = len(parts_of(session)) - 1
    told = render(session)
    assert ("drawn before" in told) == (whole_parts > 0), told
    assert (session / "video.mp4").read_bytes() == whole[0].read_bytes()


def test_many_sessions_are_drawn_one_after_the_other_and_a_bad_one_stops_nobody(session, tmp_path):
    night = tmp_path / "sessions"
    night.mkdir()
    for name in ("a", "c", "d"):
        shutil.copytree(session, night / name)
    (night / "b").mkdir()                              # no session
    (night / "index.json").write_text("{}")            # sessions/* names it, too
    shutil.copy(session / "session.rlog", night / "b" / "other")
    render(night / "c")
    before = (night / "c" / "video.mp4").stat().st_mtime_ns

    told = render(*sorted(night.iterdir()), "--to", 0.5, code=1)
    assert "c/video.mp4 is there; --again draws it anew" in told, told
    assert "b: is no session directory" in told and "1 of 4 sessions failed" in told, told
    assert (night / "c" / "video.mp4").stat().st_mtime_ns == before
    for name in ("a", "d"):
        assert int(probe(night / name / "video.mp4", "-show_streams")["streams"][0]["nb_frames"]) == FPS // 2

    told = render(night / "a", night / "c", "--to", 0.2, "--again")
    for name in ("a", "c"):
        assert int(probe(night / name / "video.mp4", "-show_streams")["streams"][0]["nb_frames"]) == 6, told
    # A video that was cut short by something else is none.
    video = night / "a" / "video.mp4"
    video.write_bytes(video.read_bytes()[:-100])
    assert "is there" not in render(night / "a", "--to", 0.2)
    assert "is there" in render(night / "a", "--to", 0.2)


def test_output_takes_one_session(session):
    assert "--output" in render(session, session, "--output", session / "x.mp4", code=1)
    assert not (session / "x.mp4").exists()
    assert "no session directory" in render(session / "meta.json", session / "metrics.json", code=1)


def test_two_renders_of_one_video_do_not_meet(session):
    first = start(session, processes=1)
    end = time.monotonic() + 60
    while not (session / "video.parts" / "lock").exists():
        assert time.monotonic() < end and first.poll() is None
        time.sleep(0.01)
    first.send_signal(signal.SIGSTOP)
    try:
        assert "another process is drawing this video" in render(session, code=1)
    finally:
        first.send_signal(signal.SIGCONT)
    assert first.wait(120) == 0 and (session / "video.mp4").exists()


def test_simulate_from_log_is_resimulate(session, tmp_path):
    told = run("simulate", "--from-log", session, "--output", tmp_path / "again")
    assert "equal: " in told
    lines = [line for line in run("resimulate", session).splitlines() if "equal" in line]
    assert lines == [line for line in told.splitlines() if "equal" in line]
    assert (tmp_path / "again" / "session.rlog").exists()
    refused = subprocess.run([PROGRAMS / "simulate", "--from-log", session, "--seed", "3"], capture_output=True, text=True,
                             check=False)
    assert refused.returncode != 0 and "--from-log" in refused.stderr and "--seed" in refused.stderr
