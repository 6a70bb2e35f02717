"""The session from left to right: modes, steps, hazards and answers, mistakes, forces; all over one axis of time."""

import numpy as np

from raven2_report import drawing, metric_words
from raven2_report.facts import PHASES, arm_of_link
from raven2_report.text import words

WIDTH, LEFT, RIGHT = 1000, 116, 14
FILLS = {"work": "#3f77a8", "held": "#dfe3e8", "alone": "url(#hatch)", "stopped": "#2b323a", "camera": "url(#dots)"}
FAMILIES = (("work", "operating"), ("alone", "model alone"), ("camera", "camera"), ("held", "pedal up, waiting"),
            ("stopped", "stopped, paused"))
PATTERNS = ('<defs><pattern id="hatch" width="7" height="7" patternUnits="userSpaceOnUse" '
            'patternTransform="rotate(45)">'
            '<rect width="7" height="7" fill="#cfe0ee"/><rect width="3" height="7" fill="#8db4d3"/></pattern>'
            '<pattern id="dots" width="6" height="6" patternUnits="userSpaceOnUse"><rect width="6" height="6" '
            'fill="#f3ead8"/>'
            '<circle cx="3" cy="3" r="1.6" fill="#8a6d2f"/></pattern></defs>')


def shown_until(facts):
    """[s] A session that ends with nothing going on for long is not shown to its end."""
    last = max([facts.phases[-1][0], facts.attempt_span()[1] if facts.attempt else 0.0]
               + [event["at_s"] for event in facts.events] + [h["end_s"] or h["at_s"] for h in facts.hazards])
    idle = PHASES.get(facts.phases[-1][2], ("", "held"))[1] in ("held", "stopped")
    return min(facts.duration, 1.15 * last + 2.0) if idle and facts.duration > 1.5 * last + 4.0 else facts.duration


class Lanes:
    """Stacks lanes from the top; every lane has its name on the left."""

    def __init__(self, until):
        self.range, self.y, self.parts = (0.0, max(until, 0.1)), 6.0, []

    def lane(self, name, height):
        panel = drawing.Panel(LEFT, self.y, WIDTH - LEFT - RIGHT, height, self.range, (0, 1))
        self.parts.append(drawing.text(LEFT - 10, self.y + height / 2 + 5, name, 13, "end", drawing.INK))
        self.y += height + 9
        return panel

    def plot(self, name, unit, height, high):
        panel = drawing.Panel(LEFT, self.y + 4, WIDTH - LEFT - RIGHT, height, self.range, (0.0, max(high, 1e-6)))
        self.parts.append(drawing.text(8, self.y + 14, name, 13))
        self.parts.append(drawing.text(8, self.y + 30, f"[{unit}]", 12, colour=drawing.SOFT))
        self.parts.append(panel.frame())
        self.y += height + 16
        return panel


def _fitting(words_, width, size=12):
    return words_ if len(words_) * size * 0.56 < width - 6 else ""


def _block(panel, first, last, fill, label, title, ink=drawing.INK):
    x, end = panel.to_x(first), panel.to_x(min(last, panel.x_range[1]))
    parts = drawing.rect(x, panel.y, max(end - x, 1.0), panel.height, fill, title, stroke="#fff", stroke_width=0.8)
    shown = _fitting(label, end - x)
    if shown:
        plate = drawing.rect((x + end) / 2 - len(shown) * 3.5, panel.y + panel.height / 2 - 8, len(shown) * 7.0, 16,
                             "#fff",
                             rx=2, fill_opacity=0.75) if fill.startswith("url") else ""
        parts += plate + drawing.text((x + end) / 2, panel.y + panel.height / 2 + 4.5, shown, 12, "middle", ink,
                                      pointer_events="none")
    return parts


def section(facts):
    if not facts.phases:
        return ""
    until = shown_until(facts)
    lanes = Lanes(until)
    _modes(facts, lanes)
    _steps(facts, lanes)
    _hazards(facts, lanes)
    _deviations(facts, lanes)
    _mistakes(facts, lanes)
    _forces(facts, lanes)
    axis = drawing.Panel(LEFT, lanes.y - 8, WIDTH - LEFT - RIGHT, 0.001, lanes.range, (0, 1))
    body = PATTERNS + "".join(lanes.parts) + axis.x_axis("time since the first pedal down [s]")
    picture = drawing.svg(WIDTH, lanes.y + 32, body, "Timeline of the session: modes, steps, hazards, mistakes and "
                                                     "forces", "timeline")
    left = f"Nothing more happened until {facts.duration:.0f} s." if until < facts.duration else ""
    return f"<figure>{_key(facts)}{picture}<figcaption>{left}</figcaption></figure>"


