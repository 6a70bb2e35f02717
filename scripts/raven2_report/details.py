"""For engineers: the session's soundness, links, loops, plans, and where it comes from."""

import io
import re

import numpy as np

from raven2_report import metric_words
from raven2_report.text import counted, esc, is_number, number, percent, table, words

PAPER_ERROR = "2.43 ± 1.72 mm"  # Li et al. 2017, Figure 4: the real robot in a run without faults


def arm_contacts(header):
    """The arms of the model that could touch the scene at the start; older logs have one word for both."""
    arms = header["arm_contacts"]
    if isinstance(arms, bool):
        return "on" if arms else "off"
    return esc(", ".join(f"{arm} {'on' if on else 'off'}" for arm, on in zip(header["arm_names"], arms)))


class Details:
    def __init__(self, facts):
        self.facts, self.session, self.series = facts, facts.session, facts.series
        self.metrics, self.meta, self.log, self.header = facts.metrics, facts.meta, facts.log, facts.header
        self.duration, self.faults = facts.duration, facts.faults

    def notices(self):
        notes = []
        if self.facts.score_broken:
            notes.append("score.json is not what score_session writes, so nothing of it is shown.")
        if not self.log.clean:
            notes.append("This session did not end properly: its last record is missing"
                         + (f", {self.log.truncated_bytes:,} bytes of a record were cut short"
                            if self.log.truncated_bytes else "")
                         + ". Everything up to that point is shown; figures that are only counted at the end are not.")
        if self.log.bad_bytes:
            notes.append(f"{self.log.bad_bytes:,} bytes of the log were damaged and left out.")
        missing = max(self.log.lost, self.metrics.get("records_dropped") or 0)  # metrics of a crashed session have 0
        if missing:
            notes.append(f"{missing:,} records are missing from the log.")
        lost = {name: queue["dropped"] for name, queue in self.metrics.get("queues", {}).items()
                if queue["dropped"] and not name.endswith("_records")}
        if lost:
            notes.append("Queues were full: " + ", ".join(f"{n:,} {words(name)}" for name, n in lost.items())
                         + " were lost.")
        if self.metrics.get("counters_add_up") is False:
            notes.append("The counters do not add up: some packets or records are unaccounted for.")
        if not len(self.series.t):
            notes.append("The pedal was never pressed: the session has no ticks.")
        return "".join(f'<p class="notice">{esc(n)}</p>' for n in notes)

    def cards(self):
        error = self.metrics.get("model_robot_error_mm", {})
        ratio = self.metrics.get("on_time_ratio", {})
        haptic = self.metrics.get("haptic", {})
        plan = self.metrics.get("plan", {})
        lockstep = self.metrics.get("lockstep")
        delays = [f["error_to_force_ms"] for f in self.faults if is_number(f.get("error_to_force_ms"))]
        spread = f"{number(error.get('mean'))} ± {number(error.get('std'))} mm" if error else "–"
        entries = [
            ("Duration", number(float(self.duration), 1, "s"), "from the first pedal down"),
            ("Ticks", number(self.metrics.get("ticks", len(self.series.t))), "steps of 1 ms"),
            ("On time", percent(ratio.get("physics")),
             "simulated clock: no deadlines" if lockstep else
             f"physics loop; haptic loop {percent(ratio.get('haptic'))}"),
            ("Faults", number(len(self.faults)), esc(words(self.header["hazard"]))),
            ("Model to robot", spread, "tip distance outside faults, mean ± standard deviation; for comparison, the "
             f"real robot of Li et al. 2017: {PAPER_ERROR}"),
            ("Largest distance", number(error.get("max"), 2, "mm"), "outside faults"),
            ("Strongest cue", number(haptic.get("max_force_N"), 2, "N"),
             f"outside faults {number(haptic.get('max_force_outside_faults_N'), 2, 'N')}"
             + (f"<br>{esc(max(delays))} ms at most from error to force" if delays else "")),
            ("Plan", esc(words(plan.get("status", "–"))),
             f"cost {number(plan['cost'])}, {number(plan['waypoints'])} waypoints" if plan.get("success")
             else "path planner"),
        ]
        return '<div class="cards">' + "".join(
            f'<div class="card"><span>{title}</span><b>{value}</b><small>{note}</small></div>'
            for title, value, note in entries) + "</div>"

    def _no_fault(self):
        unknown = len(self.facts.deviations)
        if not unknown:
            return metric_words.no_fault(self.facts.unmerged)
        are = "is" if unknown == 1 else "are"
        return f"No fault is known. {counted(unknown, 'deviation').capitalize()} of unknown cause {are} listed above."

    def fault_table(self):
        if not self.faults:
            return f"<p>{self._no_fault()}</p>"
        rows = []
        for i, f in enumerate(self.faults, 1):
            delay = f.get("error_to_force_ms")
            rows.append([i, esc(words(f["name"])), number(f["first_tick"] / 1000, 3, "s"),
                         f"{f['last_tick'] - f['first_tick'] + 1:,} ms",
                         f"{f['first_cycle']:,} – {f['last_cycle']:,}" if "first_cycle" in f else "–",
                         number(f.get("max_error_mm"), 2, "mm"), number(f.get("max_force_N"), 2, "N"),
                         number(delay, 0, "ms")])
        return table(["", "Scenario", "Start", "Length", "Robot cycles", "Largest tip distance", "Strongest cue",
                      "Error to force"], rows, {0, 2, 3, 4, 5, 6, 7})

    def motion_table(self):
        """How fast the surgeon's motion was and how much of it the joint limits clipped, per arm."""
        active = self.series.teleoperating
        if not np.any(active) or "v_BT" not in self.series.ticks["model"]["arms"].dtype.names:
            return "<p>No motion with the pedal down was recorded.</p>"
        arms = self.series.ticks["model"]["arms"][active]
        rows = []
        for i, name in enumerate(("gold", "green")):
            speed = np.linalg.norm(arms["v_BT"][:, i], axis=1) * 1000.0
            status = arms["ik_status"][:, i]
            rows.append([name, number(float(speed.mean()), 1), number(float(np.percentile(speed, 99)), 1),
                         number(float(speed.max()), 1), percent(float((status == 1).mean())),
                         percent(float(((status > 1) & (status != 5)).mean()))])
        return table(["Arm", "Tip speed, mean [mm/s]", "99 % below", "Largest", "Clipped by a joint limit",
                      "Refused (out of reach)"], rows, {1, 2, 3, 4, 5})

    def packet_table(self):
        packets = self.metrics.get("packets")
        if not packets:
            return "<p>The packet counters are written at the end of a session; this session has no counters.</p>"
        rows = []
        for key, title in (("master_to_daemon", "Console to simulator"), ("daemon_to_robot", "Simulator to robot"),
                           ("robot_to_daemon", "Robot to simulator"), ("daemon_to_console", "Simulator to console")):
            link = packets[key]
            reasons = link.get("rejected") or {}
            refused = sum(reasons.values())
            received, applied = link.get("received"), link.get("applied")
            adds_up = "" if received is None else ("✓" if received == applied + refused else "does not add up")
            if received is None and "received" in link:
                adds_up = "not reported by this robot"
            unsent = link["failed"] + link["dropped"] if "failed" in link else None
            rows.append([title, number(link.get("sent")), number(unsent), number(received), number(applied),
                         number(refused) if received is not None else "–", adds_up, number(link.get("used")),
                         esc(", ".join(f"{words(k)} {v:,}" for k, v in reasons.items() if v))])
        return table(["Link", "Sent", "Not sent", "Received", "= Applied", "+ Rejected", "", "Moved the model",
                      "Why rejected"], rows, {1, 2, 3, 4, 5, 7})

    def timing_table(self):
        timing = self.metrics.get("timing", {})
        if not timing or self.metrics.get("lockstep"):
            reason = "Run in lockstep: time is simulated, no loop had a deadline." if timing else "Not counted."
            return f"<p>{reason}</p>"
        rows = [[esc(name), number(loop["ticks"]), number(loop["slips"]), number(loop.get("late_runs")),
                 number(loop.get("longest_late_run"), 0, "ms"), number(loop["time_slips"]),
                 *(number(loop[kind]["p999"] / 1000, 3, "ms") if kind in loop else "–"
                   for kind in ("wake_up_us", "run_us")),
                 number(loop["max_late_us"] / 1000, 2, "ms"), number(loop["max_run_us"] / 1000, 2, "ms"),
                 number(loop["stale_reads"])] for name, loop in timing.items()]
        return table(["Loop, 1 kHz", "Periods", "Late", "Overruns", "Longest", "Backlogs given up", "Start p99.9",
                      "Body p99.9", "Latest start", "Longest body", "Stale reads"], rows, set(range(1, 11)))

    def plan_section(self):
        plans = self.log.plans["result"]
        if not len(plans):
            return "<p>No plan was asked for.</p>"
        statuses = self.log.names("plan", "result.status")
        arms = self.log.names("plan", "result.arm")
        rows = []
        for tick, plan in zip(self.log.plans["tick"], plans):
            count = int(plan["waypoint_count"])
            travel = float(plan["arrival"][count - 1]) if count else None
            rows.append([number(self.facts.session_time(int(tick)), 3, "s"), esc(words(statuses[plan["status"]])),
                         esc(arms[plan["arm"]]), number(count), number(travel, 2, "s"),
                         number(float(plan["cost"]), 3), number(int(plan["samples"])),
                         number(float(plan["planning_time"]), 3, "s")])
        return table(["Time", "Outcome", "Arm", "Waypoints", "Travel", "Cost (eq. 1)", "Samples",
                      "Planning time"], rows, {0, 3, 4, 5, 6, 7})

    def execution_section(self):
        """Results of executed plans; nothing without them."""
        executions = self.log.executions["report"] if self.log.executions is not None else []
        if not len(executions):
            return ""
        ends = self.log.names("execution", "report.end")
        arms = self.log.names("execution", "report.arm")
        rows = [self._execution_row(e, words(ends[e["end"]]), arms[e["arm"]]) for e in executions]
        return "<h2>Planned motions</h2>" + table(
            ["Time", "Moved", "Outcome", "Duration", "Model off the path, mean [mm]", "Largest",
             "Robot off the path, mean "
             "[mm]", "Largest", "Clearance planned", "Kept by the model", "By the robot", "In contact"], rows,
            {0, 3, 4, 5, 6, 7, 8, 9, 10, 11})

    def _execution_row(self, execution, end, arm):
        started = int(execution["started"])
        # A plan keeps clear of everything. A repeated trial has no plan, and moves both arms.
        repeats = float(execution["planned_clearance"]) == 0.0
        arm = "both arms" if repeats else arm
        moved = f"{arm}, model and robot" if execution["on_robot"] else f"{arm}, model alone"
        if started < 0:
            return ["–", esc(moved), esc(f"{end}, never begun"), *["–"] * 9]
        end = end if end == "finished" else f"{end} at {100.0 * float(execution['progress']):.0f} %"
        errors = [number(float(execution[who][kind]) * 1000.0) if who == "model" or execution["on_robot"] else "–"
                  for who in ("model", "robot") for kind in ("mean", "largest")]
        kept = [number(float(execution[f"{who}_clearance"]) * 1000.0, 1, "mm")
                if who == "model" or execution["on_robot"] else "–" for who in ("model", "robot")]
        return [number(self.facts.session_time(started), 3, "s"), esc(moved), esc(end),
                number((int(execution["ended"]) - started) / 1000.0, 2, "s"), *errors,
                "–" if repeats else number(float(execution["planned_clearance"]) * 1000.0, 1, "mm"), *kept,
                f"{int(execution['contact_ticks']):,} ms"]

    def provenance(self):
        ticks = self.series.ticks
        virtual = bool(ticks["robot"]["is_virtual"].any()) if len(ticks) else None
        rows = [["Hazard armed", esc(self.header["hazard"])], ["Seed", esc(self.header["seed"])],
                ["Hand motion", esc(self.header["motion"] or self.meta.get("motion", "–"))],
                ["Robot", "–" if virtual is None else "virtual Raven" if virtual else "real robot, or none"],
                ["Arm contacts in the model", arm_contacts(self.header)]]
        for key, title in (("program", "Program"), ("version", "Version"), ("start_time_utc", "Started (UTC)"),
                           ("wall_duration_s", "Wall-clock duration [s]"), ("realtime", "Scheduling")):
            if key in self.meta:
                rows.append([title, esc(self.meta[key])])
        rows.append(["Log", f"format {self.header['format_version']}, {len(self.log.ticks):,} ticks, "
                            f"{len(self.log.commands):,} commands, {'complete' if self.log.clean else 'cut off'}"])
        hashes = [[title, f"<code>{esc(self.header[key] or '–')}</code>"] for key, title in (
            ("robot_urdf_hash", "Robot description"), ("scene_urdf_hash", "Scene description"))]
        files = self.meta.get("config_files", [])
        whole = self.header["config_hash"] or "–"  # those of all files, one behind the other
        hashes.append(["Configuration", f"<code>{esc(whole)}</code>" if len(whole) <= 16 else
                       f"{len(files)} files: their names and hashes are in meta.json"])
        listed = [[esc(f["name"]), f"<code>{esc(f['fnv1a'])}</code>"] for f in files]
        return (f'<div class="two"><div>{table(["Session", ""], rows, set())}</div>'
                f'<div>{table(["File", "FNV-1a, 64 bit"], hashes, set())}</div></div>'
                f'<div class="files">{table(["File", "FNV-1a, 64 bit"], listed, set()) if listed else ""}</div>')


def inline_svg(figure, name):
    """The figure as SVG for the page: scales with it, and its ids are its own."""
    import matplotlib  # slow to load
    import raven2_figures

    matplotlib.rcParams["svg.hashsalt"] = name
    text = io.StringIO()
    raven2_figures.save_svg(figure, text, metadata={"Date": None})
    svg = text.getvalue()
    svg = svg[svg.index("<svg"):]
    svg = re.sub(r'(<svg[^>]*?) width="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r'(<svg[^>]*?) height="[^"]*"', r"\1", svg, count=1)
    svg = re.sub(r"<metadata>.*?</metadata>", "", svg, flags=re.S)
    return re.sub(r'id="((?:figure|axes|patch|line2d|text|legend|matplotlib\.axis|xtick|ytick)_\d+)"',
                  rf'id="{name}.\1"', svg)
