"""Effects of a hazard in a session: how often it acted, when the tips parted, when the hand was pushed, how it ended.

Ticks are session ticks of 1 ms. Distances are those that the haptic loop itself compared (`error` of the haptic
records): the metrics compare the model of a tick with the robot as the physics tick saw it, in lockstep one cycle
older.
"""

import numpy as np

LEVELS = {0: "E-STOP", 1: "INIT", 2: "PEDAL_UP", 3: "PEDAL_DN"}
PROMISE = 1  # [ticks] from the tips parting by more than the threshold to the force, at most


def times(faults):
    """How often the scenario acted: its rows that begin in one tick are one time. `faults`: faults.json."""
    return len({(i["inject"]["tick"], i["inject"]["cycle"]) for i in faults["injections"]})


def stop_tick(ticks):
    """Session tick by which the robot's own check had stopped it, -1 before the session's first; None if it did not."""
    stopped = np.flatnonzero((ticks["robot"]["frame"] > 0) & (ticks["robot"]["soft_estopped"] != 0))
    return int(ticks["model"]["session_tick"][stopped[0]]) if len(stopped) else None


def ending(session, started):
    """State of the robot at the end, in words."""
    ticks = session.log.ticks
    if not len(ticks) or not ticks["robot"]["frame"][-1]:
        return "no frame"
    text = LEVELS.get(int(ticks["robot"]["runlevel"][-1]), "?")
    if text == "E-STOP" and stop_tick(ticks) is not None:
        text += ", by its own check"
    if not ticks["model"]["robot_fresh"][-1]:
        text += ", silent"
    return text if started else f"never started: {text}"


def follows(log):
    """For each haptic record: whether model and robot move from a common pose and the robot's state is fresh, so that a
    force has to act beyond the threshold. As the physics loop says: nothing that the haptic loop decides enters."""
    model, tick = log.ticks["model"], log.haptic["haptic"]["tick"]
    if not len(model):
        return np.zeros(len(tick), bool)
    at = np.minimum(np.searchsorted(model["tick"], tick), len(model) - 1)
    return (model["tick"][at] == tick) & (model["linked"][at] != 0) & (model["robot_fresh"][at] != 0)


class Crossing:
    """The tips of an arm part by more than the threshold at tick `beyond`; at `force`, or never (None), it pushes."""

    def __init__(self, beyond, force):
        self.beyond, self.force = beyond, force

    @property
    def delay(self):
        return None if self.force is None else self.force - self.beyond


class Event:
    """One activation of the scenario and its aftermath, as metrics.json bounds them."""

    def __init__(self, name, begin, crossings, parted, force):
        self.name = name
        self.begin = begin  # [tick] first that the haptic loop could feel it; 0 if it acts since before
        self.crossings = crossings
        self.parted = parted  # [m] largest distance while model and robot move from a common pose
        self.force = force  # [N] largest

    @property
    def onset(self):
        """[ticks] from its beginning to the first crossing; None without one."""
        return self.crossings[0].beyond - self.begin if self.crossings else None


class Cue:
    """The force cue of a whole session."""

    def __init__(self, session):
        log = session.log
        model, haptic = log.ticks["model"], log.haptic["haptic"]
        in_session = model["session_tick"] >= 0
        first = int(model["tick"][in_session][0]) if in_session.any() else np.iinfo(np.int64).max
        self._tick = haptic["tick"] - first
        self._cycle = haptic["robot_cycle"]
        self._error = np.where((follows(log) & (self._tick >= 0))[:, None], haptic["error"], 0.0)
        self._force = np.linalg.norm(haptic["force_B"], axis=2)
        self._beyond = self._error > log.header["tolerance"]
        self._session = session
        self.crossings = sorted((c for arm in (0, 1) for c in self._of(arm)), key=lambda c: c.beyond)

    def broken(self):
        """Crossings that the promise does not hold for."""
        return [c for c in self.crossings if c.delay is None or c.delay > PROMISE]

    def events(self):
        return [self._event(entry) for entry in self._session.metrics["faults"]]

    def _of(self, arm):
        edges = np.diff(np.concatenate(([0], self._beyond[:, arm].astype(np.int8), [0])))
        for begin, end in zip(np.flatnonzero(edges > 0), np.flatnonzero(edges < 0)):
            pushed = np.flatnonzero(self._force[begin:end, arm] > 0.0)
            yield Crossing(int(self._tick[begin]), int(self._tick[begin + pushed[0]]) if len(pushed) else None)

    def _begin(self, entry):
        """A fault in the robot is felt in the tick that compares its first cycle, before the physics loop reports it."""
        hosts = {i["host"] for i in self._session.faults["injections"] if i["name"] == entry["name"]}
        first = np.flatnonzero(self._cycle >= entry["first_cycle"])
        if "robot" not in hosts or not len(first):
            return entry["first_tick"]
        return max(0, min(entry["first_tick"], int(self._tick[first[0]])))

    def _event(self, entry):
        begin, end = self._begin(entry), entry["end_tick"]
        within = (self._tick >= begin) & (self._tick <= (np.inf if end is None else end))
        crossings = [c for c in self.crossings if begin <= c.beyond and (end is None or c.beyond <= end)]
        return Event(entry["name"], begin, crossings, float(self._error[within].max(initial=0.0)),
                     float(self._force[within].max(initial=0.0)))
