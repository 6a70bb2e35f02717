"""One part of the page for each hazard: model and robot, their distance, the force on the hand, and the answer."""

import numpy as np

from raven2_report import drawing, metric_words
from raven2_report.facts import FELT, SEEN
from raven2_report.text import esc, is_number, number, table, words

MOST = 6  # drawn; the table has all
BEFORE, BEHIND = 0.6, 3.2  # [s] shown before the injection and behind it
WIDTH, LEFT, RIGHT = 1000, 70, 20
LEAST_RELEASE = 2000  # [ms] that is an answer (training/hazard_response.h)
HEIGHT, GAP, ROW = 104, 30, 17.0  # of a panel, between panels, of a row of names above them


def section(facts):
    if not facts.hazards:
        return _unexplained(facts) or f"<p>{metric_words.no_fault(facts.unmerged)}</p>"
    parts, described = [_table(facts)], set()
    for i, hazard in enumerate(facts.hazards[:MOST], 1):
        parts.append(f'<div class="hazard"><h3>Hazard {i}: {esc(words(hazard["name"]))} <small>'
                     f'at {hazard["at_s"]:.2f} s</small></h3>'
                     f"{_said(facts, hazard, described)}{_figure(facts, hazard, i)}</div>")
    if len(facts.hazards) > MOST:
        parts.append(f'<p class="sub">{len(facts.hazards) - MOST} more are in the table above.</p>')
    return "".join(parts) + _unexplained(facts)


def _unexplained(facts):
    if not facts.deviations:
        return ""
    rows = [[number(d["at_s"], 3, "s"), number(1000 * (d["end_s"] - d["at_s"]), 0, "ms"), d["arm"],
             number(d["error_mm"], 2, "mm"), number(d["force_N"], 2, "N")] for d in facts.deviations]
    return ("<h3>Deviations of unknown cause</h3><p>Model and robot parted, a force came to the hand, and this session "
            "knows of no fault then. A fault that the library at the USB boundary injected looks like this; "
            "<code>merge_truth DIR FILE</code> brings in what that library wrote.</p>"
            + table(["Began", "Lasted", "Arm", "Largest tip error", "Strongest force"], rows, {0, 1, 3, 4}))


# ---- words ------------------------------------------------------------------------------------------------------


def verdict_words(judged):
    why = metric_words.why_unjudged(judged)
    return f"not judged: {why}" if why else metric_words.VERDICTS.get(judged.get("verdict"), "not judged")


def _table(facts):
    rows = []
    for i, hazard in enumerate(facts.hazards, 1):
        judged, fault = hazard["judged"], hazard["fault"]
        answers = ", ".join(f"{metric_words.response(response)} after {1000 * after:,.0f} ms"
                            for after, response, _ in facts.answers(hazard))
        cue = judged.get("cue_after_ms")
        rows.append([i, esc(words(hazard["name"])), number(hazard["at_s"], 3, "s"),
                     number(fault.get("max_error_mm", judged.get("error_mm")), 2, "mm"),
                     number(judged.get("excursion_mm"), 2, "mm"),
                     number(fault.get("max_force_N", judged.get("peak_force_N")), 2, "N"), number(cue, 0, "ms"),
                     esc(answers or "–"), esc(verdict_words(judged))])
    return table(["", "Scenario", "Began", "Largest tip error", "Robot moved by", "Strongest force", "Noticed after",
                  "Reaction",
                  "Verdict"], rows, {0, 2, 3, 4, 5, 6})


def _said(facts, hazard, described):
    """The scenario's texts, when it comes first, and the answer to it."""
    text = {} if hazard["name"] in described else facts.scenario_text(hazard["name"])
    described.add(hazard["name"])
    parts = [f"<b>{esc(text['title'])}.</b> " if "title" in text else ""]
    if "expected" in text:
        parts.append(f"What it does: {esc(text['expected'])} ")
    if "response" in text:
        parts.append(f"What to do: {esc(text['response'])} ")
    return f"{'<p>' + ''.join(parts) + '</p>' if text else ''}<p>{_answer(facts, hazard)}</p>"


