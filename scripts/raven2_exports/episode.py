"""A session as frames for learning: state, action, and the truth about its hazards, at a fixed rate.

Frame k shows the newest tick at time k / fps from the first pedal-down, as frame k of render_session's video does. Its action
is the surgeon's motion from there to the next frame, in the form of Simulation.step (doc/python.md). World axes W: x away
from the surgeon, y left, z up, origin in the middle of the base plate.
"""

import os

import numpy as np
import yaml
from raven2_report import facts, scene

import raven2_session

ARMS = ("gold", "green")
JOINTS = ("shoulder", "elbow", "insertion", "roll", "wrist", "grasper1", "grasper2")
AXES = ("x", "y", "z")
W_OF_I = np.array([1.0, -1.0, -1.0])  # ITP axes have y right and z down
GRASP = (5, 6)  # of the seven joints; their sum is the opening of the jaws
CLIENTS_PEDAL = 2  # of a CRTK client: its motion comes from no hand
PHASES = ("nominal", "failure", "recovery")
SPLITS = PHASES


def _named(*parts):
    return ["_".join(part) for part in parts]


JOINT_NAMES = _named(*((arm, joint) for arm in ARMS for joint in JOINTS))
TIP_NAMES = _named(*((arm, axis) for arm in ARMS for axis in AXES))
ACTION_NAMES = _named(*((arm, name) for arm in ARMS for name in
                        ("move_x", "move_y", "move_z", "turn_x", "turn_y", "turn_z", "jaw")))
OBJECT_NAMES = _named(*((f"object{i}", name) for i in range(12) for name in ("x", "y", "z", "qx", "qy", "qz", "qw")))

# Column: names of its elements (None for strings), unit and meaning.
COLUMNS = {
    "observation.state": (JOINT_NAMES + TIP_NAMES, "rad, m", "robot: joint positions, then tool tips in W"),
    "observation.model_state": (JOINT_NAMES + TIP_NAMES, "rad, m", "the same of the nominal model, what the surgeon sees"),
    "observation.objects": (OBJECT_NAMES, "m, -", "poses of the scene's bodies in W, in the order of object_names; zeros beyond them"),
    "observation.force": (TIP_NAMES, "N", "force on the surgeon's hand, in W"),
    "observation.pedal": (["pedal"], "-", "1 while the pedal is down"),
    "action": (ACTION_NAMES, "m, rad", "motion of the tool tip and rotation vector in W until the next frame; opening of the jaws"),
    "truth.hazard": (None, "-", "the hazard that acts in this frame, or none"),
    "truth.phase": (None, "-", "nominal; failure: a hazard acts; recovery: it has ended and its effects have not"),
    "truth.error": ([f"{arm}" for arm in ARMS], "m", "distance of the tips of model and robot; 0 while they have no common pose"),
    "truth.cue": ([f"{arm}" for arm in ARMS], "N", "size of the force on the surgeon's hand"),
    "truth.response": (None, "-", "how the surgeon has responded to the hazard so far: none, pedal_up, or the response in score.json"),
}