def _key(facts):
    shown = {PHASES.get(mode, ("", "held"))[1] for _, _, mode in facts.phases}
    entries = [(name, FILLS[family], "area") for family, name in FAMILIES if family in shown]
    if facts.hazards:
        entries += [("hazard acts", drawing.HAZARD, "area"), ("answer", drawing.GOOD, "triangle"),
                    ("first reaction", drawing.SOFT, "triangle")]
    if facts.mistakes():
        entries.append(("mistake", drawing.BAD, "cross"))
    entries += [(f"{arm} arm", drawing.ARM_COLOURS[arm], drawing.ARM_DASHES[arm]) for arm in ("gold", "green")]
    return drawing.svg(WIDTH, 24, drawing.legend(4, 16, entries, 12.5, 7.0), "Legend", "key")


def _modes(facts, lanes):
    panel = lanes.lane("Mode", 26)
    for first, last, mode in facts.phases:
        if first >= panel.x_range[1]:
            break
        label, family = PHASES.get(mode, (words(mode), "held"))
        ink = "#fff" if family in ("work", "stopped") else drawing.INK
        lanes.parts.append(_block(panel, first, last, FILLS[family], label, f"{label}: {first:.2f} s to {last:.2f} s",
                                  ink))


def _steps(facts, lanes):
    if not facts.steps:
        return
    panel = lanes.lane("Steps", 26)
    for i, step in enumerate(facts.steps):
        label = words(step["name"])
        unfinished = step["name"] == "not finished"
        fill = "#fff" if unfinished else ("#e9eef3", "#d3dde6")[i % 2]
        title = f"{label}: {step['from_s']:.2f} s to {step['to_s']:.2f} s"
        lanes.parts.append(_block(panel, step["from_s"], step["to_s"], fill, label, title))
        if not unfinished:
            lanes.parts.append(drawing.line(panel.to_x(step["to_s"]), panel.y, panel.to_x(step["to_s"]),
                                            panel.y + panel.height, drawing.INK, 2))


def _hazards(facts, lanes):
    if not facts.hazards:
        return
    panel = lanes.lane("Hazards", 32)
    parts = lanes.parts
    parts.append(drawing.rect(panel.x, panel.y, panel.width, panel.height, drawing.PANEL))
    for number, hazard in enumerate(facts.hazards, 1):
        end = hazard["end_s"] if hazard["end_s"] is not None else hazard["at_s"] + 0.3
        title = f"{words(hazard['name'])}: {hazard['at_s']:.3f} s to {end:.3f} s"
        lanes.parts.append(panel.shade(hazard["at_s"], end, drawing.HAZARD, title, stroke=drawing.BAD,
                                       stroke_width=0.8))
        x, long = panel.to_x(hazard["at_s"]), f"{number} {words(hazard['name'])}"
        for after, response, decides in facts.answers(hazard):
            said = metric_words.response(response)
            right = hazard["judged"].get("verdict") == "right"
            colour = drawing.SOFT if not decides else drawing.GOOD if right else drawing.BAD
            title = f"{said}, {1000 * after:.0f} ms after the hazard began"
            parts.append(drawing.mark(panel.to_x(hazard["at_s"] + after), panel.y + 9, "triangle", colour, title))
            long += f": {said} after {after:.2f} s"
        following = facts.hazards[number]["at_s"] if number < len(facts.hazards) else lanes.range[1]
        start = max(x, panel.to_x(end)) + 5
        room = min(panel.to_x(following), panel.x + panel.width) - start
        short = f"{number} {words(hazard['name'])}"
        last = short + long[long.rfind(":"):] if ":" in long else short
        label = next((entry for entry in (long, last, short, str(number)) if len(entry) * 6.6 < room), "")
        lanes.parts.append(drawing.text(start, panel.y + 27, label, 12))


