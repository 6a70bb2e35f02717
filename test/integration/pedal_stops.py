"""How fast a released pedal stops an execution.

All clocks are of one computer: the console's when it sends the released pedal, the robot's in its state frames, and the
daemon's in its session log.
"""
import glob
import os
import sys
import time

import numpy as np

sys.path.insert(0, os.path.join(os.path.dirname(os.path.realpath(__file__)), "..", "..", "scripts"))
import raven2_session  # noqa: E402

PEDAL_UP, PEDAL_DN = 2, 3
LIMIT = 0.020  # s from the release, as sent, to the robot's PEDAL_UP and to its last motion
MOVING = 0.05  # rad/s, a tenth of the planner's limit
# rad, rad, m that still count as rest: 1 ms of the path at full speed is 5e-4 rad and 1e-4 m. They move a tip 0.1 m
# below the remote centre by 0.03 mm.
REST = (3e-4, 3e-4, 3e-5)
# s between two ticks of the robot or of the daemon. Beyond it, a release says more about the machine than about the
# trainer and is repeated.
LATE = 0.004
WINDOW_NS = (-30_000_000, 60_000_000)  # around the release, in which both must have ticked on time


class Late(Exception):
    """The machine, not the trainer, was late."""


def stops_of(test, release, count, session, arms=(0,)):
    """Measures and judges `count` releases. Tries at most three times as many. @param release: release(k) returns
    (release [ns], s to PEDAL_UP, s to the robot's last motion), or throws Late."""
    stops, reasons = [], []
    while len(stops) < count:
        assert len(stops) + len(reasons) < 3 * count, f"the machine was late too often: {reasons}"
        try:
            released, up, still = release(len(stops))
            time.sleep(0.3)  # the recorder writes 20 times a second
            log = raven2_session.Session(newest_session(session)).log
            demand_on_time(log.ticks["model"]["time_ns"], released, "daemon")
            stops.append((released, up, still, *model_stop(log, released, arms)))
        except Late as late:
            reasons.append(str(late))
            print(f"a release is repeated: {late}")
    check_stops(test, stops)


def demand_on_time(times, released, who):
    near = np.array([t for t in times if WINDOW_NS[0] <= int(t) - released <= WINDOW_NS[1]], dtype=np.int64)
    gap = 1e-9 * np.diff(near).max()
    if gap > LATE:
        raise Late(f"the {who} did not tick for {1e3 * gap:.1f} ms")


def newest_session(name):
    """Directory of the session that the launch file of test `name` records."""
    return sorted(glob.glob(os.path.join(os.environ["RAVEN2_TEST_OUTPUT"], f"{name}_*")))[-1]


def is_fast(state, arm=0):
    """Whether the arm moves its shoulder or elbow."""
    return max(map(abs, state.dq[arm][:2])) > MOVING


def differ(state, other, arms=(0,)):
    """Whether any of the arms is elsewhere."""
    return any(abs(a - b) > limit for arm in arms for a, b, limit in zip(state.q[arm], other.q[arm], REST))


def release_when(console, robot, condition):
    """Releases the pedal as soon as condition(newest state) holds. @return (release [ns], index of the state then)."""
    assert robot.wait(condition) is not None, "the condition for the release never held"
    first = len(robot.states)
    return console.release(), first


def robot_stop(robot, released, first, arms=(0,)):
    """Watches 0.7 s. @return (s to the robot's first PEDAL_UP, s to its last motion)."""
    end = robot.states[-1].cycle + 700
    assert robot.wait(lambda s: s.cycle >= end) is not None
    states = robot.states[first - 100:]
    demand_on_time([s.time_ns for s in states], released, "robot")
    before = [s for s in states if s.time_ns < released]
    after = [s for s in states if s.time_ns >= released]
    assert before[-1].runlevel == PEDAL_DN
    if not differ(before[-1], before[-20], arms):
        raise Late("the robot was at rest before the release: the test shows nothing")
    up = next(s for s in after if s.runlevel == PEDAL_UP)
    moving = [s for s in after if differ(s, states[-1], arms)]
    last = moving[-1] if moving else after[0]
    return 1e-9 * (up.time_ns - released), 1e-9 * (last.time_ns - released)


def model_stop(log, released, arms=(0,)):
    """@return (s to the tick in which the model leaves its path, s until the model rests at the robot's place)."""
    times, model = log.ticks["model"]["time_ns"], log.ticks["model"]
    executing = log.names("tick", "model.mode").index("executing")
    before = times < released
    assert model["mode"][before][-1] == executing
    after = ~before & (times < released + 600_000_000)
    assert model["mode"][after][-1] != executing
    held = times[after][model["mode"][after] != executing][0]
    q = model["arms"]["q"][after][:, list(arms), :3]
    far = (abs(q - q[-1]) > REST).any(axis=(1, 2))
    joined = times[after][far][-1] if far.any() else held
    return 1e-9 * (held - released), 1e-9 * (joined - released)


def check_stops(test, stops):
    """Prints and judges them. @param stops as (release [ns], *robot_stop(), *model_stop())."""
    for k, (_, up, still, held, joined) in enumerate(stops):
        print(f"release {k + 1}: PEDAL_UP after {1e3 * up:.2f} ms, the robot's last motion after {1e3 * still:.2f} ms; "
              f"the model left its path after {1e3 * held:.2f} ms and was on the robot after {1e3 * joined:.2f} ms")
    for _, up, still, held, _ in stops:
        test.assertLessEqual(up, LIMIT)
        test.assertLessEqual(still, LIMIT)
        test.assertLessEqual(held, LIMIT)


def demand_released(report):
    """@throw Late if the path ended before the pedal went up."""
    if report.end == "finished":
        raise Late("the path was done before the pedal went up")
