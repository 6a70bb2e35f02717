"""Tests what the station reads from recorded sessions: its lists, verdicts, histories and the class."""

import csv
import fcntl
import json
import os
import pathlib
import sys
import threading
import zlib

import pytest

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
import raven2_session  # noqa: E402
from raven2_station import curriculum, records  # noqa: E402


@pytest.fixture
def folder(tmp_path):
    for name, passed in (("2026-01-01T10-00-00Z_ann", True), ("2026-01-02T10-00-00Z_ann", False)):
        directory = tmp_path / name
        directory.mkdir()
        (directory / "session.rlog").write_bytes(b"x")
        report = {"session": {"trainee": "ann", "exercise": "peg_transfer", "drill": "none", "duration_s": 12.5},
                  "verdict": {"headline": "Passed" if passed else "Not passed: time", "passed": passed, "reasons": []},
                  "improve": [{"what": "time", "how": "be faster", "metric": "time"}] * 5, "summary": ""}
        (directory / "report.json").write_text(json.dumps(report))
        (directory / "report.html").write_text("<p>report</p>")
    entries = [{"directory": f"s{i}", "start_time_utc": f"2026-01-0{i + 1}", "trainee": trainee, "exercise": exercise, "drill": "",
                "attempts": [{"status": "done", "passed": passed, "metrics": {"time": 10.0 + i}}]}
               for i, (trainee, exercise, passed) in enumerate([("ann", "peg_transfer", True), ("ann", "peg_transfer", True),
                                                                ("bea", "peg_transfer", False), ("ann", "camera_clutch", True)])]
    (tmp_path / "index.json").write_text(json.dumps({"version": 1, "sessions": entries}))
    (tmp_path / "other").mkdir()
    return tmp_path


def test_sessions_are_listed_newest_first(folder):
    found = records.Records(folder).list()
    assert [s["name"] for s in found] == ["2026-01-02T10-00-00Z_ann", "2026-01-01T10-00-00Z_ann"]
    assert found[0]["passed"] is False and found[0]["report"] and not found[0]["video"]
    verdict = records.Records(folder).verdict(found[0]["name"])
    assert verdict["headline"] == "Not passed: time" and len(verdict["improve"]) == 3


def test_a_session_whose_report_is_missing_is_listed_from_its_other_files(folder, monkeypatch):
    name = "2026-01-01T10-00-00Z_ann"
    (folder / name / "report.json").unlink()
    header = {"trainee": "ann", "exercise": "peg_transfer", "drill": "sudden_jump"}
    monkeypatch.setattr(records, "_header_of_log", lambda _: header)
    (folder / name / "metrics.json").write_text(json.dumps({"duration_s": 12.5, "faults": [{"name": "fk_pos"}, {"name": "fk_pos"}]}))
    (folder / name / "score.json").write_text(json.dumps({
        "attempts": [{"status": "failed", "passed": False}, {"status": "done", "passed": True}, {"status": "running", "passed": None}]}))
    keys = ("trainee", "exercise", "drill", "hazards", "passed", "duration")
    found = records.Records(folder).summary(name)
    assert [found[key] for key in keys] == ["ann", "peg_transfer", "sudden_jump", ["fk_pos"], True, 12.5]
    header = {"trainee": "", "exercise": "none", "drill": "none"}  # a free session has no score
    (folder / name / "score.json").unlink()
    found = records.Records(folder).summary(name)
    assert [found[key] for key in keys] == ["", "none", "none", ["fk_pos"], None, 12.5]
    for broken in ("[]", "{", '{"attempts": 1, "duration_s": "long", "faults": 3}', '{"attempts": [3], "faults": [{"name": 3}]}'):
        for file in ("score.json", "metrics.json"):
            (folder / name / file).write_text(broken)
        found = records.Records(folder).summary(name)
        assert (found["hazards"], found["passed"], found["duration"]) == ([], None, None), broken
    monkeypatch.undo()
    found = records.Records(folder).summary(name)  # the log is one byte
    assert (found["trainee"], found["exercise"], found["drill"]) == ("", "", "")


@pytest.mark.parametrize("name", ["..", ".", "", "../x", "a/b", "/etc", "other", "x" * 200, None, 3, ".hidden", "a\0b", "a b",
                                  "2026-01-01T10-00-00Z_ann\n"])
def test_names_that_are_no_sessions_are_refused(folder, name):
    store = records.Records(folder)
    for call in (store.directory, store.summary, store.verdict, store.delete, lambda n: store.file(n, "report.html")):
        with pytest.raises(KeyError):
            call(name)


def test_only_a_sessions_own_files_are_served(folder):
    store = records.Records(folder)
    name = "2026-01-01T10-00-00Z_ann"
    assert store.file(name, "report.html")[0].name == "report.html"
    os.symlink("/etc/passwd", folder / name / "video.mp4")
    for which in ("video.mp4", "configuration", "../index.json", "score.json"):
        with pytest.raises(KeyError):
            store.file(name, which)
    os.symlink(folder / name, folder / "link")
    with pytest.raises(KeyError):
        store.directory("link")


