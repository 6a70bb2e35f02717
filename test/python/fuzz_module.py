"""Calls each public function, method and property of raven2_trainer with random arguments. A program, because a crash ends it.

    fuzz_module.py SEED CALLS [MODULE]    # CALLS of each class, four times as many of all else; in an empty folder

A call may work, or raise an Exception other than SystemError, which means that C code broke Python's rules. Each callable works
at least once. Afterwards all objects give the same numbers as before, and closed ones refuse. The file `calls` names each
call before it is made: after a crash its last line is the cause.

Introspection finds the callables. If a new one has parameters with new names, add values for them to good_values().
"""

import faulthandler
import gc
import importlib
import importlib.util
import inspect
import operator
import os
import pkgutil
import re
import reprlib
import sys
import warnings

import numpy as np

import raven2_trainer
from raven2_trainer.simulation import root_file

# Modules, classes and members that are left out, and why.
NOT_CALLED = {
    "msg": "ROS messages: genpy's code",
    "srv": "ROS services: genpy's code",
    "session.FlightRecorder": "only SessionLog makes one, from the files of a killed simulator: test_flight_recorder.py",
    "_core.Simulation.close": "ends the object: see Fuzz.call_closed()",
    "simulation.VectorSimulation.close": "ends the object: see Fuzz.call_closed()",
    "gym.Raven.close": "ends the object: see Fuzz.call_closed()",
}
if importlib.util.find_spec("gymnasium") is None:
    NOT_CALLED["gym"] = "gymnasium is missing: test_python_gym.py runs this program with it"
NEVER_WORK = {f"_core.{name}{end}" for name in ("Snapshot", "State") for end in ("", ".__init__")}  # only a simulation makes them
MOST_CALLS = {"_core.Planner": 2, "simulation.Planner": 2, "campaign.Campaign.run": 4}  # they take some 0.3 s
PICK = "pick_hand_over_place"
LARGEST = np.finfo(float).max
FAULT = {"host": "robot", "site": "put_usb_packet", "variable": "dac", "kind": "stuck_at", "arm": "gold", "channel": "shoulder", "value": 0,
         "start": {"trigger": "pedal_down", "first_tick": 5}, "duration_ticks": 5}
CAMPAIGN = {
    "name": "one", "title": "One", "source": "none", "plant": "identified", "homing": "quick", "arm_contacts": False, "cpu_limit": 20,
    "horizon_ticks": {"homing": 300, "pedal_down": 20}, "limits": {"masked": 1e-4, "jump": 1e-3, "still": 3e-4, "moved": 1e-3, "force": 0.05},
    "scenarios": [{"scenario": "dac", "injection": 0, "number": 0, "observed": "none", "published": [], "phase": "pedal_down",
                   "repetitions": 1, "faults": [FAULT]}]}


class Bad:
    """Raises when C code or Python asks for a value."""

    def _refuse(self, *_):
        raise ArithmeticError("bad")

    __array__ = __bool__ = __eq__ = __float__ = __fspath__ = __getitem__ = __index__ = __int__ = __iter__ = __len__ = __repr__ = __str__ = _refuse
    __hash__ = object.__hash__


def new_folder():
    return f"made{len(os.listdir())}"


def wrong_values(made):
    """No infinite iterator: a list of it fills the memory. No paths that lead out of the folder."""
    recursive, nested = [], 0.0
    recursive.append(recursive)
    for _ in range(600):
        nested = [nested]
    scalars = [None, True, -1, 0, 3, 2**31 - 1, 2**32, 2**63, 2**70, -0.5, 1e300, float("nan"), float("inf"), 1j, Ellipsis]
    texts = ["", "gold", "none", "own", "commands:x", "clumsy:x", "%s%n", "a\0b", "\ud800", "x" * 3000, b"\xff\x00", b"gold"]
    groups = [[], [1, 2, 3], (), {}, {1: 2}, set(), range(7), iter([1.0]), recursive, nested, {"nested": nested}, {"model/contact_mu": nested},
              {"gold": {}}, {"gold": {"joints": "x"}}, {"gold": {"joints": [LARGEST] * 7}}, {"green": {"turn": [LARGEST] * 3}}, [[None] * 7] * 2]
    arrays = [np.zeros(7), np.zeros((2, 7)), np.full(7, 1e300), np.full(7, LARGEST), np.full((2, 7), np.nan), np.full((2, 7), LARGEST),
              np.zeros((2, 7), complex), np.full((2, 7), "a"), np.full(7, None), np.zeros(7, "f8,i4"), np.zeros(7, "M8[s]"), np.zeros(7, "f2"),
              np.zeros((0, 7)), np.zeros((1,) * 31 + (7,)), np.zeros((2, 7))[::-1, ::-1], np.broadcast_to(0.0, (1, 2**57, 7)),
              np.ma.masked_all((2, 7)), memoryview(bytes(56)).cast("d")]
    return [*scalars, *texts, *groups, *arrays, object(), Bad(), lambda: 1, raven2_trainer.Simulation, *made.values()]


