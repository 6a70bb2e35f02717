"""render_session as a user starts it. Renders of sessions made in lockstep are killed and resumed. ffprobe and ffmpeg
read the videos."""
import json
import os
import pathlib
import random
import shutil
import signal
import subprocess
import sys
import time
import zlib

import numpy as np
import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import raven2_session  # noqa: E402

PROGRAMS = pathlib.Path(os.environ.get("RAVEN2_TRAINER_BUILD", ROOT / "build")) / "devel/lib/raven2_trainer"
FULL = os.environ.get("RAVEN2_TRAINER_FULL") == "1"
SECONDS = 60 if FULL else 9  # three parts; the hazard comes at 8 s
BRIEF = 3  # length [s] where any session will do
KILLS = 10 if FULL else 3
FPS = 30  # if no option says otherwise
RATE = FPS if FULL else 10  # of the videos that are killed and resumed
AT_RATE = ("--fps", str(RATE))
FEW = ("--fps", 1)  # frames, where any will do
PART_FRAMES = 4 * RATE  # SessionRenderer::kPartSeconds
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
    """A session with a hazard. Tests do not change it."""
    directory = tmp_path_factory.mktemp("render") / "a session"
    run("simulate", "--seconds", SECONDS, "--homing", "quick", "--hazard", "sudden_jump", "--seed", 7, "--output", directory)
    return directory


@pytest.fixture(name="session")
def copy(recorded, tmp_path):
    """A copy of the same name: the name is the title of the video."""
    return pathlib.Path(shutil.copytree(recorded, tmp_path / recorded.name))


@pytest.fixture(scope="module", name="recorded_brief")
def record_brief(tmp_path_factory):
    directory = tmp_path_factory.mktemp("brief") / "brief"
    run("simulate", "--seconds", BRIEF, "--homing", "quick", "--hazard", "none", "--seed", 7, "--output", directory)
    return directory


@pytest.fixture(name="brief")
def copy_brief(recorded_brief, tmp_path):
    return pathlib.Path(shutil.copytree(recorded_brief, tmp_path / recorded_brief.name))


@pytest.fixture(scope="module", name="whole")
def drawn_at_once(recorded):
    """The video of an undisturbed render by one process, and how long it took [s]."""
    video = recorded.parent / "whole.mp4"
    begin = time.monotonic()
    render(recorded, *AT_RATE, "--processes", 1, "--output", video)
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
        render(recorded, *AT_RATE, "--processes", processes, "--output", tmp_path / f"{processes}.mp4")
        assert (tmp_path / f"{processes}.mp4").read_bytes() == whole[0].read_bytes()


def test_a_video_says_of_which_session_camera_and_span_it_is(whole):
    tags = probe(whole[0], "-show_format")["format"]["tags"]
    assert tags["title"] == "a session"
    assert tags["description"] == f"Camera endoscope, in the corner overview; 0.00 s to {SECONDS:.2f} s of the session"
    assert tags["comment"].startswith("raven2_trainer settings ")


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


def start(session, processes, environment=None):
    return subprocess.Popen([PROGRAMS / "render_session", *SMALL, *AT_RATE, session, "--processes", str(processes)],
                            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)


WAITING_FFMPEG = """#!/bin/sh
case "$*" in *{draft}*) exec setpriv --pdeathsig KILL sh -c 'touch "$0"; exec sleep 900' "{held}" ;; esac
exec {ffmpeg} "$@"
"""


