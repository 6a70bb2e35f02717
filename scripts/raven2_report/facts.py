"""Facts of a session: read once, in the words and units of the report. Needs no drawing."""

import json
import os

import numpy as np
import yaml

from raven2_figures import runs
from raven2_report import metric_words
from raven2_report.text import is_number, words

FELT = 0.5  # [N] that a hand notices (haptics/perception.h)
SEEN = 3.0  # [mm] between the tips of model and robot that an eye notices (ibid.)
MAX_FILE = 2 * 1024 * 1024  # bytes, of a configuration's copy or of score.json
ARM_LINKS = ("link1", "link2", "link3", "instrument_shaft", "wrist", "grasper1", "grasper2")  # core/exercise.h
PHASES = {  # mode: words, family
    "waiting": ("Waiting for the robot", "held"),
    "pedal_up": ("Pedal up", "held"),
    "teleoperating": ("Operating", "work"),
    "planning": ("A path is planned", "held"),
    "tracking": ("The model shows a path", "alone"),
    "stopped": ("Stopped", "stopped"),
    "paused": ("Paused", "stopped"),
    "choosing": ("Choosing a goal", "alone"),
    "armed": ("Path waits for the pedal", "held"),
    "executing": ("Path is followed", "work"),
    "simulating": ("Simulation", "alone"),
    "simulation_held": ("Simulation, pedal up", "held"),
    "trial": ("Virtual trial", "alone"),
    "trial_held": ("Trial, pedal up", "held"),
    "trial_ready": ("Trial over", "held"),
    "returning": ("Model returns to the robot", "alone"),
    "replaying": ("Replay", "alone"),
    "camera_moving": ("Moving the camera", "camera"),
}


def load_small(path, parse):
    """A file's content, or None if it is not there, too large or not what it should be."""
    try:
        if os.path.getsize(path) > MAX_FILE:
            return None
        with open(path, encoding="utf-8") as file:
            return parse(file)
    except (OSError, ValueError, RecursionError, yaml.YAMLError):
        return None


def load_score(directory):
    """score.json, {} if it is missing, and whether it cannot be used."""
    path = os.path.join(directory, "score.json")
    if not os.path.isfile(path):
        return {}, False
    score = load_small(path, json.load)
    good = isinstance(score, dict) and score.get("version") == 1 and isinstance(score.get("attempts"), list)
    good = good and all(isinstance(a, dict) and isinstance(a.get("metrics"), dict) for a in score["attempts"])
    return (score, False) if good else ({}, True)


def chosen_attempt(attempts):
    """The newest that came to an end; else the newest."""
    ended = [a for a in attempts if a.get("status") in ("done", "failed")]
    return (ended or attempts or [None])[-1]


def arm_of_link(name):
    """0 gold, 1 green, -1 no moving link of an arm."""
    return {f"{stem}_{side}": arm for stem in ARM_LINKS for arm, side in enumerate("LR")}.get(name, -1)


class Configuration:
    """The copies of its configuration that a session keeps."""

    def __init__(self, session):
        self.root = os.path.realpath(session.directory)
        self.paths = [entry.get("path", "") for entry in session.log.header.get("configuration", [])]

    def file(self, *tail):
        """Path of the copy whose last parts are `tail`; None if the session's directory has no such file."""
        wanted = "/" + "/".join(tail)
        for path in self.paths:
            full = os.path.realpath(os.path.join(self.root, path))
            if ("/" + path).endswith(wanted) and full.startswith(self.root + os.sep) and os.path.isfile(full):
                return full
        return None

    def yaml(self, *tail):
        path = self.file(*tail)
        found = load_small(path, yaml.safe_load) if path else None
        return found if isinstance(found, dict) else {}