def make_objects():
    """At least one object of each class that a caller can have."""
    simulation, other = raven2_trainer.Simulation(PICK, hazard="sudden_jump", link="wifi"), raven2_trainer.Simulation(robot="none")
    simulation.start()
    with raven2_trainer.Simulation(robot="none", output="recorded") as recorded:
        recorded.step(ticks=50)
    session = raven2_trainer.Session("recorded")
    campaign = raven2_trainer.Campaign(CAMPAIGN)
    campaign.run("campaign")
    made = {"simulation": simulation, "other": other, "state": simulation.state, "snapshot": simulation.save(), "foreign": other.save(),
            "many": raven2_trainer.VectorSimulation(2, robot="none"), "kinematics": raven2_trainer.Kinematics(), "campaign": campaign,
            "planner": raven2_trainer.Planner(), "session": session, "log": session.log}
    if "gym" not in NOT_CALLED:
        made["env"] = importlib.import_module("raven2_trainer.gym").Reach(max_steps=5)
        made["env"].reset(seed=1)
    return made


def good_values(made):
    """Values with which calls work, by "function.parameter" or "parameter". Each first call has the first ones."""
    home, tips = made["state"].joints.copy(), made["state"].tips_in_world
    near = home[0] + [0.05, -0.03, 0.005, 0, 0, 0, 0]
    motion = np.zeros((2, 7))
    motion[:, 2] = 1e-4
    of_simulations = {
        "exercise": ["none", PICK], "hazard": ["none", "sudden_jump"], "seed": [1, 0, 2**64 - 1], "config": [root_file(), None],
        "robot": ["none", "virtual"], "has_robot": [False, True], "motion": ["commands", "scripted"], "output": ["", new_folder, "recorded"],
        "plant": ["", "more_friction"], "link": ["none", "wan"], "settings": [[], {"model/contact_mu": 0.4}], "n": [1, 2], "threads": [1, 2],
        "command": [None, motion, {"gold": {"joints": near}, "pedal": True}], "commands": [None, [None, motion], np.array([motion, motion])],
        "ticks": [1, 5], "limit": [2000, 3], "snapshot": [made["snapshot"], made["foreign"]], "inject.hazard": ["video_loss", "encoder_dead"],
        "camera": ["top", "endoscope"], "width": [32], "height": [24],
        "step_all.arg0": [made["many"].simulations], "step_all.arg1": [[None, motion]], "step_all.arg2": [2], "step_all.arg3": [2, 2**32 - 1]}
    of_motion = {
        "arm": ["gold", "green"], "joints": [home[0], home], "start": [home[0]], "goal": [near, tips[0] + 0.002], "other": [None, home[1]],
        "waypoints": [[home[0], near]], "a": [home[0]], "b": [near], "p": [made["state"].tips[0].copy()], "R": [np.eye(3)], "opening": [0.0, 0.5]}
    of_sessions = {
        "definition": [CAMPAIGN], "jobs": [1], "resume": [False], "run.output": [new_folder, "campaign"], "outcomes.directory": ["campaign"],
        "directory": ["recorded"], "path": ["recorded/session.rlog"], "Session.ticks": [None, (10, 20)], "SessionLog.ticks": [None, (10, 20)],
        "record": ["tick"], "field": ["model.mode"], "records": ["ticks", "commands"], "name": ["meta.json"],
        "fields": [[{"name": "x", "type": "f64", "shape": []}]], "value": [3], "least": [1], "most": [None, 5], "as_plain.value": [np.zeros(2)]}
    of_gym = {
        "number": [1, 0], "Raven.exercise": [PICK], "Reach.exercise": [None, PICK], "arms": [("gold",), ("gold", "green")], "steps": [None, 1],
        "pictures": [None, (16, 12)], "max_steps": [5, None], "variations": [1, 2], "render_mode": [None, "rgb_array"],
        "action": [np.zeros(3)], "reset.seed": [None, 1], "options": [None]}
    return {**of_simulations, **of_motion, **of_sessions, **of_gym}