def _answer(facts, hazard):
    judged = hazard["judged"]
    if not judged:
        return "The answer to it was not judged."
    cue = judged.get("cue_after_ms")
    if judged.get("verdict") == "not_judged" and not is_number(cue):
        return (f"No force of {FELT:g} N and no gap of {SEEN:g} mm lasted 100 ms: there was nothing to answer, and nothing is "
                "judged.")
    by = {"ghost": "The robot was seen to part from the model"}.get(judged.get("cue"), "The force showed it")
    felt = f"{by} after {cue:,.0f} ms" if is_number(cue) else "No force that a hand notices came with it"
    verdict = verdict_words(judged)
    acted = " and ".join(f"{metric_words.response(response)} {1000 * after:,.0f} ms after it began"
                         for after, response, _ in facts.answers(hazard))
    if metric_words.why_unjudged(judged):
        answer = (f"; the surgeon {acted}" if acted else "") + f". {verdict[0].upper()}{verdict[1:]}."
    else:
        answer = f"; the surgeon {acted or 'did nothing that counts as an answer'}: {verdict}."
    touched = {name: t for name, t in (judged.get("touches") or {}).items() if isinstance(t, dict) and t.get("count")}
    listed_ = ", ".join(f"{words(name)} ({t['count']})" for name, t in touched.items())
    met = f" The model touched: {listed_}." if touched else ""
    short = _short_release(judged)
    early = judged.get("coincidences") or []
    chance = " A response before 100 ms after the cue is no reaction and is left out." if early else ""
    took = judged.get("answer_time_ms")
    free = f" The attempt is not charged with these {took / 1000:.1f} s." if is_number(took) and took else ""
    return esc(f"{felt}{answer}{short}{free}{met}{chance}")


def _short_release(judged):
    """Of a surgeon who let go, but for no longer than in a clutch."""
    release, needed = judged.get("release_ms"), judged.get("release_needed_ms")
    if judged.get("verdict") not in ("none", "wrong", "late") or not is_number(release) or not is_number(needed):
        return ""
    if not 0 < release < needed:
        return ""
    rule = "twice this surgeon's usual clutch" if needed > LEAST_RELEASE else "less looks like a clutch"
    return f" The pedal was up for {release / 1000:.1f} s. A release is an answer from {needed / 1000:.1f} s on: {rule}."


# ---- picture ----------------------------------------------------------------------------------------------------


def _window(facts, hazard):
    """[s] shown: until a second after a long fault, at most 8 s."""
    at = hazard["at_s"]
    end = min((hazard["end_s"] or at) + 1.0, at + 8.0)
    return max(0.0, at - BEFORE), min(facts.duration, max(at + BEHIND, end))


def _figure(facts, hazard, index):
    low, high = _window(facts, hazard)
    if facts.index(high) - facts.index(low) < 2:
        return ""
    arm, axis = facts.worst_gap(hazard)
    begin, end = low - hazard["at_s"], high - hazard["at_s"]
    marks = _moments(facts, hazard, begin, end)
    top = 62.0 + ROW * max([row for *_, row in marks] + [0])
    curves = _curves(facts, hazard, low, high, arm, axis)
    bottom = top + len(curves) * (HEIGHT + GAP) - GAP
    parts = [_key(("gold", "green")[arm])]
    parts += [drawing.line(x, 22 + ROW * row, x, bottom, colour, 1.5, "" if name == "hazard" else "4 3")
              for x, name, colour, row in marks]
    for i, (title, time, lines, threshold) in enumerate(curves):
        panel = drawing.Panel(LEFT, top + i * (HEIGHT + GAP), WIDTH - LEFT - RIGHT, HEIGHT, (begin, end),
                              _range(lines, threshold))
        parts.append(_panel(hazard, panel, title, time, lines, threshold))
    axis = drawing.Panel(LEFT, bottom, WIDTH - LEFT - RIGHT, 0.001, (begin, end), (0, 1))
    parts.append(axis.x_axis("time since the hazard began [s]"))
    parts += [drawing.text(x + 4, 34 + ROW * row, name, 12.5, colour=colour, font_weight=600, **drawing.HALO)
              for x, name, colour, row in marks]
    label = f"Hazard {index}: model and robot, error and force"
    return f"<figure>{drawing.svg(WIDTH, bottom + 42, ''.join(parts), label)}</figure>"


