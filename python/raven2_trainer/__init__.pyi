"""The simulator of the Raven-II in Python (doc/python.md). Arms are in the order gold, green; SI units throughout."""

from os import PathLike
from types import TracebackType
from typing import Any, Mapping, Optional, Sequence, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

Command = Union[None, dict[str, Any], ArrayLike]

class ConfigError(ValueError):
    """A setting that is not known, missing or out of its range."""

class ModelError(RuntimeError):
    """The robot's or the scene's description cannot be used."""

class RenderError(RuntimeError):
    """No OpenGL context, or it cannot draw."""

class SessionError(RuntimeError):
    """A session cannot be written or read."""

class Snapshot:
    """All state of one simulation."""

    @property
    def size(self) -> int:
        """[bytes]"""

class State:
    """The newest state. Arrays are views of the simulation's memory: they change with each step and cannot be written."""

    @property
    def joints(self) -> NDArray[np.float64]:
        """(2, 7) [rad; m for the insertion] joints of the model."""
    @property
    def joint_rates(self) -> NDArray[np.float64]:
        """(2, 7) [rad/s; m/s]"""
    @property
    def torques(self) -> NDArray[np.float64]:
        """(2, 7) [Nm; N] on the model's joints in the last tick."""
    @property
    def desired_joints(self) -> NDArray[np.float64]:
        """(2, 7) [rad; m] where the commands lead."""
    @property
    def tips(self) -> NDArray[np.float64]:
        """(2, 3) [m] tool tips of the model, each in its arm's base frame B."""
    @property
    def tips_in_world(self) -> NDArray[np.float64]:
        """(2, 3) [m] in the world frame W (x forward, y left, z up); a copy."""
    @property
    def desired_tips_in_world(self) -> NDArray[np.float64]:
        """(2, 3) [m] where the commands lead, in W; a copy. The model follows some 100 ms later."""
    @property
    def tip_velocities(self) -> NDArray[np.float64]:
        """(2, 3) [m/s] in B."""
    @property
    def tip_rotations(self) -> NDArray[np.float64]:
        """(2, 4) unit quaternions x, y, z, w of the tools in B."""
    @property
    def robot_joints(self) -> NDArray[np.float64]:
        """(2, 7) [rad; m] joints that the robot reports; zeros without a robot."""
    @property
    def robot_tips(self) -> NDArray[np.float64]:
        """(2, 3) [m] in B."""
    @property
    def true_joints(self) -> NDArray[np.float64]:
        """(2, 7) [rad; m] true joints of the robot's plant; a copy."""
    @property
    def dac(self) -> NDArray[np.int32]:
        """(2, 7) [counts] the robot's last motor commands."""
    @property
    def force(self) -> NDArray[np.float64]:
        """(2, 3) [N] on each hand, in B."""
    @property
    def error(self) -> NDArray[np.float64]:
        """(2,) [m] distance of the model's tip from the robot's."""
    @property
    def objects(self) -> NDArray[np.float64]:
        """(n, 7) [m; -] free objects in the world frame W: position, unit quaternion x, y, z, w."""
    @property
    def contacts(self) -> Sequence[int]:
        """Contact points on each arm of the model."""
    @property
    def contact_points(self) -> NDArray[Any]:
        """(n,) structured, a copy: contacts of the last tick, at most 64; bodies at rest have one a pair. a, b: numbers of
        bodies, for Simulation.body_names; depth [m]; position (3) [m, W]; normal (3) from b to a; force (3) [N, W] on a, friction included."""
    @property
    def contacts_dropped(self) -> int:
        """Contacts of the last tick that did not fit into contact_points."""
    @property
    def mode(self) -> str:
        """Mode of the trainer (doc/modes.md)."""
    @property
    def runlevel(self) -> str:
        """E-STOP, INIT, PEDAL_UP or PEDAL_DN; none without a robot."""
    @property
    def tick(self) -> int:
        """[ms] since the beginning."""
    @property
    def session_tick(self) -> int:
        """[ms] since the first pedal-down; -1 before."""
    @property
    def hazard(self) -> bool:
        """Whether a hazard acts."""
    @property
    def exercise(self) -> Mapping[str, Any]:
        """status: none, waiting, running, done or failed; attempt; steps_done; steps: their names; mistakes: how many of each kind."""