class Callable:
    """A function or constructor; or a method or the getter of a property, bound to each object that has it, then unbound."""

    def __init__(self, name, functions, kind=None):
        self.name, self.functions, self.kind, self.worked = name, functions, kind, 0
        self.parameters = parameters_of(functions[0])


def parameters_of(function):
    """Names, without self. Functions of pybind11 have them in the first line of the docstring alone."""
    function = function.__init__ if inspect.isclass(function) else function
    try:
        found = inspect.signature(function).parameters.values()
    except ValueError:
        first = (function.__doc__ or "").partition("\n")[0].partition(" -> ")[0]
        return [name for name in re.findall(r"(\w+): ", first) if name != "self"]
    return [one.name for one in found if one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD) and one.name != "self"]


def public(names):
    return sorted(name for name in names if not name.startswith("_"))


def getter(thing, name):
    return lambda: getattr(thing, name)


def members(kind, name_of_kind, objects):
    """Callables of a class. pybind11 ignores a second __init__; it is called as well."""
    mine = [one for one in objects if isinstance(one, kind)]
    again = ["__init__"] if name_of_kind.startswith("_core.") and "__init__" in vars(kind) else []
    for name in public(vars(kind)) + again:
        member, full = vars(kind)[name], f"{name_of_kind}.{name}"
        if isinstance(member, property):
            yield Callable(full, [*(getter(one, name) for one in mine), member.fget], kind)
        elif callable(getattr(kind, name)):
            yield Callable(full, [*(getattr(one, name) for one in mine), getattr(kind, name)], kind)


def find_callables(objects):
    """All of the package's own, in the same order each time."""
    found = []
    names = (each.name for each in pkgutil.iter_modules(raven2_trainer.__path__))
    for module_name in sorted(name for name in names if name == "_core" or not name.startswith("_")):
        if module_name in NOT_CALLED:
            continue
        module = importlib.import_module(f"raven2_trainer.{module_name}")
        for name in public(vars(module)):
            thing, full = getattr(module, name), f"{module_name}.{name}"
            if not callable(thing) or getattr(thing, "__module__", "") != module.__name__ or full in NOT_CALLED:
                continue
            found.append(Callable(full, [thing]))
            if inspect.isclass(thing):
                found += [one for one in members(thing, full, objects) if one.name not in NOT_CALLED]
    many = next(one for one in objects if isinstance(one, raven2_trainer.VectorSimulation))  # has the properties of a state
    return found + [Callable(f"simulation.VectorSimulation.{name}", [getter(many, name)], type(many)) for name in public(vars(raven2_trainer.State))]


