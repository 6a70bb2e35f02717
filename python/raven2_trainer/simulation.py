"""Simulations: console, daemon and virtual Raven in one process, stepped by a program."""

import concurrent.futures
import contextlib
import json
import os
import pathlib

import numpy as np

from . import _core
from .plain import as_plain, whole_number

MOST_THREADS = 1024  # ours: more than the cores of any computer


def _path(name, value):
    """As text; "" if missing."""
    text = "" if value is None else os.fsdecode(value)
    if "\0" in text:
        raise ValueError(f"{name} is {text!r}: a path has no null characters")
    return text


def _root(config):
    """The packaged configuration lies in the same prefix as this package, in the devel and in the install space."""
    if _path("config", config):
        return os.path.abspath(_path("config", config))  # a later chdir changes nothing
    packaged = pathlib.Path(__file__).parents[4] / "share/raven2_trainer/config/trainer.yaml"
    return str(packaged) if packaged.exists() and "RAVEN2_TRAINER_SHARE" not in os.environ else ""


def root_file(config=None):
    """Path of the root file of the configuration: `config`, or the packaged one."""
    root = _root(config)
    if not root and "RAVEN2_TRAINER_SHARE" not in os.environ:
        raise _core.ConfigError("the packaged configuration is missing: give config=FILE, or source the workspace's setup.bash")
    return root or os.path.join(os.environ["RAVEN2_TRAINER_SHARE"], "config/trainer.yaml")


def _yaml(values):
    """[(key, value as YAML)] of a dict of settings; arrays become lists."""
    return [(str(key), json.dumps(value, default=as_plain)) for key, value in (values or {}).items()]


class Kinematics(_core.Kinematics):
    """Forward and inverse kinematics and Jacobian of a root configuration's arms; arrays of any leading axes."""

    def __init__(self, config=None):
        super().__init__(_root(config))


class Planner(_core.Planner):
    """FMT* of both arms in the scene of an exercise; each path is followed by the dynamics before it is returned.

    plan(arm, start, goal, other=None, seed=1): from joints `start` (7) to joints (7) or to a tip position in the world (3); `other`:
    joints of the other arm, None: home. A dict: status ("success", or why not), waypoints (n, 7), arrival (n,) [s], cost (eq. 1),
    clearance and tracking_error [m] of the roll-out, samples.
    """

    def __init__(self, exercise=None, config=None):
        super().__init__(exercise or "none", _root(config))


class Simulation(_core.Simulation):
    """Both arms, the scene and, with `robot="virtual"`, the robot's control software, 1 ms a tick.

    exercise   name in config/exercises, or None
    hazard     name in config/faults, or None; in an exercise it comes as its drill, else by its own trigger. "own": the exercise's
    seed       of everything random; the same seed and commands give the same numbers, to the last bit
    config     path of a root file like config/trainer.yaml; None: the packaged one
    robot      "virtual": an emulated Raven follows the model; "none": the model alone, faster
    motion     None: commands of step(); else a simulated surgeon, "scripted", "expert" or "clumsy:NAME"
    output     directory of a recorded session; None: nothing is recorded
    plant      name in config/plants, the virtual Raven's motors, friction and cables; None: the configuration's
    link       name in config/impairments, the network between hands and trainer; None: a perfect one
    settings   {"model/contact_mu": 0.4}: values in place of the configuration's, by the file's name in trainer.yaml and its keys
    """

    def __init__(self, exercise=None, hazard=None, seed=1, config=None, robot="virtual", motion=None, output=None, plant=None, link=None,
                 settings=None):
        if robot not in ("virtual", "none"):
            raise ValueError(f"robot is {robot!r}, expected 'virtual' or 'none'")
        seed = whole_number("seed", seed, 0, 2**64 - 1)
        if plant and robot == "none":
            raise ValueError(f"plant is {plant!r}, but robot is 'none'")
        for name, value in (("exercise", exercise), ("hazard", hazard), ("motion", motion), ("plant", plant), ("link", link)):
            if value is not None and not isinstance(value, str):
                raise TypeError(f"{name} is {value!r}, expected a name or None")
            _path(name, value)  # of some, a file has the name
        super().__init__(exercise or "none", hazard or "none", seed, _root(config), robot == "virtual", motion or "commands",
                         _path("output", output), plant or "", link or "none", _yaml(settings))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()


class VectorSimulation:
    """n simulations side by side on all cores, seeds `seed` to `seed + n - 1`. It has the arrays and numbers of a simulation's state,
    with a first axis n; `mode`, `runlevel`, `exercise` and `contact_points` are lists. `output`: simulation i records in its folder i."""

    LISTS = ("mode", "runlevel", "exercise", "contact_points")

    def __init__(self, n, exercise=None, hazard=None, seed=1, threads=None, output=None, **options):
        n = whole_number("n", n, 1, _core.MOST_SIMULATIONS)  # of a process
        seed = whole_number("seed", seed, 0, 2**64 - n)
        self._threads = len(os.sched_getaffinity(0)) if threads is None else whole_number("threads", threads, 1, MOST_THREADS)
        output = _path("output", output)
        for i in range(n) if output else ():  # before the first one is made
            folder = os.path.join(output, str(i))
            if os.path.exists(os.path.join(folder, "session.rlog")):
                raise _core.SessionError(f"{folder}: already holds a session; give another directory")

        def make(i):
            return Simulation(exercise, hazard, seed + i, output=output and os.path.join(output, str(i)), **options)

        self.simulations = self._each(make, range(n))

    def _each(self, work, items):
        with concurrent.futures.ThreadPoolExecutor(self._threads) as pool:
            return list(pool.map(work, items))

    def __len__(self):
        return len(self.simulations)

    def step(self, commands=None, ticks=1):
        """commands: None, a list of n commands, or an array of shape (n, 2, 7)."""
        commands = [None] * len(self) if commands is None else list(commands)
        _core.step_all(self.simulations, commands, ticks, self._threads)

    def start(self, limit=20000):
        """The ticks that each one took, (n,)."""
        return np.array(self._each(lambda simulation: simulation.start(limit), self.simulations))

    def __getattr__(self, name):
        if name.startswith("_") or not hasattr(_core.State, name):
            raise AttributeError(f"VectorSimulation has no attribute {name!r}")
        values = [getattr(simulation.state, name) for simulation in self.simulations]
        return values if name in self.LISTS else np.stack(values)

    def close(self):
        with contextlib.ExitStack() as all_of_them:  # closes the others, too, if one fails
            for simulation in reversed(self.simulations):
                all_of_them.callback(simulation.close)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()
