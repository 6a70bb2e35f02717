"""Learning curves: each judged metric over the attempts of several sessions, beside the band."""

import json
import os

from raven2_report import drawing, metric_words
from raven2_report.facts import MAX_FILE, load_score, load_small
from raven2_report.scorecard import judged
from raven2_report.text import esc, is_number, table, words

MOST_METRICS = 12
MARKS = {True: ("circle", drawing.GOOD), False: ("cross", drawing.BAD), None: ("square", drawing.SOFT)}
FIRST = ("time", "path", "economy", "sparc", "wire_touches", "collisions", "drops", "peak_force", "idle", "clutches",
         "out_of_view", "bimanual")  # shown where nothing is judged


class Point:
    """One attempt: `session` its directory's name, `start` UTC, `passed` or None, `metrics` name to value."""

    def __init__(self, session, start, status, passed, metrics):
        self.session, self.start, self.status, self.passed = session, start, status, passed
        self.metrics = {name: value for name, value in metrics.items() if is_number(value)}


def _values(metrics):
    return {name: m.get("value") for name, m in metrics.items() if isinstance(m, dict)}


def points_of_session(directory, task):
    """Attempts of a scored session at that task (exercise, drill, trainee); None if it is another one or unscored."""
    score, _ = load_score(directory)
    if not score or _task(score) != task:
        return None
    meta = load_small(os.path.join(directory, "meta.json"), json.load)
    start = str(meta.get("start_time_utc", "")) if isinstance(meta, dict) else ""
    name = os.path.basename(os.path.abspath(directory))
    return [Point(name, start, str(a.get("status", "")), a.get("passed"), _values(a["metrics"]))
            for a in score["attempts"]]


def _task(entry):
    return tuple(str(entry.get(key) or "") for key in ("exercise", "drill", "trainee"))


def points_of_index(path, task):
    """The same from an index.json, which may be missing."""
    index = load_small(path, json.load) if os.path.isfile(path) and os.path.getsize(path) <= 32 * MAX_FILE else None
    sessions = index.get("sessions") if isinstance(index, dict) else None
    found = {}
    for entry in sessions if isinstance(sessions, list) else []:
        if isinstance(entry, dict) and _task(entry) == task and isinstance(entry.get("attempts"), list):
            name = str(entry.get("directory", ""))
            found[name] = [Point(name, str(entry.get("start_time_utc", "")), str(a.get("status", "")), a.get("passed"),
                                 a.get("metrics") or {}) for a in entry["attempts"] if isinstance(a, dict)]
    return found


def collect(facts, others):
    """Attempts in order of time, and the names of directories left out: other tasks, or no score.

    Of the directories given and, if the session has a trainee, of the index.json beside it."""
    if not facts.score:
        return [], [os.path.basename(os.path.abspath(d)) for d in others]
    task = _task(facts.score)
    parent = os.path.dirname(os.path.abspath(facts.session.directory))
    found = points_of_index(os.path.join(parent, "index.json"), task) if task[2] and task[0] else {}
    left_out = []
    for directory in [*others, facts.session.directory]:
        points = points_of_session(directory, task)
        name = os.path.basename(os.path.abspath(directory))
        if points is None:
            left_out.append(name)
        else:
            found[name] = points
    order = sorted(found.values(), key=lambda points: (points[0].start, points[0].session) if points else ("", ""))
    return [point for points in order for point in points if point.status != "waiting"], left_out


# ---- drawn ------------------------------------------------------------------------------------------------------


def section(facts, others):
    points, left_out = collect(facts, others)
    parts = []
    if len(points) > 1:
        small = "".join(_small(facts, name, points) for name in _names(facts, points))
        parts.append(f'<p class="sub">{len(points)} attempts of {len({p.session for p in points})} sessions at '
                     f'the same task, in order of time.</p>{_key()}<div class="three">{small}</div>{_table(points)}')
    elif points:
        parts.append("<p>One attempt so far: a curve needs more. <code>session_report DIR...</code> takes several "
                     "sessions, and "
                     "the trainee's <code>index.json</code> is read where there is one.</p>")
    if left_out:
        parts.append('<p class="sub">Left out, because they are another task or have no score: '
                     f'{esc(", ".join(left_out))}.</p>')
    return "".join(parts)


def _names(facts, points):
    """Judged metrics, those out of the band first; else the usual ones that were measured."""
    names = [name for name, _ in judged(facts)] or [n for n in FIRST if any(n in p.metrics for p in points)]
    return names[:MOST_METRICS]


def _key():
    entries = [("passed", drawing.GOOD, "circle"), ("not passed", drawing.BAD, "cross"),
               ("not judged", drawing.SOFT, "square"), ("within the band", "#d9dee4", "area")]
    return drawing.svg(1000, 24, drawing.legend(4, 16, entries, 12.5), "Legend", "key")


def _small(facts, name, points):
    metric = facts.attempt["metrics"].get(name, {})
    values = [(i, p.metrics[name], p) for i, p in enumerate(points, 1) if name in p.metrics]
    limit = metric.get("limit")
    numbers = [v for _, v, _ in values] + ([limit] if is_number(limit) else [])
    low, high = (min(numbers), max(numbers)) if numbers else (0.0, 1.0)
    room = 0.12 * (high - low) if high > low else max(abs(high), 1.0) * 0.2
    from_zero = 0.0 <= low < 2 * room
    panel = drawing.Panel(52, 30, 256, 120, (0.5, len(points) + 0.5), (0.0 if from_zero else low - room, high + room))
    parts = []
    if is_number(limit):
        zone = (panel.y_range[0], limit) if metric.get("better") == "lower" else (limit, panel.y_range[1])
        parts.append(drawing.rect(panel.x, panel.to_y(zone[1]), panel.width, panel.to_y(zone[0]) - panel.to_y(zone[1]),
                                  "#d9dee4"))
    unit = metric_words.unit_of(metric)
    parts.append(panel.frame(f"{metric_words.words_of(name).title}{f' [{unit}]' if unit else ''}", 4, 11))
    parts.append(panel.curve([i for i, _, _ in values], [v for _, v, _ in values], drawing.SOFT, 1.3))
    for i, value, point in values:
        good = _within(metric, value) if is_number(limit) else point.passed
        shape, colour = MARKS.get(good, MARKS[None])
        parts.append(drawing.mark(panel.to_x(i), panel.to_y(value), shape, colour,
                                  f"{point.session}: {metric_words.figure(name, metric, value)}", 4.5))
    parts.append(panel.x_axis("attempt", min(len(points), 6), 11, lambda v: f"{v:g}" if float(v).is_integer() else ""))
    return f"<figure>{drawing.svg(320, 190, ''.join(parts), f'{words(name)} over the attempts')}</figure>"


def _within(metric, value):
    return value <= metric["limit"] if metric.get("better") == "lower" else value >= metric["limit"]


def _table(points):
    rows = [[i, esc(p.session), esc(p.start), esc(words(p.status)),
             {True: "✓ passed", False: "✕ not passed"}.get(p.passed, "not judged")]
            for i, p in enumerate(points, 1)]
    return table(["Attempt", "Session", "Started (UTC)", "Exercise", "Verdict"], rows, {0})


def newest_first(directories):
    """The session that the report is about, and the others: by their start, else as they were given."""
    def start(directory):
        meta = load_small(os.path.join(directory, "meta.json"), json.load)
        return str(meta.get("start_time_utc", "")) if isinstance(meta, dict) else ""

    order = sorted(range(len(directories)), key=lambda i: (start(directories[i]), i))
    return directories[order[-1]], [directories[i] for i in order[:-1]]
