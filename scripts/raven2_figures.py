"""The figures of a session, for session_report and plot_session. Matplotlib 3.6, no display needed."""

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt  # noqa: E402  (the backend has to be chosen first)
import numpy as np  # noqa: E402
import raven2_kinematics  # noqa: E402
from matplotlib.backends.backend_agg import FigureCanvasAgg  # noqa: E402
from matplotlib.backends.backend_svg import FigureCanvasSVG  # noqa: E402
from raven2_report.drawing import thinned  # noqa: E402

MAX_POINTS = 3000  # of a drawn line
ARMS = ("gold", "green")
# Model red and robot blue, as in Figure 4 of Li et al. 2017.
MODEL, ROBOT, FAULT, PLAN, PEDAL_UP = "#c8323c", "#2457c5", "#f6b73c", "#8ecae6", "#9aa3ad"
ARM_COLOURS = {"gold": "#b8860b", "green": "#2f7d4f"}
STYLE = {
    "font.family": "sans-serif",
    "font.size": 9.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.edgecolor": "#6b7480",
    "axes.labelcolor": "#2b323a",
    "axes.grid": True,
    "grid.color": "#e4e7eb",
    "grid.linewidth": 0.7,
    "xtick.color": "#4b5560",
    "ytick.color": "#4b5560",
    "lines.linewidth": 1.2,
    "legend.frameon": False,
    "svg.fonttype": "none",
    "savefig.dpi": 150,
}
plt.rcParams.update(STYLE)


def save_png(figure, file):
    """The same picture as figure.savefig(), which draws twice: first only to measure."""
    figure.set_dpi(plt.rcParams["savefig.dpi"])
    FigureCanvasAgg(figure).print_png(file)


def save_svg(figure, file, metadata=None):
    """Likewise."""
    FigureCanvasSVG(figure).print_svg(file, metadata=metadata)


def runs(mask):
    """(first, last) index pairs of the stretches in which `mask` is true."""
    edges = np.flatnonzero(np.diff(np.concatenate(([0], mask.astype(np.int8), [0]))))
    return list(zip(edges[::2], edges[1::2] - 1))