class Simulation:
    def __init__(self, exercise: Optional[str] = ..., hazard: Optional[str] = ..., seed: int = ...,
                 config: Union[str, PathLike[str], None] = ..., robot: str = ..., motion: Optional[str] = ...,
                 output: Union[str, PathLike[str], None] = ..., plant: Optional[str] = ..., link: Optional[str] = ...,
                 settings: Optional[Mapping[str, Any]] = ...) -> None: ...
    def step(self, command: Command = ..., ticks: int = ...) -> None:
        """Applies a command, spread evenly over `ticks` [ms], 1 to 1,000,000. None: the tools rest. An array (2, 7): per arm move (3) [m] and
        turn (3) [rad] along the axes of the world frame W, and jaw [rad], its opening. A dict: doc/python.md."""
    def start(self, limit: int = ...) -> int:
        """Steps with the pedal up until the arms wait for the pedal. Returns ticks [ms]; RuntimeError after `limit` of them."""
    def save(self) -> Snapshot:
        """A copy of the whole state, to the bit, for restore() of the same simulation."""
    def restore(self, snapshot: Snapshot) -> None:
        """Goes back to the state of save()."""
    def reseed(self, seed: int) -> None:
        """From now on a bad link, injected hazards and drills of later attempts draw from this seed; a hazard that the simulation was
        made with keeps its own. Packets in flight of a bad link are lost. Not with output."""
    def inject(self, hazard: str) -> None:
        """Starts a hazard of config/faults at once."""
    def clear_hazards(self) -> None:
        """Ends all hazards, those that wait for their trigger too."""
    def render(self, camera: str = ..., width: int = ..., height: int = ...) -> NDArray[np.uint8]:
        """RGB (height, width, 3), top row first, from a camera of config/render.yaml; with what hazards of the video do to it."""
    def measure(self, camera: str = ..., width: int = ..., height: int = ...) -> tuple[NDArray[np.float32], NDArray[np.uint16]]:
        """depth (height, width) [m] along the view direction, infinity where nothing is; part (height, width), an index of part_names."""
    @property
    def part_names(self) -> Sequence[str]:
        """Names of the links, by the numbers of measure()."""
    def close(self) -> None:
        """Ends the session, and scores a recorded one. The last state stays readable; pictures of it can be drawn."""
    def __enter__(self) -> "Simulation": ...
    def __exit__(self, kind: Optional[type], error: Optional[BaseException], trace: Optional[TracebackType]) -> None: ...
    @property
    def state(self) -> State:
        """The newest state."""
    @property
    def closed(self) -> bool:
        """Whether close() was called."""
    @property
    def cameras(self) -> Sequence[str]:
        """Names of the cameras for render()."""
    @property
    def object_names(self) -> Sequence[str]:
        """Names of the free objects, in the order of State.objects."""
    @property
    def body_names(self) -> Sequence[str]:
        """Names of the bodies, by the numbers of State.contact_points."""
    @property
    def memory(self) -> int:
        """[bytes] of a snapshot."""

class VectorSimulation:
    """n simulations side by side. All that a State has, with a first axis n; mode, runlevel, exercise and contact_points are lists."""

    simulations: Sequence[Simulation]
    joints: NDArray[np.float64]
    joint_rates: NDArray[np.float64]
    torques: NDArray[np.float64]
    desired_joints: NDArray[np.float64]
    tips: NDArray[np.float64]
    tips_in_world: NDArray[np.float64]
    desired_tips_in_world: NDArray[np.float64]
    tip_velocities: NDArray[np.float64]
    tip_rotations: NDArray[np.float64]
    robot_joints: NDArray[np.float64]
    robot_tips: NDArray[np.float64]
    true_joints: NDArray[np.float64]
    dac: NDArray[np.int32]
    force: NDArray[np.float64]
    error: NDArray[np.float64]
    objects: NDArray[np.float64]
    contacts: NDArray[np.int64]
    tick: NDArray[np.int64]
    session_tick: NDArray[np.int64]
    hazard: NDArray[np.bool_]
    mode: list[str]
    runlevel: list[str]
    exercise: list[Mapping[str, Any]]
    contact_points: list[NDArray[Any]]
    contacts_dropped: NDArray[np.int64]
    def __init__(self, n: int, exercise: Optional[str] = ..., hazard: Optional[str] = ..., seed: int = ..., threads: Optional[int] = ...,
                 output: Union[str, PathLike[str], None] = ..., **options: Any) -> None: ...
    def __len__(self) -> int: ...
    def step(self, commands: Union[None, Sequence[Command], NDArray[np.float64]] = ..., ticks: int = ...) -> None: ...
    def start(self, limit: int = ...) -> NDArray[np.int64]: ...
    def close(self) -> None: ...
    def __enter__(self) -> "VectorSimulation": ...
    def __exit__(self, kind: Optional[type], error: Optional[BaseException], trace: Optional[TracebackType]) -> None: ...

