"""Sessions made by hand for the tests of the report: a log with an exercise in it, and the score.json of that log."""
import json
import pathlib
import shutil
import struct
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "scripts"))
sys.path.insert(0, str(ROOT / "test" / "python"))
sys.dont_write_bytecode = True
import test_raven2_session as log  # noqa: E402

KINDS = ["started", "began", "step_done", "held", "released", "dropped", "touch_began", "touch_ended", "broke_off",
         "mistake", "done", "failed"]
MISTAKES = ["wire_touch", "collision", "drop", "break_off", "out_of_order", "wrong_arm"]
EVENT = [log.field("kind", "u8", names=KINDS), log.field("mistake", "u8", names=MISTAKES), log.field("track", "u8"),
         log.field("step", "u8"), log.field("a", "u16"), log.field("b", "u16")]
EXERCISE = {"type": 13, "name": "exercise", "version": 1,
            "fields": [log.field("tick", "i64"), log.field("event", "struct", (), EVENT)]}
COPIES = ["urdf/raven2.urdf", "urdf/frs_trainer.urdf", "config/exercises/pick_hand_over_place.yaml",
          "config/scenes/frs_trainer.yaml", "config/faults/sudden_jump.yaml"]
HEADER = {"records": log.RECORDS + [EXERCISE], "exercise": "pick_hand_over_place", "drill": "sudden_jump",
          "trainee": "anna",
          "curriculum": "none", "motion": "expert", "step_names": [["lift", "hand_over", "place"]],
          "object_names": ["ring"],
          "body_names": ["link1_L", "wire_left", "ring"],
          "configuration": [{"path": f"configuration/{path}", "fnv1a": "0"} for path in COPIES]}
ORIGIN = "scripted expert of raven2_trainer, seeds 1001-1020, not surgeons"


COUNTS = log.record(6, struct.pack("<Q", 60))  # ends a session


def event(tick, kind, mistake=0, step=255, a=0xFFFF, b=0xFFFF):
    track = 0 if step != 255 else 255
    return log.record(13, struct.pack("<qBBBBHH", tick, KINDS.index(kind), mistake, track, step, a, b))


def data(**header):
    """Two seconds: begun at 0.1 s, lift done at 0.5, a wire touched at 0.8, a fault from 1.0 on, failed at 1.9."""
    ticks = log.session_bytes()[len(log.header_record()):-len(COUNTS)]
    events = (event(11, "started") + event(110, "began") + event(510, "step_done", step=0)
              + event(810, "mistake", MISTAKES.index("wire_touch"), a=0, b=1) + event(1910, "failed"))
    return log.header_record(**{**HEADER, **header}) + ticks + events + COUNTS


def metric(value, mean=None, deviation=0.0, limit=None, unit="s", better="lower", group="safety"):
    passed = None if limit is None or value is None else (value <= limit if better == "lower" else value >= limit)
    excess = None if passed is None else abs(value - limit) * (-1 if passed else 1)
    return {"value": value, "unit": unit, "group": group, "better": better, "scored": limit is not None, "bound": None,
            "mean": mean, "deviation": None if mean is None else deviation, "limit": limit, "excess": excess,
            "passed": passed}


def metrics():
    return {"time": metric(1.8, 2.0, 0.1, 2.5, group="efficiency"),
            "path": metric(812.345, 900.0, 20.0, 1125.0, "mm", group="efficiency"),
            "sparc": metric(-9.5, -9.0, 0.2, -11.25, "-", "higher", "control"),
            "wire_touches": metric(2, 0.0, 0.0, 0.5, "count"), "drops": metric(0, 0.0, 0.0, 0.5, "count"),
            "tremor": metric(22.5, unit="um", group="control"), "economy": metric(None, 0.9, 0.02, None, "-", "higher",
                                                                                  "efficiency")}


def hazard(verdict="right", response="pedal_up", after=400):
    answer = {"response": response, "after_ms": after} if response else None
    return {"scenario": "sudden_jump", "injection_tick": 1000, "force_after_ms": 10, "cue_after_ms": 12,
            "cue": "force", "reaction": answer,
            "deciding": answer, "verdict": verdict, "coincidences": [], "recovered": True, "duration_ms": 800,
            "excursion_mm": 10.25, "error_mm": 10.0, "peak_force_N": 2.0, "impulse_Ns": 0.6,
            "touches": {"wire": {"count": 1, "time_s": 0.1}}}


def score(passed=False, improve=("wire_touches", "path"), status="done", failure="none", values=None, hazards=None,
          **top):
    values, hazards = values or metrics(), [hazard()] if hazards is None else hazards
    attempt = {"number": 1, "status": status, "failure": failure, "first_tick": 100, "last_tick": 1900,
               "passed": passed,
               "composite": 0.75, "improve": list(improve), "not_judged": ["economy"], "metrics": values, "transits": 1,
               "transits_planned": 0, "steps_done": 1, "steps": [{"name": "lift", "at_s": 0.4}],
               "mistakes": {**dict.fromkeys(MISTAKES, 0), "wire_touch": 2}, "mistake_times": [], "hazards": hazards}
    return {"version": 1, "exercise": "pick_hand_over_place", "drill": "sudden_jump", "trainee": "anna",
            "curriculum": None,
            "motion": "expert", "motion_scale": 0.1, "force_limit_N": 3.0,
            "band": {"origin": ORIGIN, "sessions": 20, "least_spread": 0.25, "deviations": 1.0},
            "response_rule": {"right": ["pedal_up"], "wrong": ["push_on"], "within_s": 2.0}, "attempts": [attempt],
            "hazards": hazards, "hazards_beyond": 0, **top}


def make(folder, scored=None, start="2026-01-01T10:00:00Z", **header):
    """Makes a session directory. `scored` is the content of its score.json; without it, there is no score.json."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "session.rlog").write_bytes(data(**header))
    (folder / "meta.json").write_text(json.dumps({"start_time_utc": start}))
    for path in COPIES:
        target = folder / "configuration" / path
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(ROOT / path, target)
    if scored is not None:
        (folder / "score.json").write_text(json.dumps(scored))
    return folder