class Episode:
    """A session's frames. `columns`: name to array (frames, n) of float32, or to a list of strings."""

    def __init__(self, directory, fps):
        session = raven2_session.Session(directory)
        log = session.log
        begun = int(np.argmax(np.append(log.ticks["model"]["session_tick"] >= 0, True)))
        if begun == len(log.ticks):
            raise raven2_session.SessionError(f"{directory}: the pedal was never pressed, there is nothing to export")
        if "faults" not in session.metrics:
            raise raven2_session.SessionError(f"{directory}: without metrics.json its hazards are unknown; recover_session writes it")
        bases = scene.arm_bases(facts.Configuration(session).file("urdf", "raven2.urdf"))
        if bases is None:
            raise raven2_session.SessionError(f"{directory}: no readable copy of raven2.urdf, so the places of the arms are unknown")
        self.directory, self.fps, self._session, self._bases = directory, fps, session, bases
        self._ticks = log.ticks[begun:]
        self._times = self._ticks["model"]["session_tick"]
        self._frames = self._frame_ticks()
        self.length = len(self._frames)
        if self.length == 0:
            raise raven2_session.SessionError(f"{directory}: is shorter than a frame at {fps} Hz")
        self.task = self._task()
        self.scenarios = log.header["scenarios"]
        self.objects = log.header.get("object_names", [])
        self._faults = session.metrics.get("faults", [])
        self.columns = {**self._observations(), "action": self._actions(), **self._truth()}
        self.split = self._split()
        self.summary = {"session": os.path.basename(os.path.abspath(directory)), "seed": log.header["seed"], "exercise": log.training["exercise"],
                        "hazards": sorted({fault["name"] for fault in self._faults}), "split": self.split, "success": self._is_done()}

    def _frame_ticks(self):
        """Index of the newest tick of each frame; before the first tick of the log, that one."""
        count = ((int(self._times[-1]) + 1) * self.fps + 500) // 1000  # as the renderer counts them (frame_timeline.cpp)
        wanted = np.floor(np.arange(count) * 1000.0 / self.fps + 1e-6)
        return np.maximum(np.searchsorted(self._times, wanted, side="right") - 1, 0)

    def _task(self):
        name = self._session.log.training["exercise"]
        if name in ("none", ""):
            return "teleoperation"
        path = facts.Configuration(self._session).file("exercises", f"{name}.yaml")
        loaded = facts.load_small(path, yaml.safe_load) if path else None
        return (loaded or {}).get("title", name)

    def _in_world(self, vectors, arm, is_place):
        R, p = self._bases[arm]
        return vectors @ R.T + (p if is_place else 0.0)

    def _tips(self, arms):
        return np.concatenate([self._in_world(arms["p_BT"][:, arm], arm, True) for arm in (0, 1)], axis=1)

    def _observations(self):
        shown = self._ticks[self._frames]
        model, robot = shown["model"], shown["robot"]
        has_robot = (robot["frame"] > 0)[:, None]

        def state(arms):
            return np.concatenate([arms["q"].reshape(self.length, 14), self._tips(arms)], axis=1)

        nominal = state(model["arms"])
        bodies = np.concatenate([model["bodies"]["p"], model["bodies"]["q"]], axis=2).reshape(self.length, -1)
        self._force = self._forces(model["tick"])
        force_W = np.concatenate([self._in_world(self._force[:, arm], arm, False) for arm in (0, 1)], axis=1)
        return {"observation.state": np.where(has_robot, state(robot["arms"]), nominal), "observation.model_state": nominal,
                "observation.objects": bodies, "observation.force": force_W, "observation.pedal": (model["pedal"] != 0)[:, None]}

    def _forces(self, ticks):
        """(frames, 2, 3) [N] in each arm's base frame: the newest force of each tick."""
        haptic = self._session.log.haptic["haptic"]
        if len(haptic) == 0:
            return np.zeros((self.length, 2, 3))
        newest = np.searchsorted(haptic["tick"], ticks, side="right") - 1
        return np.where((newest >= 0)[:, None, None], haptic["force_B"][np.maximum(newest, 0)], 0.0)

    def _actions(self):
        model = self._ticks["model"]
        ends = np.append(self._frames[1:], len(self._ticks) - 1)
        move = (model["master_I"][ends] - model["master_I"][self._frames]) * W_OF_I
        turn = self._turns(model["tick"][self._frames], model["tick"][ends])
        jaw = model["arms"]["q_d"][ends][:, :, GRASP].sum(axis=2)
        return np.concatenate([move, turn, jaw[:, :, None]], axis=2).reshape(self.length, 14)

    def _turns(self, first, last):
        """(frames, 2, 3) rotation vectors in W of the commands after tick `first` up to tick `last`."""
        commands = of_hands(self._session.log.commands)
        turns = np.zeros((self.length, 2, 3))
        at, end = np.searchsorted(commands["tick"], first, side="right"), np.searchsorted(commands["tick"], last, side="right")
        q = commands["command"]["dq_I"]
        for arm in (0, 1):
            for i in range(self.length):
                turns[i, arm] = _rotation_vector(q[at[i]:end[i], arm]) * W_OF_I
        return turns

    def _truth(self):
        shown = self._ticks[self._frames]
        model, robot = shown["model"], shown["robot"]
        is_common = (model["linked"] != 0) & (model["robot_fresh"] != 0)
        error = np.linalg.norm(model["arms"]["p_BT"] - robot["arms"]["p_BT"], axis=2)
        phase, hazard, response = (["nominal"] * self.length, ["none"] * self.length, ["none"] * self.length)
        at = self._times[self._frames]
        for fault in self._faults:
            end = fault["end_tick"] if fault["end_tick"] is not None else int(at[-1]) + 1
            answered = self._response(fault, end)
            for i in np.flatnonzero((at >= fault["first_tick"]) & (at <= end)):
                acts = at[i] <= fault["last_tick"]
                phase[i] = "failure" if acts else "recovery"
                hazard[i] = fault["name"] if acts else hazard[i]
                if answered and at[i] >= answered[0]:
                    response[i] = answered[1]
        return {"truth.hazard": hazard, "truth.phase": phase, "truth.error": np.where(is_common[:, None], error, 0.0),
                "truth.cue": np.linalg.norm(self._force, axis=2), "truth.response": response}

    def _response(self, fault, end):
        """(session tick, response) to a fault, or None: the score's; where it does not have the fault, the first pedal-up."""
        score, _ = facts.load_score(self.directory)
        for judged in reversed(score.get("hazards", [])):  # the newest: one before may have begun within the same second
            injected, reaction = judged.get("injection_tick"), judged.get("reaction") or {}
            is_it = judged.get("scenario") == fault["name"] and injected is not None
            if is_it and fault["first_tick"] - 1000 <= injected <= fault["last_tick"]:
                has_one = reaction.get("after_ms") is not None
                return (injected + reaction["after_ms"], reaction["response"]) if has_one else None
        inside = (self._times >= fault["first_tick"]) & (self._times <= end)
        released = np.flatnonzero(inside & (self._ticks["model"]["pedal"] == 0))
        return (int(self._times[released[0]]), "pedal_up") if len(released) else None

    def _split(self):
        """nominal: no hazard acted; recovery: the work went on after each, and the exercise, if any, was done; else failure."""
        if not self._faults:
            return "nominal"
        is_over = all(fault["end_tick"] is not None for fault in self._faults)
        return "recovery" if is_over and (not self._attempts() or self._is_done()) else "failure"

    def _attempts(self):
        return (self._session.metrics.get("exercise") or {}).get("attempts", [])

    def _is_done(self):
        """Whether the last attempt of an exercise was done."""
        return bool(self._attempts()) and self._attempts()[-1]["status"] == "done"


def of_hands(commands):
    """A log's commands without those of CRTK clients."""
    has_pedal = "pedal" in commands["command"].dtype.names
    return commands[commands["command"]["pedal"] != CLIENTS_PEDAL] if has_pedal else commands


def _rotation_vector(quaternions):
    """Of the product of these x y z w, the first applied first."""
    x, y, z, w = 0.0, 0.0, 0.0, 1.0
    for a, b, c, d in quaternions[quaternions[:, 3] != 1.0]:
        x, y, z, w = d * x + a * w + b * z - c * y, d * y + b * w + c * x - a * z, d * z + c * w + a * y - b * x, d * w - a * x - b * y - c * z
    axis = np.array([x, y, z]) * (1.0 if w >= 0 else -1.0)
    sine = np.linalg.norm(axis)
    return axis * (2.0 * np.arctan2(sine, abs(w)) / sine) if sine > 1e-12 else 2.0 * axis
