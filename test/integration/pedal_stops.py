"""How fast a released pedal stops what is being executed.

Measured between clocks of one computer: the console's when the released pedal is sent, the robot's own in its state frames,
and the daemon's in its session log.
"""
import glob
import os

PEDAL_UP, PEDAL_DN = 2, 3
LIMIT = 0.020  # s from the release, as sent, to the robot's PEDAL_UP and to its last motion
MOVING = 0.05  # rad/s, a tenth of the planner's limit
# rad, rad, m that still are rest: 1 ms of the path at full speed is 5e-4 rad and 1e-4 m. A tip 0.1 m below the remote
# centre is moved by 0.03 mm.
REST = (3e-4, 3e-4, 3e-5)


def newest_session(name):
    """Directory of the session that the launch file of test `name` records."""
    return sorted(glob.glob(os.path.join(os.environ["RAVEN2_TEST_OUTPUT"], f"{name}_*")))[-1]


def is_fast(state, arm=0):
    """Does the arm move, shoulder or elbow?"""
    return max(map(abs, state.dq[arm][:2])) > MOVING


def differ(state, other, arms=(0,)):
    """Does any of the arms stand elsewhere?"""
    return any(abs(a - b) > limit for arm in arms for a, b, limit in zip(state.q[arm], other.q[arm], REST))


def release_when(console, robot, condition):
    """The pedal goes up as soon as condition(newest state) holds. @return (release [ns], index of the state then)."""
    assert robot.wait(condition) is not None, "it never was so far"
    first = len(robot.states)
    return console.release(), first


def robot_stop(robot, released, first, arms=(0,)):
    """(s to the robot's first PEDAL_UP, s to its last motion), 0.7 s being watched."""
    end = robot.states[-1].cycle + 700
    assert robot.wait(lambda s: s.cycle >= end) is not None
    states = robot.states[first - 100:]
    before = [s for s in states if s.time_ns < released]
    after = [s for s in states if s.time_ns >= released]
    assert before[-1].runlevel == PEDAL_DN
    assert differ(before[-1], before[-20], arms), "it stood before the release: nothing is shown"
    up = next(s for s in after if s.runlevel == PEDAL_UP)
    moving = [s for s in after if differ(s, states[-1], arms)]
    last = moving[-1] if moving else after[0]
    return 1e-9 * (up.time_ns - released), 1e-9 * (last.time_ns - released)


def model_stop(log, released, arms=(0,)):
    """(s to the tick in which the model stops being led, s to when it stands where the robot stands)."""
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


def check_stops(test, log, stops, arms=(0,)):
    """Prints and judges them. @param stops as (release [ns], *robot_stop())."""
    for k, (released, up, still) in enumerate(stops):
        held, joined = model_stop(log, released, arms)
        print(f"release {k + 1}: PEDAL_UP after {1e3 * up:.2f} ms, the robot's last motion after {1e3 * still:.2f} ms; "
              f"the model left its path after {1e3 * held:.2f} ms and was on the robot after {1e3 * joined:.2f} ms")
    for released, up, still in stops:
        test.assertLessEqual(up, LIMIT)
        test.assertLessEqual(still, LIMIT)
        test.assertLessEqual(model_stop(log, released, arms)[0], LIMIT)