class Fuzz:
    def __init__(self, seed, calls, only=""):
        self.random, self.count = np.random.default_rng(seed), calls
        self.made = make_objects()
        self.good, self.wrong = good_values(self.made), wrong_values(self.made)
        self.callables = [one for one in find_callables(list(self.made.values())) if one.name.startswith(only)]
        self.snapshots = [one.save() for one in self.made["many"].simulations]
        self.log = os.open("calls", os.O_CREAT | os.O_WRONLY | os.O_APPEND)

    def run(self):
        before = self.numbers()
        for number in range(4 * self.count):
            for one in self.callables:
                if number < min(self.count if inspect.isclass(one.functions[0]) else 4 * self.count, MOST_CALLS.get(one.name, 1000)):
                    self.call(one, number)
            self.made["simulation"].restore(self.made["snapshot"])  # a hazard may have stopped the robot
        self.set_attributes()
        assert self.numbers() == before, "an object changed"
        idle = [one.name for one in self.callables if not one.worked and one.name not in NEVER_WORK]
        assert not idle, f"no call works, so good_values() is wrong: {idle}"
        self.call_closed()

    def pick(self, values):
        return values[self.random.integers(len(values))]

    def good_value(self, one, parameter, is_first):
        function = one.name.rpartition(".")[2]
        values = self.good.get(f"{function}.{parameter}") or self.good.get(parameter)
        assert values, f"{one.name}: good_values() lacks {parameter}"
        value = values[0] if is_first else self.pick(values)
        return value() if value is new_folder else value

    def call(self, one, number):
        """The first call is right. Later ones have right values alone, one wrong value, or wrong values alone."""
        function = one.functions[0] if number == 0 else self.pick(one.functions)
        kind = "right" if number == 0 else self.pick(["right", "one wrong", "one wrong", "wrong"])
        if kind == "wrong":
            positional = [self.pick(self.wrong) for _ in range(self.random.integers(len(one.parameters) + 2))]
            return self.attempt(one.name, function, *positional)
        named = {parameter: self.good_value(one, parameter, number == 0) for parameter in one.parameters}
        if kind == "one wrong" and named:
            named[self.pick(list(named))] = self.pick(self.wrong)
        is_positional = any(name.startswith("arg") for name in named)  # without names in pybind11
        worked = self.attempt(one.name, function, *(named.values() if is_positional else []), **({} if is_positional else named))
        one.worked += worked
        return worked

    def attempt(self, name, function, /, *positional, **named):
        """Returns whether it worked."""
        os.write(self.log, f"{name} {reprlib.repr(positional)} {reprlib.repr(named)}\n".encode(errors="replace"))
        try:
            function(*positional, **named)
        except SystemError:
            raise
        except Exception:  # pylint: disable=broad-except
            return False
        return True

    def set_attributes(self):
        """Wrong values for properties, and for what Python keeps in an object: methods then meet them."""
        for name, thing in self.made.items():
            mine = [one for one in self.callables if one.kind and isinstance(thing, one.kind)]
            properties = {one.name.rpartition(".")[2] for one in mine if isinstance(vars(one.kind).get(one.name.rpartition(".")[2]), property)}
            own = getattr(thing, "__dict__", {})
            saved = dict(own)
            for attribute in public({*properties, *own}) if mine else ():
                for _ in range(2):
                    self.attempt(f"{name}.{attribute} =", setattr, thing, attribute, self.pick(self.wrong))
                    self.call(self.pick(mine), 1)
                self.attempt(f"del {name}.{attribute}", delattr, thing, attribute)
                own.clear()
                own.update(saved)

    def numbers(self):
        """Results of the objects, as bytes."""
        made, seen = self.made, []
        for simulation, snapshot in ((made["simulation"], made["snapshot"]), *zip(made["many"].simulations, self.snapshots)):
            simulation.restore(snapshot)
            for command in self.good["command"]:
                simulation.step(command, ticks=20)
                seen += [simulation.state.joints.tobytes(), simulation.state.robot_joints.tobytes(), simulation.state.objects.tobytes()]
        joints, near = self.good["joints"][1], self.good["b"][0]
        seen += [made["kinematics"].jacobian("gold", joints).tobytes(), made["planner"].clearance("gold", joints).tobytes(),
                 made["planner"].edge_cost("gold", joints[0], near), made["session"].table()["model.arms.1.q.3"].tobytes()]
        if "env" in made:
            seen += [made["env"].reset(seed=2)[0].tobytes(), made["env"].step(np.ones(3))[0].tobytes()]
        return seen

    def call_closed(self):
        """Closed objects refuse to step, and keep their last state."""
        last = self.made["simulation"].state.joints.copy()
        for name in ("simulation", "many", "env"):
            if name in self.made:
                self.attempt(f"{name}.close", self.made[name].close, self.pick(self.wrong))
                self.made[name].close()
                self.made[name].close()
        for one in self.callables:
            if one.kind and one.name.startswith(("_core.S", "simulation.V", "gym.")):
                for number in range(2):
                    self.call(one, number)
        assert not self.attempt("closed", self.made["simulation"].step) and not self.attempt("closed", self.made["many"].step)
        assert np.array_equal(self.made["state"].joints, last)


def demand_all(callables):
    """Introspection finds all that the package offers, and no exception to it is out of date."""
    missed = {name for name in raven2_trainer.__all__ if not any(getattr(raven2_trainer, name) is one.functions[0] for one in callables)}
    assert not missed, missed
    for name in NOT_CALLED:
        module, *rest = name.split(".")
        if module != "gym" or "gym" not in NOT_CALLED:
            operator.attrgetter(".".join(rest) or "__name__")(importlib.import_module(f"raven2_trainer.{module}"))


def main():
    faulthandler.enable()
    warnings.simplefilter("ignore")  # numpy's, of wrong values
    seed, calls, *only = sys.argv[1:]
    fuzz = Fuzz(int(seed), int(calls), *only)
    if not only:
        demand_all(fuzz.callables)
    fuzz.run()
    print(len(fuzz.callables), "callables")
    del fuzz
    gc.collect()


if __name__ == "__main__":
    main()