class Series:
    """A session's curves over the session time `t` [s], which starts at the first pedal down."""

    def __init__(self, session):
        log = session.log
        self.log = log
        self.header = log.header
        begun = int(np.argmax(np.append(log.ticks["model"]["session_tick"] >= 0, True)))
        ticks = log.ticks[begun:]  # no copy: a session of five minutes has a gigabyte of them
        model, robot = ticks["model"], ticks["robot"]
        self.ticks = ticks
        self.t = model["session_tick"] / 1000.0
        seen = robot["frame"] > 0
        self.q_model = model["arms"]["q"]
        has_asked = "q_d" in model["arms"].dtype.names
        self.q_asked = model["arms"]["q_d"] if has_asked else np.full_like(self.q_model, np.nan)
        self.q_robot = np.where(seen[:, None, None], robot["arms"]["q"], np.nan)
        self.p_model = model["arms"]["p_BT"]
        self.p_robot = np.where(seen[:, None, None], robot["arms"]["p_BT"], np.nan)
        in_robot = np.where(seen, robot["active_fault"], 0)
        has_own = "faults" in (model.dtype.names or ())  # logs older than version 5 have no faults of the daemon
        self.fault_ids = np.where(in_robot != 0, in_robot, model["faults"]["active"]) if has_own else in_robot
        self.fault_windows = [(self.t[a], self.t[b], self.scenario(self.fault_ids[a])) for a, b in self._fault_runs()]
        self.runlevel = np.where(seen, robot["runlevel"], -1)
        modes = log.names("tick", "model.mode")
        self.teleoperating = model["mode"] == modes.index("teleoperating")
        self.tracking = self._in_modes(model, modes, "tracking", "executing")
        self.choosing = self._in_modes(model, modes, "choosing")
        self.model_alone = self._in_modes(model, modes, "simulating", "trial", "camera_moving")
        comparable = self.teleoperating & seen & (model["robot_fresh"] != 0)
        if "linked" in model.dtype.names:
            comparable &= model["linked"] != 0
        distance = np.linalg.norm(self.p_model - self.p_robot, axis=2) * 1000.0
        self.error_mm = np.where(comparable[:, None], distance, np.nan)
        self.tolerance_mm = self.header["tolerance"] * 1000.0
        self._forces(log, model)

    def longest_tracking(self):
        """Tip [m] in the base frame of the arm that the longest tracked plan moved: `user`, `plan`, `track`; with the
        plan's `id` and `arm`. None if no plan was tracked."""
        spans = runs(self.tracking)
        if not spans or "planning" not in self.ticks["model"].dtype.names:
            return None
        first, last = max(spans, key=lambda span: span[1] - span[0])
        plans = {int(p["result"]["id"]): p["result"] for p in self.log.plans if p["result"]["waypoint_count"] > 0}
        plan = plans.get(int(self.ticks["model"]["planning"]["plan"][first]))
        if plan is None:
            return None
        arm = int(plan["arm"])
        choosing = [span for span in runs(self.choosing) if span[1] < first]
        begun, ended = choosing[-1] if choosing else self._hand_before(first)
        user = self.p_model[begun:ended + 1:PATH_STEP, arm]
        return {"id": int(plan["id"]), "arm": ARMS[arm], "user": user, "plan": self._planned(plan),
                "track": self.p_model[first:last + 1:PATH_STEP, arm]}

    def _hand_before(self, first):
        """The last stretch of teleoperation before, at most USER_BEFORE; empty without one."""
        spans = [span for span in runs(self.teleoperating) if span[1] < first]
        if not spans:
            return 0, -1
        return max(spans[-1][0], spans[-1][1] - int(1000 * USER_BEFORE)), spans[-1][1]

    def _planned(self, plan):
        """Straight in joints from one waypoint to the next."""
        count = int(plan["waypoint_count"])
        waypoints, arrival = plan["waypoints"][:count], plan["arrival"][:count]
        t = np.append(np.arange(arrival[0], arrival[-1], PATH_STEP / 1000.0), arrival[-1])
        joints = np.stack([np.interp(t, arrival, waypoints[:, j]) for j in range(7)], axis=1)
        arm = int(plan["arm"])
        return raven2_kinematics.forward(arm, joints, self.header["d4"], self._wrist_to_tool(arm))[:, :3, 3]

    def _wrist_to_tool(self, arm):
        """[m] The header has d4 alone; this is what leads from the first tick's joints to its pose."""
        q = self.q_model[:1, arm]
        without, unit = (raven2_kinematics.forward(arm, q, self.header["d4"], lw)[0, :3, 3] for lw in (0.0, 1.0))
        return float((self.p_model[0, arm] - without) @ (unit - without))

    @staticmethod
    def _in_modes(model, modes, *names):
        """Older logs do not know every mode."""
        return np.isin(model["mode"], [modes.index(name) for name in names if name in modes])

    def _fault_runs(self):
        """A change of fault id without a gap is a new window."""
        return [run for fault in np.unique(self.fault_ids[self.fault_ids > 0]) for run in runs(self.fault_ids == fault)]

    def scenario(self, fault_id):
        scenarios = self.header["scenarios"]
        return scenarios[fault_id - 1] if fault_id <= len(scenarios) else f"fault_{fault_id}"

    def _forces(self, log, model):
        """[N] of both arms over their own clock, shifted to session time."""
        origin = int(model["tick"][0] - model["session_tick"][0]) if len(model) else 0
        ticks = log.haptic["haptic"]["tick"]
        inside = ticks >= origin
        # Not a mere shift: the session's clock stops while the exercise is paused.
        last = np.clip(np.searchsorted(model["tick"], ticks[inside], side="right") - 1, 0, None)
        self.force_t = model["session_tick"][last] / 1000.0 if len(model) else ticks[inside] / 1000.0
        self.force = np.linalg.norm(log.haptic["haptic"]["force_B"][inside], axis=2)


def _new(height, width=9.6):
    figure, axes = plt.subplots(figsize=(width, height), constrained_layout=True)
    return figure, axes


def _mark(axes, series):
    """Shades faults and plans, and a strip below where the surgeon's pedal is up."""
    for i, (first, last, _) in enumerate(series.fault_windows):
        axes.axvspan(first, last, color=FAULT, alpha=0.45, linewidth=0, label=None if i else "fault acting")
    for i, (a, b) in enumerate(runs(series.tracking)):
        axes.axvspan(series.t[a], series.t[b], color=PLAN, alpha=0.25, linewidth=0, label=None if i else "plan followed")
    for i, (a, b) in enumerate(runs(~(series.teleoperating | series.tracking | series.choosing | series.model_alone))):
        axes.axvspan(series.t[a], series.t[b], 0, 0.025, color=PEDAL_UP, linewidth=0,
                     label=None if i else "pedal up, stopped")
    if len(series.t) > 1:
        axes.set_xlim(series.t[0], series.t[-1])
    axes.set_xlabel("time since first pedal down [s]")


