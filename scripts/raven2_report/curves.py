"""Learning curves: each judged metric over the attempts of several sessions, with the band."""

import collections
import json
import os

from raven2_report import drawing, metric_words
from raven2_report.facts import MAX_FILE, load_score, load_small
from raven2_report.text import esc, is_number, table, words

ANSWER = "hazard_response"
FIRST = ("time", ANSWER)  # of all curves
SHAPES = {True: "circle", False: "cross", None: "square"}  # of an attempt, by what it was judged
COLOURS = {True: drawing.GOOD, False: drawing.BAD, None: drawing.SOFT}  # of a figure, by its limit
USUAL = ("path", "economy", "sparc", "wire_touches", "collisions", "drops", "peak_force", "idle", "clutches",
         "out_of_view", "bimanual")  # shown where nothing is judged


class Point:
    """One attempt: `session` a short name of its directory, `start` UTC, `passed` or None, `metrics` name to value."""

    def __init__(self, start, status, passed, metrics):
        self.session = ""  # known once all sessions are: short_names
        self.start, self.status, self.passed = start, status, passed
        self.metrics = {name: value for name, value in metrics.items() if is_number(value)}


def _values(attempt):
    """Also the time from the cue to the right answer, as training/score.h has it (`firstAnswer`)."""
    values = {name: m.get("value") for name, m in attempt["metrics"].items() if isinstance(m, dict)}
    for hazard in attempt.get("hazards", []):
        answer = hazard.get("deciding") if isinstance(hazard, dict) else None
        if not isinstance(answer, dict) or hazard.get("verdict") not in ("right", "late"):
            continue
        if is_number(answer.get("after_ms")) and is_number(hazard.get("cue_after_ms")):
            values[ANSWER] = 0.001 * (answer["after_ms"] - hazard["cue_after_ms"])
            break
    return values


def points_of_session(directory, task):
    """(attempts, "") of a scored session at that task (exercise, drill, trainee); (None, why not) of another one."""
    score, _ = load_score(directory)
    why = _difference(_task(score), task) if score else "no score"
    if why:
        return None, why
    meta = load_small(os.path.join(directory, "meta.json"), json.load)
    start = str(meta.get("start_time_utc", "")) if isinstance(meta, dict) else ""
    return [Point(start, str(a.get("status", "")), a.get("passed"), _values(a)) for a in score["attempts"]], ""


def _difference(its, ours):
    """The difference that makes it another task, the most important first; empty: it is the same."""
    for what, one, other in zip(("exercise", "drill", "trainee"), its, ours):
        if one != other:
            return f"another {what}, {words(one)}" if one else f"no {what}"
    return ""


def _task(entry):
    return tuple(str(entry.get(key) or "") for key in ("exercise", "drill", "trainee"))


def place_of(path):
    """The directory itself, whatever leads to it: two sessions may have the same name."""
    try:
        return os.path.realpath(path)
    except ValueError:  # a name of an index.json with a NUL in it
        return path


def short_names(places):
    """{place: its last part, and as many parts before it as distinguish it from the others}."""
    parts = {place: place.strip(os.sep).split(os.sep) for place in places}
    names, length = {}, 0
    while len(names) < len(parts):
        length += 1
        ends = {place: os.sep.join(parts[place][-length:]) for place in parts if place not in names}
        count = collections.Counter(ends.values())
        names.update({place: end for place, end in ends.items() if count[end] == 1 or length >= len(parts[place])})
    return names


def points_of_index(path, task):
    """{place: attempts} from an index.json, which may be missing."""
    index = load_small(path, json.load) if os.path.isfile(path) and os.path.getsize(path) <= 32 * MAX_FILE else None
    sessions = index.get("sessions") if isinstance(index, dict) else None
    found = {}
    for entry in sessions if isinstance(sessions, list) else []:
        if isinstance(entry, dict) and _task(entry) == task and isinstance(entry.get("attempts"), list):
            place = place_of(os.path.join(os.path.dirname(path), str(entry.get("directory", ""))))
            found[place] = [Point(str(entry.get("start_time_utc", "")), str(a.get("status", "")), a.get("passed"),
                                  a.get("metrics") or {}) for a in entry["attempts"] if isinstance(a, dict)]
    return found