def waiting_at(folder, draft):
    """(environment, file): a render with it waits in the ffmpeg of this draft, however fast it is, and then the file exists."""
    folder.mkdir()
    (folder / "ffmpeg").write_text(WAITING_FFMPEG.format(draft=draft, held=folder / "held", ffmpeg=shutil.which("ffmpeg")))
    (folder / "ffmpeg").chmod(0o755)
    return {**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"}, folder / "held"


def await_file(worker, held):
    while not held.exists():
        assert worker.poll() is None
        time.sleep(0.01)


def kill(worker, session):
    """Kills a render. The processes that it started must end, too."""
    worker.send_signal(signal.SIGKILL)
    worker.wait()
    end, looks = time.monotonic() + 120, 0
    while looks < 3 and time.monotonic() < end:  # a process that begins a program has no command line for an instant
        looks = 0 if processes_at(session) else looks + 1
        time.sleep(0.05)
    assert looks == 3, "a killed render leaves no process behind"


def kill_after(session, seconds, processes):
    """Kills a render after so many seconds, unless it has finished."""
    worker = start(session, processes)
    try:
        assert worker.wait(seconds) == 0
    except subprocess.TimeoutExpired:
        kill(worker, session)


def kill_with_a_part(session):
    """Kills a render whose first part exists, in the second one."""
    environment, held = waiting_at(session.parent / "bin", "draft_00001_")
    worker = start(session, 1, environment)
    await_file(worker, held)
    assert parts_of(session)
    kill(worker, session)


@pytest.fixture(scope="module", name="killed")
def kill_once(recorded, tmp_path_factory):
    """A session whose render was killed after its first part. Tests do not change it."""
    session = pathlib.Path(shutil.copytree(recorded, tmp_path_factory.mktemp("killed") / recorded.name))
    kill_with_a_part(session)
    return session


@pytest.fixture(name="begun")
def copy_killed(killed, tmp_path):
    return pathlib.Path(shutil.copytree(killed, tmp_path / killed.name))


def frames_of(parts):
    return sum(min(PART_FRAMES, round(SECONDS * RATE) - PART_FRAMES * int(name.split("_")[1])) for name in parts)


def test_what_was_finished_when_a_render_was_killed_is_not_drawn_again(begun, whole):
    kept = parts_of(begun)
    assert kept
    told = render(begun, *AT_RATE)
    assert f"{frames_of(kept)} of them drawn before" in told, (told, kept)
    assert (begun / "video.mp4").read_bytes() == whole[0].read_bytes()


def test_a_render_that_is_killed_at_any_moment_gives_the_same_file(session, whole):
    chance = random.Random(20_260)
    video, took = whole
    killed, kept = 0, {}
    while killed < KILLS:
        kill_after(session, chance.uniform(0.05, 0.9) * took, processes=1 + killed % 2)
        if (session / "video.mp4").exists():  # too late: the machine has become faster, or little was left
            assert (session / "video.mp4").read_bytes() == video.read_bytes(), "a video appears only when complete"
            (session / "video.mp4").unlink()
            took, kept = 0.7 * took, {}
            continue
        killed += 1
        if (session / "video.parts").exists():
            parts = parts_of(session)
            assert kept.items() <= parts.items(), "finished parts must not be drawn again"
            kept = parts
    told = render(session, *AT_RATE)
    assert ("drawn before" in told) == bool(kept), (told, kept)
    assert not kept or f"{frames_of(kept)} of them drawn before" in told, (told, kept)
    assert frame_hashes(session / "video.mp4") == frame_hashes(video)
    assert len(frame_hashes(video)) == round(SECONDS * RATE)
    assert (session / "video.mp4").read_bytes() == video.read_bytes()


@pytest.mark.parametrize("damage", ["flipped", "half"])
def test_a_damaged_part_is_drawn_again(begun, whole, damage):
    part = begun / "video.parts" / sorted(parts_of(begun))[0]
    content = bytearray(part.read_bytes())
    if damage == "flipped":
        content[random.Random(3).randrange(len(content))] ^= 0x04
    else:
        del content[len(content) // 2:]
    part.write_bytes(content)
    whole_parts = len(parts_of(begun)) - 1
    told = render(begun, *AT_RATE)
    assert ("drawn before" in told) == (whole_parts > 0), told
    assert (begun / "video.mp4").read_bytes() == whole[0].read_bytes()


def made(video):
    return video.stat().st_mtime_ns


def test_many_sessions_are_drawn_one_after_the_other_and_a_bad_one_stops_nobody(brief, tmp_path):
    night = tmp_path / "sessions"
    night.mkdir()
    for name in ("a", "c", "d"):
        shutil.copytree(brief, night / name)
    (night / "b").mkdir()                              # not a session
    (night / "index.json").write_text("{}")            # sessions/* matches it, too
    shutil.copy(brief / "session.rlog", night / "b" / "other")
    render(night / "c", *FEW)
    before = made(night / "c" / "video.mp4")

    told = render(*sorted(night.iterdir()), *FEW, code=1)
    assert "c/video.mp4 exists; --again draws it again" in told, told
    assert "b: is no session directory" in told and "1 of 4 sessions failed" in told, told
    assert made(night / "c" / "video.mp4") == before
    for name in ("a", "d"):
        assert int(probe(night / name / "video.mp4", "-show_streams")["streams"][0]["nb_frames"]) == BRIEF

    # A video that something else truncated does not count as existing.
    video = night / "a" / "video.mp4"
    video.write_bytes(video.read_bytes()[:-100])
    assert "exists; --again" not in render(night / "a", *FEW)
    assert "exists; --again" in render(night / "a", *FEW)


def test_a_video_is_drawn_again_where_another_one_is_asked_for(brief):
    video = brief / "video.mp4"
    for options in (FEW, (*FEW, "--camera", "top"), (*FEW, "--overlay", "none"), ("--fps", 2)):
        assert "exists; --again" not in render(brief, *options), options
        before = made(video)
        assert "exists; --again" in render(brief, *options), options
        assert made(video) == before
    assert "exists; --again" not in render(brief, "--fps", 2, "--again")
    assert made(video) > before


def test_again_that_was_killed_goes_on_without_again(brief, tmp_path):
    night = [pathlib.Path(shutil.copytree(brief, tmp_path / name)) for name in ("a", "b", "c")]
    videos = [directory / "video.mp4" for directory in night]
    render(*night, *FEW)
    before = [made(video) for video in videos]
    environment, held = waiting_at(tmp_path / "bin", "/b/video.parts/draft_")
    worker = subprocess.Popen([PROGRAMS / "render_session", *SMALL, *night, "--fps", "1", "--again"],
                              stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, env=environment)
    await_file(worker, held)
    assert made(videos[0]) != before[0] and not (night[0] / "video.parts").exists()
    kill(worker, tmp_path)
    assert (night[2] / "video.parts").exists() and made(videos[2]) == before[2], "the old video stays until then"
    first = made(videos[0])
    told = render(*night, *FEW)
    assert "a/video.mp4 exists" in told and "c/video.mp4 exists" not in told, told
    assert made(videos[0]) == first and all(made(video) > then for video, then in zip(videos, before))
    assert not list(tmp_path.glob("*/video.parts"))


def test_simulate_draws_the_video_that_render_session_would(tmp_path):
    directory = tmp_path / "short"
    run("simulate", "--seconds", 0.2, "--homing", "quick", "--hazard", "none", "--video", "--output", directory)
    assert "video.mp4 exists" in run("render_session", directory)


def test_a_session_that_is_still_being_recorded_is_refused(tmp_path):
    directory = tmp_path / "running"
    recorder = subprocess.Popen([PROGRAMS / "simulate", "--seconds", "3600", "--homing", "quick", "--output",
                                 directory], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    try:
        end = time.monotonic() + 60
        log = directory / "session.rlog"
        while not log.exists() or log.stat().st_size < 1_000_000:
            assert time.monotonic() < end and recorder.poll() is None
            time.sleep(0.01)
        recorder.send_signal(signal.SIGSTOP)
        assert "is still being recorded" in render(directory, code=1)
        assert not (directory / "video.mp4").exists() and not (directory / "video.parts").exists()
    finally:
        recorder.kill()
        recorder.wait()


def test_a_part_of_a_session_needs_a_place_of_its_own(brief, tmp_path):
    before = (brief / "metrics.json").read_bytes()
    assert "--output" in render(brief, "--to", 0.5, code=1)
    assert not (brief / "video.mp4").exists() and not (brief / "video.parts").exists()
    render(brief, "--from", 1, "--to", 1.5, "--output", tmp_path / "part.mp4")
    assert int(probe(tmp_path / "part.mp4", "-show_streams")["streams"][0]["nb_frames"]) == FPS // 2
    assert (brief / "metrics.json").read_bytes() == before
    assert "film.mkv" in render(brief, "--output", tmp_path / "film.mkv", code=1)
    assert not (tmp_path / "film.mkv").exists()


def test_pictures_of_an_earlier_render_are_refused_or_removed(brief, tmp_path):
    folder = tmp_path / "tmp.pictures"
    folder.mkdir()
    (folder / "mine.png").write_text("mine")
    render(brief, *FEW, "--output", folder)
    assert len(list(folder.glob("frame_*.png"))) == BRIEF
    assert "--again" in render(brief, *FEW, "--to", 2, "--output", folder, code=1)
    render(brief, *FEW, "--to", 2, "--output", folder, "--again")
    assert sorted(entry.name for entry in folder.iterdir()) == ["frame_000000.png", "frame_000001.png", "mine.png"]


def test_a_folder_of_somebody_elses_is_left_alone(brief, tmp_path):
    (tmp_path / "talk.parts").mkdir()
    (tmp_path / "talk.parts" / "slides.pdf").write_text("of a talk")
    assert "talk.parts: is no folder of a video's parts" in render(brief, "--output", tmp_path / "talk.mp4", code=1)
    assert [entry.name for entry in (tmp_path / "talk.parts").iterdir()] == ["slides.pdf"]


def test_output_takes_one_session(brief):
    assert "--output" in render(brief, brief, "--output", brief / "x.mp4", code=1)
    assert not (brief / "x.mp4").exists()
    assert "no session directory" in render(brief / "meta.json", brief / "metrics.json", code=1)


def test_two_renders_of_one_video_do_not_meet(brief):
    first = start(brief, processes=1)
    end = time.monotonic() + 60
    while not list((brief / "video.parts").glob("draft_*")):  # the lock file exists before it is locked
        assert time.monotonic() < end and first.poll() is None
        time.sleep(0.01)
    first.send_signal(signal.SIGSTOP)
    try:
        assert "another process is drawing this video" in render(brief, *AT_RATE, code=1)
    finally:
        first.send_signal(signal.SIGCONT)
    assert first.wait(120) == 0 and (brief / "video.mp4").exists()


def test_simulate_from_log_is_resimulate(session, tmp_path):
    told = run("simulate", "--from-log", session, "--output", tmp_path / "again")
    assert "equal: " in told
    lines = [line for line in run("resimulate", session).splitlines() if "equal" in line]
    assert lines == [line for line in told.splitlines() if "equal" in line]
    assert (tmp_path / "again" / "session.rlog").exists()
    refused = subprocess.run([PROGRAMS / "simulate", "--from-log", session, "--seed", "3"], capture_output=True, text=True,
                             check=False)
    assert refused.returncode != 0 and "--from-log" in refused.stderr and "--seed" in refused.stderr


def change_a_joint(log, tick):
    """Replaces the gold arm's first joint in this tick's record by the next larger number. The log has plain records then."""
    whole = raven2_session.SessionLog(log)
    kinds = {entry["name"]: (entry["type"], entry["version"]) for entry in whole.header["records"]}
    ticks = whole.ticks.copy()
    ticks["model"]["arms"]["q"][ticks["model"]["tick"] == tick, 0, 0] = np.nextafter(whole.ticks["model"]["arms"]["q"][
        ticks["model"]["tick"] == tick, 0, 0], 10.0)
    # Inputs come before the tick that used them, as from a recorder that is late.
    order = [name for name in kinds if name not in ("tick", "haptic", "counts")] + ["tick", "haptic", "counts"]
    with open(log, "rb") as file:
        head = file.read(raven2_session.FRAME.size)
        head += file.read(raven2_session.FRAME.unpack(head)[3] + raven2_session.CRC.size)
    number = 1
    with open(log, "wb") as file:
        file.write(head)
        for name in order:
            for row in ticks if name == "tick" else whole._arrays[name]:
                framed = raven2_session.FRAME.pack(raven2_session.MAGIC, *kinds[name], row.nbytes, number) + row.tobytes()
                file.write(framed + raven2_session.CRC.pack(zlib.crc32(framed)))
                number += 1


def test_simulate_from_log_says_where_the_bits_part(brief):
    ticks = raven2_session.Session(brief).log.ticks["model"]["tick"]
    tick = int(ticks[len(ticks) // 2])
    change_a_joint(brief / "session.rlog", tick)
    told = run("simulate", "--from-log", brief, code=1)
    assert f"different: first at tick {tick}: model.arms[0].q[0]" in told, told
    assert "equal" not in told