def _legend(axes):
    """One line above the axes; the empty title keeps the room, so that a long legend does not squeeze the plot."""
    axes.set_title(" ", fontsize=11)
    legend = axes.legend(loc="lower left", bbox_to_anchor=(-0.01, 1.0), ncol=7, borderaxespad=0.2, handlelength=1.6,
                         columnspacing=1.4)
    legend.set_in_layout(False)


def joint_figure(series):
    """Joint 1 of the gold arm, model and robot (Figure 5 of Li et al. 2017)."""
    figure, axes = _new(3.1)
    _mark(axes, series)
    model, robot = (np.degrees(q[:, 0, 0]) for q in (series.q_model, series.q_robot))
    axes.plot(*thinned(series.t, model, MAX_POINTS), color=MODEL, linewidth=2.4, alpha=0.6, label="model")
    axes.plot(*thinned(series.t, robot, MAX_POINTS), color=ROBOT, linewidth=1.0, label="robot")
    axes.set_ylabel("joint 1, gold arm [deg]")
    _legend(axes)
    return figure


def force_figure(series):
    """Magnitude of the force on the surgeon's hands (Figure 6 of Li et al. 2017)."""
    figure, axes = _new(2.8)
    _mark(axes, series)
    for i, arm in enumerate(ARMS):
        axes.plot(*thinned(series.force_t, series.force[:, i], MAX_POINTS), color=ARM_COLOURS[arm], label=f"{arm} arm")
    axes.plot([], [], " ", label=f"(acts beyond {series.tolerance_mm:g} mm)")
    axes.set_ylabel("haptic force [N]")
    axes.set_ylim(bottom=0)
    _legend(axes)
    return figure


def error_figure(series):
    """Distance of the tool tips of model and robot, and the threshold of the haptic cue."""
    figure, axes = _new(2.8)
    _mark(axes, series)
    for i, arm in enumerate(ARMS):
        axes.plot(*thinned(series.t, series.error_mm[:, i], MAX_POINTS), color=ARM_COLOURS[arm], label=f"{arm} arm")
    axes.axhline(series.tolerance_mm, color="#30363d", linewidth=0.9, linestyle=(0, (5, 3)),
                 label=f"threshold {series.tolerance_mm:g} mm")
    axes.set_ylabel("tip distance [mm]")
    axes.set_ylim(bottom=0)
    _legend(axes)
    return figure