class Planner:
    """FMT* in the scene of an exercise (doc/planning.md)."""

    def __init__(self, exercise: Optional[str] = ..., config: Union[str, PathLike[str], None] = ...) -> None: ...
    def plan(self, arm: str, start: ArrayLike, goal: ArrayLike, other: Optional[ArrayLike] = ..., seed: int = ...) -> dict[str, Any]:
        """start (7,) joints; goal (7,) joints or (3,) tip position in the world [m]. status, waypoints (n, 7), arrival (n,) [s], cost,
        clearance [m], tracking_error [m], samples."""
    def in_collision(self, arm: str, joints: ArrayLike, other: Optional[ArrayLike] = ...) -> NDArray[np.bool_]:
        """joints (..., 7) -> (...): touches something, or is nearer than the clearance."""
    def clearance(self, arm: str, joints: ArrayLike, other: Optional[ArrayLike] = ...) -> NDArray[np.float64]:
        """joints (..., 7) -> (...) [m]: distance to what is nearest, of scene, robot and the arm itself, whose parts are at most 0.012
        apart; 0 where it touches."""
    def roll_out(self, arm: str, waypoints: ArrayLike, other: Optional[ArrayLike] = ...) -> dict[str, Any]:
        """The simulated arm follows waypoints (n, 7), from rest to rest on each edge. free: it came to rest at the end and touched
        nothing; failed_edge: the edge, from 0, on which it touched, or None; arrival (n,) [s] planned; duration [s]; tracking_error
        [m]; clearance [m], at most 0.05, a lower bound."""
    def edge_cost(self, arm: str, a: ArrayLike, b: ArrayLike) -> float:
        """Cost (eq. 1 of the paper) of the straight motion from joints a to b."""

class Campaign:
    """A grid of fault injections (doc/campaign.md)."""

    definition: Union[str, PathLike[str], dict[str, Any]]
    def __init__(self, definition: Union[str, PathLike[str], dict[str, Any]]) -> None: ...
    def run(self, output: Union[str, PathLike[str]], seed: int = ..., jobs: Optional[int] = ..., resume: bool = ...) -> list[dict[str, Any]]: ...

def outcomes(directory: Union[str, PathLike[str]]) -> list[dict[str, Any]]: ...

class SessionLog:
    """All records of a session.rlog as structured numpy arrays: ticks, haptic, commands, ... `ticks`: first and last physics
    tick [ms] of the part to read."""

    def __init__(self, path: Union[str, PathLike[str]], ticks: Optional[tuple[int, int]] = ...) -> None: ...
    def __getattr__(self, name: str) -> Any: ...
    def names(self, record: str, field: str) -> list[str]:
        """Names of an enum's values, e.g. names("tick", "model.mode")."""

class Session:
    """A session directory: log, and the files next to it."""

    directory: Union[str, PathLike[str]]
    log: SessionLog
    metrics: dict[str, Any]
    faults: dict[str, Any]
    meta: dict[str, Any]
    def __init__(self, directory: Union[str, PathLike[str]], ticks: Optional[tuple[int, int]] = ...) -> None: ...
    def table(self, records: str = ...) -> dict[str, NDArray[Any]]:
        """Columns of `ticks` or of other records of the log by name, {"model.arms.1.q.3": array (records,)}: for pandas.DataFrame."""
    def file(self, name: str) -> Any: ...

class Kinematics:
    def __init__(self, config: Union[str, PathLike[str], None] = ...) -> None: ...
    def forward(self, arm: str, joints: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """joints (..., 7) -> tip p (..., 3) [m] and rotation R (..., 3, 3) in the arm's base frame B."""
    def jacobian(self, arm: str, joints: ArrayLike) -> NDArray[np.float64]:
        """joints (..., 7) -> (..., 6, 7): rows linear [m/s] and angular [rad/s] velocity of the tip in B."""
    def inverse(self, arm: str, p: ArrayLike, R: ArrayLike, opening: float = ...) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """p (..., 3), R (..., 3, 3) -> joints (..., 8, 7), NaN where there is no solution, and whether each is one (..., 8)."""
