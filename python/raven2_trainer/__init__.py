"""The simulator of the Raven-II in Python. `raven2_trainer.msg` and `.srv` are its ROS messages.

    import raven2_trainer
    simulation = raven2_trainer.Simulation("pick_hand_over_place")
    simulation.start()
    simulation.step({"gold": {"move": [0, 0, 0.005]}}, ticks=100)
    print(simulation.state.tips)

doc/python.md. The compiled part is loaded at the first use of a name, so that ROS programs do without it.
"""

_NAMES = {"Campaign": "campaign", "outcomes": "campaign", "Planner": "simulation", "Session": "session", "SessionLog": "session",
          "SessionError": "session",
          "Simulation": "simulation", "VectorSimulation": "simulation", "Kinematics": "simulation", "Snapshot": "_core", "State": "_core",
          "ConfigError": "_core", "RenderError": "_core", "ModelError": "_core"}
__all__ = sorted(_NAMES)


def __getattr__(name):
    if name not in _NAMES:
        raise AttributeError(f"module 'raven2_trainer' has no attribute {name!r}")
    import importlib  # pylint: disable=import-outside-toplevel
    return getattr(importlib.import_module(f".{_NAMES[name]}", __name__), name)


def __dir__():
    return sorted([*globals(), *_NAMES])