def path_figure(series):
    """Tip paths of model and robot in three projections of each arm's base frame."""
    figure, grid = plt.subplots(2, 3, figsize=(9.6, 6.2), constrained_layout=True)
    step = max(1, -(-len(series.t) // MAX_POINTS))
    for row, arm in enumerate(ARMS):
        for axes, (a, b) in zip(grid[row], ((0, 1), (0, 2), (1, 2))):
            for points, label, style in ((series.p_model, "model", {"color": MODEL, "linewidth": 1.8, "alpha": 0.5}),
                                         (series.p_robot, "robot", {"color": ROBOT, "linewidth": 0.8})):
                line = 1000 * points[::step, row]
                axes.plot(line[:, a], line[:, b], label=label, **style)
            axes.set_xlabel(f"{'xyz'[a]} [mm]")
            axes.set_ylabel(f"{'xyz'[b]} [mm]")
            axes.set_aspect("equal", adjustable="datalim")
        grid[row, 0].set_title(f"{arm} arm", loc="left", fontsize=10, color=ARM_COLOURS[arm], fontweight="bold")
    grid[0, 2].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncol=2, borderaxespad=0.2)
    return figure


def timing_figure(series):
    """Histogram of the time between starts of physics ticks; None where no clock ran (lockstep)."""
    periods_us = np.diff(series.ticks["model"]["time_ns"]) / 1000.0
    if len(periods_us) == 0 or np.all(periods_us == 1000.0):
        return None
    figure, axes = _new(2.6)
    top = min(max(2500.0, float(periods_us.max())), 10000.0)
    axes.hist(np.clip(periods_us, 0, top), bins=np.linspace(0, top, 101), color="#5b6b7f")
    axes.axvline(1000, color=MODEL, linewidth=1.0, linestyle=(0, (5, 3)), label="1 ms")
    axes.set_yscale("log")
    longer = " (longer ones in the last bar)" if periods_us.max() > top else ""
    axes.set_xlabel("time between physics ticks [us]" + longer)
    axes.set_ylabel("ticks")
    _legend(axes)
    return figure


JOINTS = (("shoulder", "deg"), ("elbow", "deg"), ("insertion", "mm"), ("tool rotation", "deg"), ("wrist", "deg"))


def joints_figure(series):
    """The first five joints of both arms: asked for, model and robot (Figure 4 of Li et al. 2017)."""
    figure, grid = plt.subplots(len(JOINTS), 2, figsize=(9.6, 9.0), sharex=True, constrained_layout=True)
    for i, arm in enumerate(ARMS):
        for axes, (joint, (name, unit)) in zip(grid[:, i], enumerate(JOINTS)):
            scale = 1000.0 if unit == "mm" else np.degrees(1.0)
            for values, style in ((series.q_asked, {"color": "black", "linewidth": 0.8, "label": "operator"}),
                                  (series.q_model, {"color": MODEL, "linewidth": 2.2, "alpha": 0.6, "label": "model"}),
                                  (series.q_robot, {"color": ROBOT, "linewidth": 1.0, "label": "robot"})):
                axes.plot(*thinned(series.t, scale * values[:, i, joint], MAX_POINTS), **style)
            axes.set_ylabel(f"{name} [{unit}]")
        error = series.error_mm[:, i]
        apart = f", tips {np.nanmean(error):.2f} ± {np.nanstd(error):.2f} mm apart" if not np.all(np.isnan(error)) else ""
        grid[0, i].set_title(f"{arm} arm{apart}", loc="left", fontsize=10, color=ARM_COLOURS[arm], fontweight="bold")
        grid[-1, i].set_xlabel("time since first pedal down [s]")
    if len(series.t) > 1:
        grid[0, 0].set_xlim(series.t[0], series.t[-1])
    figure.suptitle(" ", fontsize=11)  # room for the legend
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="upper right", ncol=3)
    return figure


PATH_STEP = 40  # [ms] between the marks of a path: the denser, the slower
USER_BEFORE = 10.0  # [s] of the surgeon's own motion before a plan was asked for
USER, PLANNED, TRACKED = "#c8323c", "#2f9e44", "#2457c5"  # as in Figures 7 and 8 of Li et al. 2017


def plan_figure(series):
    """Tip of the arm that a plan moved: the user's motion before, the plan, and how it was tracked, each with a mark
    every 40 ms (Figures 7 and 8 of Li et al. 2017); None without such a plan."""
    motion = series.longest_tracking()
    if motion is None:
        return None
    figure = plt.figure(figsize=(9.6, 4.4), constrained_layout=True)
    space = figure.add_subplot(1, 3, (1, 2), projection="3d")
    flat = [figure.add_subplot(2, 3, 3), figure.add_subplot(2, 3, 6)]
    for label, colour, points in (("user", USER, motion["user"]), ("plan", PLANNED, motion["plan"]),
                                  ("track", TRACKED, motion["track"])):
        line = 1000.0 * points
        if len(line) == 0:
            continue
        style = {"color": colour, "marker": "o", "markersize": 2.2, "linewidth": 0.6, "label": label}
        space.plot(*line.T, **style)
        for axes, (a, b) in zip(flat, ((0, 1), (0, 2))):
            axes.plot(line[:, a], line[:, b], **style)
    for axes, (a, b) in zip(flat, ((0, 1), (0, 2))):
        axes.set_xlabel(f"{'xyz'[a]} [mm]")
        axes.set_ylabel(f"{'xyz'[b]} [mm]")
        axes.set_aspect("equal", adjustable="datalim")
    space.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    space.set_title(f"plan {motion['id']}, {motion['arm']} arm, in its base frame", loc="left", fontsize=10)
    space.legend(loc="upper right")
    return figure


FIGURES = {
    "joints": joints_figure,
    "joint_1": joint_figure,
    "haptic_force": force_figure,
    "tip_error": error_figure,
    "tip_paths": path_figure,
    "plan_paths": plan_figure,
    "timing": timing_figure,
}
