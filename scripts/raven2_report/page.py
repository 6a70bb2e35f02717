"""Puts the parts of the report together: one HTML file with its styles, drawings and pictures in it."""

from raven2_report import (curves, details, hazard_page, scene, scorecard, stills, timeline, verdict,
                           view3d)
from raven2_report.style import CSS
from raven2_report.text import esc, table, words

CAPTIONS = {
    "joint_1": ("Joint 1 of model and robot",
                "Shoulder of the gold arm. Where the curves part, the robot does not do what the surgeon asked for "
                "(compare Li et al. 2017, Figure 5)."),
    "haptic_force": ("Force on the surgeon's hands",
                     "Magnitude of the cue; it acts once the tips are further apart than the threshold (compare Li et "
                     "al. 2017, Figure 6)."),
    "tip_error": ("Distance of the tool tips", "Between nominal model and robot, while both follow the surgeon."),
}


def title(facts):
    exercise = facts.exercise.get("title") or words(facts.training["exercise"])
    return "Raven-II training session" if facts.training["exercise"] == "none" else str(exercise)


def _hazard(facts):
    """Names of the hazards that acted. If none did, the name of the armed one."""
    acted = list(dict.fromkeys(words(hazard["name"]) for hazard in facts.hazards))
    armed = words(facts.header["hazard"])
    return ", ".join(acted) or (armed if armed == "none" else f"{armed} (did not act)")


def subtitle(facts):
    training, header = facts.training, facts.header
    started = facts.meta.get("start_time_utc", "")
    parts = [f"trainee {training['trainee']}" if training["trainee"] else "",
             f"exercise {words(training['exercise'])}" if training["exercise"] != "none" else "",
             f"drill {words(training['drill'])}" if training["drill"] != "none" else "",
             f"curriculum {words(training['curriculum'])}" if training["curriculum"] != "none" else "",
             f"session {facts.name}", f"started {started}" if started else "", f"hazard {_hazard(facts)}",
             f"seed {header['seed']}", f"{facts.duration:.1f} s", 
             f"motion {header['motion']}" if header["motion"] else ""]
    return " · ".join(esc(part) for part in parts if part)


def engineering(facts):
    """Folded away on a screen, open in print."""
    import raven2_figures  # slow to load

    behind, series = details.Details(facts), facts.series

    def picture(name):
        heading, caption = CAPTIONS[name]
        svg = details.inline_svg(raven2_figures.FIGURES[name](series), name)
        return f"<h2>{heading}</h2><figure>{svg}<figcaption>{caption}</figcaption></figure>"

    timing = raven2_figures.timing_figure(series)
    histogram = f"<figure>{details.inline_svg(timing, 'timing')}</figure>" if timing is not None else ""
    figures = "".join(picture(name) for name in CAPTIONS) if len(series.t) else ""
    return (f"{behind.cards()}<h2>Faults</h2>{behind.fault_table()}{figures}<h2>Motion</h2>{behind.motion_table()}"
            f"<h2>Plans</h2>{behind.plan_section()}"
            f"{behind.execution_section()}<h2>Packets</h2>{behind.packet_table()}"
            f"<h2>Timing</h2>{behind.timing_table()}{histogram}"
            f"<h2>Where this comes from</h2>{behind.provenance()}")


def numbers(facts):
    rows = scorecard.all_metrics(facts)
    parts = []
    if len(facts.attempts) > 1:
        titles = ["Attempt", "Began", "Length", "Exercise", "Mistakes", "Verdict"]
        parts.append("<h3>Attempts of this session</h3>" + table(titles, scorecard.attempts_table(facts), {0, 1, 2}))
    if rows:
        parts.append("<h3>All metrics of this attempt</h3>" + table(
            ["", "Metric", "Value", "Expert, mean ± deviation", "Limit", "Verdict"], rows, {2, 3, 4}))
        band = facts.score.get("band") or {}
        if band:
            parts.append(f'<p class="sub">Expert: {esc(band.get("origin", "unknown"))}. How each is computed, and what '
                         'passes: '
                         "doc/scores.md.</p>")
    elif facts.training["exercise"] != "none":
        parts.append("<p>There is no score yet: <code>score_session DIR</code> writes it.</p>")
    return "".join(parts)


def page(facts, others, path):
    """The whole report. `others`: directories of further sessions; `path`: of the page."""
    shapes = scene.load_scene(facts.configuration.file("urdf", f"{_scene_file(facts)}"))
    bases = scene.arm_bases(facts.configuration.file("urdf", "raven2.urdf"))
    sections = [
        ("timeline", "Timeline", timeline.section(facts)),
        ("paths", "Paths of the tools", view3d.section(facts, shapes, bases)),
        ("hazards", "Hazards", hazard_page.section(facts)),
        ("pictures", "Pictures", stills.section(facts, path)),
        ("numbers", "Numbers", numbers(facts)),
        ("curve", "Learning curve", curves.section(facts, others)),
    ]
    sections = [entry for entry in sections if entry[2]]
    links = "".join(f'<a href="#{ident}">{heading}</a>' for ident, heading, _ in sections)
    body = "".join(f'<section id="{ident}"><h2>{heading}</h2>{content}</section>'
                   for ident, heading, content in sections)
    heading = title(facts)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{esc(heading)}: session {esc(facts.name)}</title><style>{CSS}</style></head><body><main>
<header><h1>{esc(heading)}</h1><p class="sub">{subtitle(facts)}</p></header>
{details.Details(facts).notices()}{scorecard.first_screen(facts)}<p class="summary">{esc(verdict.story(facts))}</p>
<nav>{links}<a href="#engineering">For engineers</a></nav>{body}
<details id="engineering" open><summary>For engineers</summary>{engineering(facts)}</details>
<footer>Written by session_report of raven2_trainer from session.rlog, score.json, metrics.json and meta.json.
Comparison: X. Li, H. Alemzadeh, D. Chen, Z. Kalbarczyk, R. K. Iyer, T. Kesavadas, “Surgeon Training in Telerobotic
Surgery via a Hardware-in-the-Loop Simulator”, 2017. A training aid, not a medical device.</footer>
</main><script>{view3d.SCRIPT}</script></body></html>
"""


def _scene_file(facts):
    """Name of the scene's URDF: the exercise's, else the one that meta.json names."""
    import os

    named = facts.scene.get("urdf") or (facts.meta.get("scene_urdf") or {}).get("path", "") or "frs_trainer.urdf"
    return os.path.basename(str(named))
