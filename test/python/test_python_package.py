"""Tests the package raven2_trainer: its help, its stubs, and its messages without the simulator."""

import ast
import os
import subprocess

from built_module import BUILD, ROOT, raven2_trainer


def test_help_has_the_stubs_texts():
    assert raven2_trainer.State.joints.__doc__.startswith("(2, 7) [rad; m")
    for function in (raven2_trainer.Simulation.step, raven2_trainer.Simulation.render, raven2_trainer.Kinematics.forward, raven2_trainer.Planner.plan):
        assert "[m]" in function.__doc__ or "(height, width, 3)" in function.__doc__, function


def test_the_messages_are_there_without_the_simulator():
    code = "import sys; from raven2_trainer.msg import TrainerMode; assert 'raven2_trainer._core' not in sys.modules; print(TrainerMode().mode)"
    subprocess.run(["/usr/bin/python3", "-c", code], check=True, env={**os.environ, "PYTHONPATH": os.pathsep.join(
        [str(BUILD / "devel/lib/python3/dist-packages"), "/usr/lib/python3/dist-packages"])})


def test_the_stubs_name_what_there_is():
    stubs = {node.name: node for node in ast.parse((ROOT / "python/raven2_trainer/__init__.pyi").read_text()).body if isinstance(node, ast.ClassDef)}
    functions = {"outcomes"}
    assert set(stubs) | functions == set(raven2_trainer.__all__)
    of_instances = {"VectorSimulation": None, "Session": {"directory", "log", "metrics", "faults", "meta"}, "Campaign": {"definition"}}
    for name, stub in stubs.items():
        said = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
        said |= {node.target.id for node in stub.body if isinstance(node, ast.AnnAssign)}
        made = getattr(raven2_trainer, name)
        there = {member for member in dir(made) if not member.startswith("_")}
        if issubclass(made, BaseException):
            continue
        if name == "VectorSimulation":  # has what a state has
            assert {s for s in said if not s.startswith("_")} == there - {"LISTS"} | {"simulations"} | {
                member for member in dir(raven2_trainer.State) if not member.startswith("_")}, name
        else:
            assert {s for s in said if not s.startswith("_")} == there | of_instances.get(name, set()), name


def parameters(function):
    """Each parameter, in order: its kind, name, and whether it has a default."""
    a = function.args
    usual = a.posonlyargs + a.args
    required = len(usual) - len(a.defaults)
    return [*(("usual", one.arg, i >= required) for i, one in enumerate(usual)), ("*", a.vararg and a.vararg.arg),
            *(("by name", one.arg, default is not None) for one, default in zip(a.kwonlyargs, a.kw_defaults)), ("**", a.kwarg and a.kwarg.arg)]


def interface(body):
    """Name to form of everything public that a module or class defines; the class has the attributes of its objects."""
    found = {}
    for node in body:
        stored = [one for one in ast.walk(node) if isinstance(getattr(one, "ctx", None), ast.Store)]
        if isinstance(node, ast.ClassDef):
            bases = [ast.unparse(base.value if isinstance(base, ast.Subscript) else base) for base in node.bases]
            found[node.name] = (bases, interface(node.body))
        elif isinstance(node, ast.FunctionDef):
            found[node.name] = ([ast.unparse(one) for one in node.decorator_list], parameters(node))
            found.update((one.attr, "value") for one in stored if isinstance(one, ast.Attribute) and ast.unparse(one.value) == "self")
        elif isinstance(node, (ast.Assign, ast.AnnAssign)):
            found.update((one.id, "value") for one in stored if isinstance(one, ast.Name))
    return {name: form for name, form in found.items() if name == "__init__" or not name.startswith("_")}


def test_the_stubs_of_gym_have_the_signatures_of_the_module():
    module, stubs = (interface(ast.parse((ROOT / "python/raven2_trainer" / name).read_text()).body) for name in ("gym.py", "gym.pyi"))
    assert stubs == module and {"Raven", "Reach", "variation", "TICKS"} <= set(stubs)
    assert "action_space" in stubs["Raven"][1] and ("by name", "seed", True) in stubs["Raven"][1]["reset"][1]


def test_the_stubs_are_in_the_package():
    package = BUILD / "devel/lib/python3/dist-packages/raven2_trainer"
    for stub in (ROOT / "python/raven2_trainer").glob("*.pyi"):
        assert (package / stub.name).read_text() == stub.read_text(), stub.name