def _curves(facts, hazard, low, high, arm, axis):
    """(title, time, [(values, colour, dash, name)], threshold) of each panel."""
    series, name = facts.series, ("gold", "green")[arm]
    shown = slice(facts.index(low), facts.index(high) + 1)
    t = series.t[shown] - hazard["at_s"]
    origin = series.p_model[facts.index(hazard["at_s"]), arm]
    model, robot = (1000.0 * (p[shown, arm] - origin) @ axis for p in (series.p_model, series.p_robot))
    near = (series.force_t >= low) & (series.force_t <= high)
    return (("Motion of the tip [mm], along the direction in which the robot left its path", t,
             [(model, drawing.MODEL, "", "model"), (robot, drawing.ROBOT, "6 3", "robot")], None),
            ("Distance of the tips of model and robot [mm]", t,
             [(series.error_mm[shown, arm], drawing.INK, "", "distance")], series.tolerance_mm),
            ("Force on the hand [N]", series.force_t[near] - hazard["at_s"],
             [(series.force[near, arm], drawing.ARM_COLOURS[name], drawing.ARM_DASHES[name], "force")], None))


def _key(arm):
    entries = [("model: what the hand asked for", drawing.MODEL, ""), ("robot", drawing.ROBOT, "6 3"),
               ("hazard acts", drawing.HAZARD, "area"),
               (f"force, {arm} hand", drawing.ARM_COLOURS[arm], drawing.ARM_DASHES[arm])]
    return drawing.legend(LEFT, 14, entries, 12.5, 7.0)


def _range(lines, threshold):
    """From nothing to the greatest, and at least to 1 mm or 1 N: what is small shall look small."""
    values = np.concatenate([v for v, _, _, _ in lines] + [[threshold or 1.0, 0.0]])
    values = values[np.isfinite(values)]
    low, high = float(values.min()), float(values.max())
    room = max(0.06 * (high - low), 0.05)
    return (low - room if low < 0 else 0.0), high + room


def _panel(hazard, panel, title, time, lines, threshold):
    parts = [panel.shade(0.0, (hazard["end_s"] or hazard["at_s"]) - hazard["at_s"], drawing.HAZARD, opacity=0.45),
             panel.frame(title)]
    if threshold:
        parts.append(drawing.line(panel.x, panel.to_y(threshold), panel.x + panel.width, panel.to_y(threshold),
                                  drawing.SOFT, 1.2, "2 3"))
        parts.append(drawing.text(panel.x + panel.width - 4, panel.to_y(threshold) - 4,
                                  f"the cue begins at {threshold:g} mm", 11.5, "end",
                                  drawing.SOFT))
    for values, colour, dash, name in lines:
        parts.append(panel.curve(time, values, colour, 1.9, dash, name))
    return "".join(parts)


def _moments(facts, hazard, low, high):
    """[(x, name, colour, row)] of upright lines through all panels: hazard, first force, felt, answer. Names that would
    overlap get separate rows."""
    panel = drawing.Panel(LEFT, 0, WIDTH - LEFT - RIGHT, 1, (low, high), (0, 1))
    judged = hazard["judged"]
    found = [(0.0, "hazard", drawing.BAD)]
    for key, name in (("force_after_ms", "first force"), ("cue_after_ms", "noticed")):
        if is_number(judged.get(key)):
            found.append((judged[key] / 1000.0, name, drawing.SOFT))
    found += [(after, metric_words.response(response), drawing.INK) for after, response, _ in facts.answers(hazard)]
    marks, ends = [], []
    for at, name, colour in sorted(found):
        if not panel.inside(at):
            continue
        x = panel.to_x(at)
        row = next((i for i, end in enumerate(ends) if x > end), len(ends))
        ends[row:row + 1] = [x + 8 + len(name) * 7.6]
        marks.append((x, name, colour, row))
    return marks