STAGES = {"stages": [{"exercise": "peg_transfer", "drill": "none", "passes": 2, "extra": 0},
                     {"exercise": "camera_clutch", "drill": "none", "passes": 2, "extra": 1},
                     {"exercise": "peg_transfer", "drill": "sudden_jump", "passes": 2, "extra": 0}]}


def test_the_class_has_a_row_a_trainee_and_a_cell_a_stage(folder):
    store = records.Records(folder)
    ann, bea = store.the_class(STAGES)
    assert (ann["trainee"], ann["sessions"], ann["current"]) == ("ann", 3, 1)
    assert [c["done"] for c in ann["stages"]] == [True, False, False]
    assert [c["attempts"] for c in bea["stages"]] == [1, 0, 0] and bea["stages"][0]["in_a_row"] == 0
    lines = store.class_csv(STAGES).splitlines()
    assert len(lines) == 3 and lines[1].startswith("ann,3,2,2,0,yes,1,1,0,no,0,0,0,no,")
    assert "peg transfer with sudden jump done" in lines[0]
    assert lines[0].endswith(",demonstrated sessions") and lines[1].endswith(f",{ann['demonstrations']}")
    of_ann = next(csv.DictReader(lines))
    first = next(title for title in of_ann if title.endswith(" attempts")).removesuffix(" attempts")
    assert [of_ann[f"{first} {what}"] for what in ("attempts", "passes in a row", "more passes")] == ["2", "2", "0"]
    assert of_ann["last session (UTC)"] == "2026-01-04"


def test_attempts_count_for_the_stage_under_way_alone():
    def after(text):  # p, c: passed peg, camera; P, C: not passed; j: a passed drill; ?: not judged
        kinds = {"p": ("peg_transfer", ""), "c": ("camera_clutch", ""), "j": ("peg_transfer", "sudden_jump"), "?": ("peg_transfer", "")}
        attempts = [{"exercise": kinds[k.lower()][0], "drill": kinds[k.lower()][1], "passed": None if k == "?" else k.islower()} for k in text]
        stages, current = curriculum.follow(STAGES, attempts)
        return current, [(s.in_a_row, s.more, s.attempts) for s in stages]
    assert after("") == (0, [(0, 0, 0)] * 3)
    assert after("ccc") == (0, [(0, 0, 0)] * 3), "attempts before their stage do not count"
    assert after("pPp") == (0, [(1, 0, 3), (0, 0, 0), (0, 0, 0)]), "a failure restarts the row"
    assert after("p?p") == (1, [(2, 0, 2), (0, 0, 0), (0, 0, 0)])
    assert after("ppccCc") == (2, [(2, 0, 2), (2, 1, 4), (0, 0, 0)]), "a failure keeps the passes after the row"
    assert after("ppcccjj") == (3, [(2, 0, 2), (2, 1, 3), (2, 0, 2)])


@pytest.mark.parametrize("text", ["", "[]", "{", "null", '{"sessions": 3}', '{"sessions": [1, {"trainee": 2}, {"trainee": "x"}]}'])
def test_a_spoilt_index_is_an_empty_or_shorter_class(tmp_path, text):
    (tmp_path / "index.json").write_text(text)
    assert len(records.Records(tmp_path).the_class(STAGES)) <= 1


def test_an_index_with_foreign_entries_is_read_without_them(folder):
    entries = json.loads((folder / "index.json").read_text())["sessions"]
    for change in ({"start_time_utc": None}, {"directory": None}, {"directory": ["x"]}, {"start_time_utc": 3}):
        entries.append({**entries[0], "trainee": "cay", **change})
    entries.append({**entries[0], "trainee": "@SUM(1)"})
    (folder / "index.json").write_text(json.dumps({"version": 1, "sessions": entries}))
    store = records.Records(folder)
    assert store.trainees() == ["@SUM(1)", "ann", "bea"]
    assert store.class_csv(STAGES).splitlines()[1].startswith("'@SUM(1),1,")


def test_older_sessions_come_behind_the_newest(folder):
    store = records.Records(folder)
    assert [s["name"][:10] for s in store.list(skip=1)] == ["2026-01-01"] and store.list(skip=2) == []
    assert [s["name"][:10] for s in store.list(most=1)] == ["2026-01-02"]


def test_the_history_has_score_time_and_response(folder):
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    (folder / "s1" / "score.json").write_text(json.dumps({"attempts": [{"composite": 0.75}]}))
    index = json.loads((folder / "index.json").read_text())
    index["sessions"][1]["attempts"][0]["metrics"]["hazard_response"] = 1.5  # kHazardMetric of training/score.h
    (folder / "index.json").write_text(json.dumps(index))
    history = records.Records(folder).history("ann")
    assert [(a["session"], a["score"], a["time"], a["response"]) for a in history] == [
        ("s0", None, 10.0, None), ("s1", 0.75, 11.0, 1.5), ("s3", None, 13.0, None)]
    for spoilt in ('{"attempts": [{"composite": "x"}, 3]}', '{"attempts": 3, "hazards": 3}', '{"attempts": {"a": 1}, "hazards": [3]}'):
        (folder / "s1" / "score.json").write_text(spoilt)
        assert [a["score"] for a in records.Records(folder).history("ann")] == [None] * 3