def _deviations(facts, lanes):
    if not facts.deviations:
        return
    panel = lanes.lane("Unknown cause", 22)
    lanes.parts.append(drawing.rect(panel.x, panel.y, panel.width, panel.height, drawing.PANEL))
    for found in facts.deviations:
        title = (f"{found['arm']} arm, cause unknown: {found['at_s']:.3f} s to {found['end_s']:.3f} s, "
                 f"{found['error_mm']:.1f} mm, {found['force_N']:.1f} N")
        lanes.parts.append(panel.shade(found["at_s"], found["end_s"], drawing.SOFT, title))


def _mistakes(facts, lanes):
    mistakes = facts.mistakes()
    if not facts.exercise and not mistakes:
        return
    panel = lanes.lane("Mistakes", 22)
    lanes.parts.append(drawing.rect(panel.x, panel.y, panel.width, panel.height, drawing.PANEL))
    if not mistakes:
        lanes.parts.append(drawing.text(panel.x + 8, panel.y + 16, "none", 12, colour=drawing.SOFT))
    last = -1e9
    for event in mistakes[:400]:
        x = panel.to_x(event["at_s"])
        lanes.parts.append(drawing.mark(x, panel.y + 11, "cross", drawing.BAD,
                                        f"{facts.mistake_text(event)}, {event['at_s']:.2f} s", 5))
        label = metric_words.MISTAKES.get(event["mistake"], words(event["mistake"]))
        if x - last > len(label) * 7 + 24 and x + len(label) * 7 < panel.x + panel.width:
            lanes.parts.append(drawing.text(x + 9, panel.y + 15.5, label, 12))
            last = x


def _peak(values):
    return float(np.nanmax(values)) if len(values) and np.isfinite(values).any() else 0.0


def _forces(facts, lanes):
    series = facts.series
    curves = [("Tip error", "mm", series.t, series.error_mm, series.tolerance_mm),
              ("Hand force", "N", series.force_t, series.force, None)]
    pressed = contact_force(facts)
    if pressed is not None:
        curves.append(("Tool force", "N", series.t, pressed, None))
    for name, unit, t, values, threshold in curves:
        peak = max(_peak(values), threshold or 0.0)
        panel = lanes.plot(name, unit, 62, peak * 1.1 if peak > 0 else 1.0)
        for hazard in facts.hazards:
            lanes.parts.append(panel.shade(hazard["at_s"], hazard["end_s"] or hazard["at_s"], drawing.HAZARD,
                                           opacity=0.45))
        if threshold:
            lanes.parts.append(drawing.line(panel.x, panel.to_y(threshold), panel.x + panel.width,
                                            panel.to_y(threshold),
                                            drawing.SOFT, 1.1, "2 3"))
        for i, arm in enumerate(("gold", "green")):
            lanes.parts.append(panel.curve(t, values[:, i], drawing.ARM_COLOURS[arm], 1.5, drawing.ARM_DASHES[arm],
                                           f"{arm} arm"))


def contact_force(facts):
    """[N] (ticks, arms) of the tools on what is fixed and on each other; None where the log has no contacts."""
    contacts = facts.log.contacts
    if contacts is None or not len(facts.series.t):
        return None
    arms = np.array([arm_of_link(name) for name in facts.header.get("body_names", [])] or [-1])
    free = set(_free_bodies(facts))
    loose = np.array([name in free for name in facts.header.get("body_names", [])] or [False])
    force = np.zeros((len(facts.series.t), 2))
    if not len(contacts):
        return force
    a, b = contacts["a"].astype(int), contacts["b"].astype(int)
    known = (a < len(arms)) & (b < len(arms))
    a, b, contacts = a[known], b[known], contacts[known]
    ticks = facts.series.ticks["model"]["tick"]
    index = np.searchsorted(ticks, contacts["tick"]).clip(0, len(ticks) - 1)
    counts = (ticks[index] == contacts["tick"]) & (arms[a] != arms[b]) & ~loose[a] & ~loose[b]
    strength = np.linalg.norm(contacts["f_W"], axis=1)
    for arm in (0, 1):
        chosen = counts & ((arms[a] == arm) | (arms[b] == arm))
        np.add.at(force[:, arm], index[chosen], strength[chosen])
    return force


def _free_bodies(facts):
    objects = facts.scene.get("objects")
    named = [o.get("link") for o in objects.values() if isinstance(o, dict)] if isinstance(objects, dict) else []
    return named + list(facts.header.get("object_names", []))