def collect(facts, others):
    """Attempts in order of time, and the directories left out: name to reason.

    Of the directories given and, if the session has a trainee, of the index.json next to it."""
    if not facts.score:
        return [], {name: "the reported session has no score" for name in short_names(map(place_of, others)).values()}
    task = _task(facts.score)
    parent = os.path.dirname(os.path.abspath(facts.session.directory))
    found = points_of_index(os.path.join(parent, "index.json"), task) if task[2] and task[0] else {}
    left_out = {}
    for directory in [*others, facts.session.directory]:
        points, why = points_of_session(directory, task)
        if points is None:
            left_out[place_of(directory)] = why
        else:
            found[place_of(directory)] = points
    names = short_names([*found, *left_out])
    for place, points in found.items():
        for point in points:
            point.session = names[place]
    order = sorted(found.values(), key=lambda points: (points[0].start, points[0].session) if points else ("", ""))
    begun = [point for points in order for point in points if point.status != "waiting"]
    return begun, {names[place]: why for place, why in left_out.items()}


# ---- drawn ------------------------------------------------------------------------------------------------------


def section(facts, others):
    points, left_out = collect(facts, others)
    parts = []
    if len(points) > 1:
        attempts = _newest_attempts(facts, others)
        metrics = {**_metrics(attempts), ANSWER: _answer_metric(facts)}
        small = "".join(_small(name, metrics.get(name, {}), points) for name in _names(attempts, points))
        parts.append(f'<p class="sub">{len(points)} attempts of {len({p.session for p in points})} sessions at '
                     f'the same task, in order of time.</p>{_key()}<div class="three">{small}</div>{_table(points)}')
    elif points:
        parts.append("<p>One attempt so far: the curve begins with the second attempt at the same exercise and hazard.</p>")
    if left_out:
        parts.append(f'<p class="sub">Left out: {esc("; ".join(f"{name} ({why})" for name, why in left_out.items()))}.</p>')
    return "".join(parts)


def _newest_attempts(facts, others):
    """Attempts of the given sessions at the same task: the reported one, then the newest first."""
    task = _task(facts.score)
    scores = [facts.score, *(load_score(directory)[0] for directory in reversed(others))]
    attempts = [attempt for score in scores if score and _task(score) == task for attempt in reversed(score["attempts"])]
    return ([facts.attempt] if facts.attempt else []) + attempts


def _metrics(attempts):
    """{name: metric} of the newest attempt. An attempt without a value has no limit: it is that of the newest with one."""
    found = {}
    for attempt in attempts:
        for name, metric in attempt["metrics"].items():
            if not isinstance(metric, dict):
                continue
            known = found.setdefault(name, metric)
            if not is_number(known.get("limit")) and is_number(metric.get("limit")):
                found[name] = {**known, "limit": metric["limit"], "better": metric.get("better")}
    return found


def _scored(attempts):
    """Names of the metrics that the exercise scores, as the newest attempt has them: those out of the band first."""
    for attempt in attempts:
        found = [(name, m) for name, m in attempt["metrics"].items() if isinstance(m, dict) and m.get("scored") is True]
        if found:
            found.sort(key=lambda entry: (entry[1].get("passed") is not False, -(entry[1].get("excess") or 0.0)))
            return [name for name, _ in found]
    return []


def _names(attempts, points):
    """All scored metrics that were measured, time and the answer to the hazard first, then those out of the band; where
    nothing is scored the usual ones."""
    names, usual = ([n for n in wanted if any(n in p.metrics for p in points)] for wanted in (_scored(attempts), USUAL))
    names = names or usual
    first = [name for name in FIRST if any(name in p.metrics for p in points)]
    return first + [name for name in names if name not in first]


def _key():
    entries = [("attempt passed", drawing.SOFT, "circle"), ("attempt not passed", drawing.SOFT, "cross"),
               ("not judged", drawing.SOFT, "square"), ("green: within the limit", drawing.GOOD, "area"),
               ("red: beyond it", drawing.BAD, "area"), ("what passes", "#d9dee4", "area")]
    return drawing.svg(1000, 24, drawing.legend(4, 16, entries, 12.5), "Legend", "key")


def _small(name, metric, points):
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
        parts.append(drawing.mark(panel.to_x(i), panel.to_y(value), SHAPES.get(point.passed, "square"),
                                  COLOURS.get(good, drawing.SOFT),
                                  f"{point.session}: {metric_words.figure(name, metric, value)}", 4.5))
    for i, point in enumerate(points, 1):  # that failed before there was anything to measure
        if point.passed is False and name not in point.metrics:
            parts.append(drawing.mark(panel.to_x(i), panel.y + panel.height, "cross", drawing.BAD,
                                      f"{point.session}: not passed, not measured", 4.5))
    parts.append(panel.x_axis("attempt", min(len(points), 6), 11, lambda v: f"{v:g}" if float(v).is_integer() else ""))
    return f"<figure>{drawing.svg(320, 190, ''.join(parts), f'{words(name)} over the attempts')}</figure>"


def _answer_metric(facts):
    within = (facts.score.get("response_rule") or {}).get("within_s")
    return {"unit": "s", "better": "lower", **({"limit": within} if is_number(within) else {})}


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