def test_sessions_say_which_hazards_acted_and_who_moved_the_arms(folder):
    name = "2026-01-01T10-00-00Z_ann"
    report = json.loads((folder / name / "report.json").read_text())
    report["hazards"] = [{"scenario": "sudden_jump"}, {"scenario": "camera_drift"}, {"scenario": "sudden_jump"}, 3]
    (folder / name / "report.json").write_text(json.dumps(report))
    (folder / name / "meta.json").write_text('{"motion": "clumsy:dropper"}')
    (folder / "2026-01-02T10-00-00Z_ann" / "report.json").write_text('{"hazards": 3}')
    after, before = records.Records(folder).list()
    assert before["hazards"] == ["sudden_jump", "camera_drift"] and before["driver"] == "clumsy:dropper"
    assert after["hazards"] == [] and after["driver"] == ""


def test_a_history_has_the_hazards_of_each_attempt_and_the_class_its_demonstrations(folder):
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    (folder / "s1" / "meta.json").write_text('{"motion": "expert"}')
    (folder / "s1" / "score.json").write_text(json.dumps({
        "attempts": [{"first_tick": 0, "last_tick": 4999}, {"first_tick": 5000, "last_tick": None}],
        "hazards": [{"scenario": "sudden_jump", "injection_tick": 4999}, {"scenario": "camera_drift", "injection_tick": 9000}, {}]}))
    index = json.loads((folder / "index.json").read_text())
    index["sessions"][1]["attempts"] *= 2
    (folder / "index.json").write_text(json.dumps(index))
    store = records.Records(folder)
    of_s1 = [a for a in store.history("ann") if a["session"] == "s1"]
    assert [(a["hazards"], a["driver"]) for a in of_s1] == [(["sudden_jump"], "expert"), (["camera_drift"], "expert")]
    assert [r["demonstrations"] for r in store.the_class(STAGES)] == [1, 0]


def test_deleting_takes_the_whole_directory_and_nothing_else(folder):
    store = records.Records(folder)
    store.delete("2026-01-01T10-00-00Z_ann")
    assert [s["name"] for s in store.list()] == ["2026-01-02T10-00-00Z_ann"] and (folder / "other").exists()


def test_a_deleted_session_counts_no_longer(folder):
    """The index is locked and exchanged as score_session does it."""
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    store = records.Records(folder)
    before = json.loads((folder / "index.json").read_text())
    with open(folder / "index.json.lock", "w", encoding="utf-8") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        deleting = threading.Thread(target=store.delete, args=("s1",))
        deleting.start()
        deleting.join(0.2)
        assert deleting.is_alive() and json.loads((folder / "index.json").read_text()) == before, "another program writes the index"
    deleting.join(10)
    assert [a["session"] for a in store.history("ann")] == ["s0", "s3"] and store.the_class(STAGES)[0]["sessions"] == 2
    assert json.loads((folder / "index.json").read_text()) == {"version": 1, "sessions": [before["sessions"][i] for i in (0, 2, 3)]}
    inode = (folder / "index.json").stat().st_ino
    store.delete("2026-01-01T10-00-00Z_ann")  # a guest's
    assert (folder / "index.json").stat().st_ino == inode and not (folder / "index.json.part").exists()


def test_an_index_that_cannot_be_written_stays_as_it_was(folder):
    (folder / "s1").mkdir()
    (folder / "s1" / "session.rlog").write_bytes(b"x")
    (folder / "index.json.part").symlink_to("/dev/full")
    before = (folder / "index.json").read_bytes()
    with pytest.raises(OSError):
        records.Records(folder).delete("s1")
    assert (folder / "index.json").read_bytes() == before


def log_of(exercise):
    header = json.dumps({"format": raven2_session.FORMAT_NAME, "format_version": 1, "exercise": exercise}).encode()
    record = raven2_session.FRAME.pack(raven2_session.MAGIC, 0, 1, len(header), 0) + header
    return record + raven2_session.CRC.pack(zlib.crc32(record))


def test_the_exercise_of_a_session_without_a_report_is_that_of_its_log(folder):
    store, name = records.Records(folder), "2026-01-01T10-00-00Z_ann"
    assert store.exercise(name) == "peg_transfer"
    (folder / name / "report.json").unlink()
    assert store.exercise(name) == "none", "the log has no header"
    (folder / name / "session.rlog").write_bytes(log_of("camera_clutch"))
    assert store.exercise(name) == "camera_clutch"


def test_a_verdict_says_whether_there_is_a_video(folder):
    store, name = records.Records(folder), "2026-01-01T10-00-00Z_ann"
    assert store.verdict(name)["video"] is False
    (folder / name / "video.mp4").touch()
    assert store.verdict(name)["video"] is True