class Facts:
    def __init__(self, session, series):
        self.session, self.series = session, series
        self.log, self.metrics, self.meta, self.header = session.log, session.metrics, session.meta, session.log.header
        self.training = session.log.training
        self.configuration = Configuration(session)
        self.name = os.path.basename(os.path.abspath(session.directory))
        self.duration = float(self.metrics.get("duration_s", series.t[-1] + 0.001 if len(series.t) else 0.0))
        self.score, self.score_broken = load_score(session.directory)
        self.attempts = self.score.get("attempts", [])
        self.attempt = chosen_attempt(self.attempts)
        exercise = self.training["exercise"]
        self.exercise = self.configuration.yaml("config", "exercises", f"{exercise}.yaml") if exercise != "none" else {}
        self.scene = self.configuration.yaml("config", "scenes", f"{self.exercise.get('scene', '')}.yaml")
        self.phases = self._phases()
        self.events = self._events()
        self.steps = self._steps()
        self.faults = self.metrics.get("faults") or [
            {"name": name, "first_tick": round(a * 1000), "last_tick": round(b * 1000)}
            for a, b, name in series.fault_windows]
        self.hazards = self._hazards()
        self.deviations = self._deviations()
        self.unmerged = self._unmerged()

    def _unmerged(self):
        """Whether a real robot took part and nobody brought in the faults, if any, that it had by itself (merge_truth)."""
        robot = self.series.ticks["robot"]
        if "is_virtual" not in robot.dtype.names:
            return False
        is_real = bool(((robot["frame"] > 0) & (robot["is_virtual"] == 0)).any())
        return is_real and not os.path.isfile(os.path.join(self.session.directory, "usb_truth.json"))

    # ---- clocks ---------------------------------------------------------------------------------------------

    def session_time(self, tick):
        """[s] of the session at a tick of the model, whose clock goes on while the exercise is paused; None outside."""
        ticks = self.series.ticks["model"]["tick"]
        after = int(np.searchsorted(ticks, tick))
        return float(self.series.t[after]) if after < len(ticks) else None

    def index(self, seconds):
        """Of the session's tick at that time."""
        return int(np.clip(np.searchsorted(self.series.t, seconds), 0, max(len(self.series.t) - 1, 0)))

    def attempt_span(self):
        """[s] first and last of the chosen attempt; of the session without one."""
        first, last = (self.attempt or {}).get("first_tick"), (self.attempt or {}).get("last_tick")
        return (first / 1000.0 if is_number(first) else 0.0, last / 1000.0 if is_number(last) else self.duration)

    # ---- what happened --------------------------------------------------------------------------------------

    def _phases(self):
        """[(first s, last s, mode)] without gaps."""
        if not len(self.series.t):
            return []
        mode = self.series.ticks["model"]["mode"]
        names = self.log.names("tick", "model.mode")
        starts = np.concatenate(([0], np.flatnonzero(np.diff(mode)) + 1, [len(mode)]))
        t = np.append(self.series.t, self.series.t[-1] + 0.001)
        return [(float(t[a]), float(t[b]), names[mode[a]]) for a, b in zip(starts[:-1], starts[1:])]

    def _body(self, number):
        bodies = self.header.get("body_names", [])
        return bodies[number] if number < len(bodies) else ""

    def _step_name(self, track, step):
        names = self.header.get("step_names", [])
        return names[track][step] if track < len(names) and step < len(names[track]) else f"step {step + 1}"

    def _events(self):
        """Of the exercise, in order: at_s, kind, and what belongs to it."""
        records = self.log.exercise_events
        if records is None or not len(records) or not len(self.series.t):
            return []
        kinds = self.log.names("exercise", "event.kind")
        mistakes = self.log.names("exercise", "event.mistake")
        found = []
        for record in records:
            at = self.session_time(int(record["tick"]))
            event, kind = record["event"], kinds[record["event"]["kind"]]
            if at is None or kind in ("touch_began", "touch_ended"):
                continue
            found.append({"at_s": at, "kind": kind,
                          "mistake": mistakes[event["mistake"]] if kind == "mistake" else None,
                          "a": self._body(event["a"]), "b": self._body(event["b"]),
                          "step": self._step_name(event["track"], event["step"]) if kind == "step_done" else None})
        return found

    def _steps(self):
        """[{name, from_s, to_s}] of every attempt: a step begins where the one before it ended."""
        steps, last = [], None
        for event in self.events:
            if event["kind"] == "began":
                last = event["at_s"]
            elif event["kind"] == "step_done":
                steps.append({"name": event["step"], "from_s": event["at_s"] if last is None else last,
                              "to_s": event["at_s"]})
                last = event["at_s"]
            elif event["kind"] in ("done", "failed"):
                if last is not None and event["kind"] == "failed" and event["at_s"] > last:
                    steps.append({"name": "not finished", "from_s": last, "to_s": event["at_s"]})
                last = None
        if last is not None and self.duration > last + 0.05:
            steps.append({"name": "not finished", "from_s": last, "to_s": self.duration})
        return steps

    def mistakes(self):
        return [e for e in self.events if e["kind"] == "mistake"]

    # ---- hazards --------------------------------------------------------------------------------------------

    def scenario_text(self, name):
        """The library's texts about a scenario: title, expected, response; {} if the session has no copy of it."""
        found = self.configuration.yaml("config", "faults", f"{name}.yaml")
        return {key: str(found[key]) for key in ("title", "expected", "response") if found.get(key)}

    def _hazards(self):
        """One for each injection: the judged answer where there is a score, with the figures of metrics.json."""
        judged = [h for h in self.score.get("hazards", []) if isinstance(h, dict)]
        faults = list(self.faults)
        hazards = []
        for entry in judged:
            tick = entry.get("injection_tick")
            near = [f for f in faults if f["name"] == entry.get("scenario") and is_number(tick)
                    and f["first_tick"] - 1000 <= tick <= f["last_tick"]]
            fault = near[0] if near else {}
            if near:
                faults.remove(fault)
            hazards.append(self._hazard(entry.get("scenario", ""), tick, fault, entry))
        hazards += [self._hazard(f["name"], f["first_tick"], f, {}) for f in faults]
        return sorted(hazards, key=lambda h: h["at_s"])

    def _hazard(self, name, tick, fault, judged):
        last = fault.get("last_tick")
        return {"name": str(name), "at_s": tick / 1000.0 if is_number(tick) else 0.0,
                "end_s": (last + 1) / 1000.0 if is_number(last) else None, "fault": fault, "judged": judged}

    def _deviations(self):
        """Where model and robot parted, a force came to the hand, and no known fault was at work: [{at_s, end_s, arm, error_mm,
        force_N}]. Of a fault that was injected beyond the session's own means this is all that the session knows."""
        series = self.series
        error = np.nan_to_num(series.error_mm)
        found = []
        for first, last in self._partings(error.max(axis=1) >= series.tolerance_mm if len(error) else np.zeros(0, bool)):
            at, end = float(series.t[first]), float(series.t[last]) + 0.001
            felt = (series.force_t >= at) & (series.force_t <= end)
            force = float(np.nanmax(series.force[felt])) if felt.any() else 0.0
            if force >= FELT and not any(self._is_of(hazard, at) for hazard in self.hazards):
                arm = int(np.argmax(error[first:last + 1].max(axis=0)))
                found.append({"at_s": at, "end_s": end, "arm": ("gold", "green")[arm],
                              "error_mm": float(error[first:last + 1].max()), "force_N": force})
        return found

    @staticmethod
    def _partings(apart):
        """(first, last) of what is less than half a second apart."""
        found = []
        for first, last in runs(apart):
            if found and first - found[-1][1] < 500:
                found[-1][1] = last
            else:
                found.append([first, last])
        return found

    @staticmethod
    def _is_of(hazard, at):
        """Whether what begins then belongs to that hazard: to the end of its aftermath, and half a second."""
        over = hazard["fault"].get("end_tick")
        end = max(hazard["end_s"] or hazard["at_s"], over / 1000.0 if is_number(over) else 0.0)
        return hazard["at_s"] - 0.1 <= at <= end + 0.5

    def reaction(self, hazard):
        """(s after the injection, response) of the deliberate reaction, or (None, None)."""
        reaction = hazard["judged"].get("reaction")
        if not isinstance(reaction, dict) or not is_number(reaction.get("after_ms")):
            return None, None
        return reaction["after_ms"] / 1000.0, reaction.get("response")

    def answers(self, hazard):
        """[(s after the injection, response, decides)]: the reaction, and what decided where that came later."""
        found = []
        for key in ("reaction", "deciding"):
            answer = hazard["judged"].get(key)
            if isinstance(answer, dict) and is_number(answer.get("after_ms")):
                found.append((answer["after_ms"] / 1000.0, answer.get("response"), key == "deciding"))
        if len(found) == 2 and found[0][:2] == found[1][:2]:
            found = found[1:]
        return found

    def worst_gap(self, hazard):
        """The arm whose robot went farthest from the model while both followed the hand, and the direction of that."""
        first = self.index(hazard["at_s"])
        last = self.index((hazard["end_s"] or hazard["at_s"]) + 0.2)
        distance = np.nan_to_num(self.series.error_mm[first:last + 1])
        if not distance.size or distance.max() <= 0.0:
            return 0, np.array([1.0, 0.0, 0.0])
        i, arm = np.unravel_index(int(np.argmax(distance)), distance.shape)
        gap = self.series.p_robot[first + i, arm] - self.series.p_model[first + i, arm]
        return int(arm), gap / np.linalg.norm(gap)

    def arm_of(self, event):
        """0 gold, 1 green: whose link a mistake is about, else the arm that was faster then."""
        for body in (event["a"], event["b"]):
            if arm_of_link(body) >= 0:
                return arm_of_link(body)
        i = self.index(event["at_s"])
        way = self.series.p_model[i] - self.series.p_model[max(i - 50, 0)]
        return int(np.argmax(np.nan_to_num(np.linalg.norm(way, axis=1))))

    def emergency_stop(self):
        """[s] at which the robot first fell into E-STOP after having left it; None if it did not."""
        level = self.series.runlevel
        falls = [i for i in np.flatnonzero(level == 0) if i > 0 and level[i - 1] > 0]
        return float(self.series.t[falls[0]]) if falls else None

    # ---- pictures of the video ------------------------------------------------------------------------------

    def moments(self, most=12):
        """[{at_s, caption}] worth a look, in order; steps give way to mistakes and hazards."""
        wanted = [(0, 0.0, "Start"), (0, max(0.0, self.duration - 0.1), "End")]
        for number, hazard in enumerate(self.hazards, 1):
            wanted.append((1, self._worst(hazard), f"Hazard {number}: {words(hazard['name'])}, robot farthest off"))
            wanted += [(3, hazard["at_s"] + after, f"Hazard {number}: the surgeon {metric_words.response(response)}")
                       for after, response, _ in self.answers(hazard)]
        wanted += [(1, e["at_s"], self.mistake_text(e)) for e in self.mistakes()]
        wanted += [(2, e["at_s"], f"Step done: {words(e['step'])}") for e in self.events if e["kind"] == "step_done"]
        wanted += [(1, e["at_s"], "Attempt failed") for e in self.events if e["kind"] == "failed"]
        if self.series.tracking.any():
            wanted.append((2, float(self.series.t[self.series.tracking.argmax()]), "Plan starts"))
        kept = sorted(wanted, key=lambda moment: moment[0])[:most]
        return [{"at_s": t, "caption": caption} for _, t, caption in sorted(kept, key=lambda moment: moment[1])]

    @staticmethod
    def mistake_text(event):
        what = metric_words.MISTAKES.get(event["mistake"], words(event["mistake"]))
        parts = [words(part) for part in (event["a"], event["b"]) if part]
        return f"{what}: {' and '.join(parts)}" if parts else what

    def _worst(self, hazard):
        """[s] of the largest tip distance in a fault and the 200 ms behind it."""
        first = hazard["at_s"]
        last = (hazard["end_s"] or first) + 0.2
        inside = np.flatnonzero((self.series.t >= first) & (self.series.t <= last))
        errors = np.nan_to_num(self.series.error_mm[inside]).max(axis=1) if len(inside) else []
        return float(self.series.t[inside[int(np.argmax(errors))]]) if len(inside) else first
