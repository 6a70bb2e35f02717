"""Puts the parts of the report together: one HTML file with its styles, drawings and pictures in it."""

from raven2_report import (curves, details, hazard_page, scene, scorecard, stills, timeline, verdict,
                           view3d)
from raven2_report.text import esc, table, words

CSS = """
:root { --ink: #1f2933; --soft: #56616c; --line: #d5dae0; --panel: #f6f7f9; --accent: #1d4e89; --warn: #b45309;
  --good: #1b6e53; --bad: #a63603; }
* { box-sizing: border-box; }
html { -webkit-text-size-adjust: 100%; }
body { margin: 0; background: #e9edf1; color: var(--ink); font: 16px/1.5 "Segoe UI", "Helvetica Neue", "DejaVu Sans", Arial,
  sans-serif; }
main { max-width: 1180px; margin: 24px auto; background: #fff; padding: 32px 44px 40px; border-radius: 6px;
  box-shadow: 0 1px 4px rgba(20, 30, 40, .12); }
header { border-bottom: 3px solid var(--accent); padding-bottom: 10px; }
h1 { margin: 0; font-size: 25px; letter-spacing: -.2px; overflow-wrap: anywhere; }
h2 { margin: 34px 0 8px; font-size: 20px; color: var(--accent); }
h3 { margin: 22px 0 6px; font-size: 16px; }
h3 small { font-weight: 400; color: var(--soft); font-size: 13.5px; margin-left: 6px; }
p { margin: 6px 0; max-width: 95ch; overflow-wrap: anywhere; }
.sub { color: var(--soft); font-size: 14px; overflow-wrap: anywhere; }
nav { margin: 10px 0 0; font-size: 14px; }
nav a { margin-right: 16px; white-space: nowrap; }
a { color: var(--accent); }
.banner { display: flex; gap: 20px; align-items: flex-start; margin: 20px 0 0; padding: 18px 22px; border-radius: 6px;
  border: 2px solid var(--soft); background: var(--panel); }
.banner.passed { border-color: var(--good); background: #edf6f2; }
.banner.failed { border-color: var(--bad); background: #fdf3ee; }
.sign { font-size: 34px; line-height: 1.2; font-weight: 700; width: 1.3em; text-align: center; flex: none; }
.passed .sign { color: var(--good); } .failed .sign { color: var(--bad); }
.headline { font-size: 24px; line-height: 1.3; font-weight: 650; margin: 0 0 4px; max-width: none; }
.banner ul { margin: 2px 0 0; padding-left: 20px; columns: 2; column-gap: 32px; font-size: 14.5px; }
.banner li { break-inside: avoid; }
ol.improve { margin: 8px 0 0; padding: 0; list-style: none; counter-reset: n; display: grid; gap: 10px;
  grid-template-columns: repeat(auto-fit, minmax(250px, 1fr)); }
ol.improve li { counter-increment: n; background: var(--panel); border-left: 4px solid var(--accent); padding: 10px 14px; }
ol.improve b { display: block; } ol.improve b::before { content: counter(n) ". "; }
ol.improve span { font-size: 14.5px; color: var(--soft); }
.bandkey svg { width: min(640px, 100%); height: auto; display: block; }
.columns { columns: 2; column-gap: 36px; } .bands { margin: 0 0 10px; } .bands h3 { margin: 8px 0 2px; break-after: avoid; }
.bands h3 small { display: block; margin: 0; }
.band { display: grid; grid-template-columns: minmax(0, 1fr) auto minmax(0, 170px) 100px; gap: 0 12px; align-items: center;
  padding: 5px 0 6px; border-bottom: 1px solid var(--line); break-inside: avoid; }
.band small { grid-column: 1 / -1; color: var(--soft); font-size: 12.5px; line-height: 1.3; }
.band .value { font-size: 17px; font-weight: 600; text-align: right; white-space: nowrap; font-variant-numeric: tabular-nums; }
.band svg { width: 100%; height: auto; display: block; }
.band .mark b { font-size: 14px; white-space: nowrap; } .good .mark b { color: var(--good); } .bad .mark b { color: var(--bad); }
.bad .value { color: var(--bad); }
.notice { border-left: 4px solid var(--warn); background: #fdf6ec; padding: 8px 14px; margin: 14px 0; }
.cards { display: grid; grid-template-columns: repeat(4, 1fr); gap: 12px; margin: 16px 0 8px; }
.card { background: var(--panel); border: 1px solid var(--line); border-radius: 5px; padding: 12px 14px; min-width: 0; }
.card b { display: block; font-size: 20px; font-weight: 600; }
.card span { color: var(--soft); font-size: 12.5px; }
.card small { display: block; color: var(--soft); font-size: 12px; line-height: 1.35; margin-top: 2px; }
.wide { overflow-x: auto; max-width: 100%; }
table { border-collapse: collapse; width: 100%; font-size: 13.5px; }
th { text-align: left; font-weight: 600; color: var(--soft); border-bottom: 2px solid var(--line); padding: 5px 9px;
  vertical-align: bottom; }
td { border-bottom: 1px solid var(--line); padding: 5px 9px; vertical-align: top; }
td small { color: var(--soft); }
td.v { white-space: nowrap; } .n { text-align: right; font-variant-numeric: tabular-nums; white-space: nowrap; }
.two { display: grid; grid-template-columns: repeat(2, minmax(0, 1fr)); gap: 0 36px; }
.three { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: 8px 20px; }
.three figure { margin: 4px 0; }
figure { margin: 8px 0 14px; break-inside: avoid; }
figure svg { width: 100%; height: auto; display: block; }
svg.scene { background: #fbfcfd; border: 1px solid var(--line); border-radius: 4px; }
svg text { font-family: "Segoe UI", "Helvetica Neue", "DejaVu Sans", Arial, sans-serif; }
#turn:focus { outline: 2px solid var(--accent); }
figcaption { color: var(--soft); font-size: 13px; }
.hazard { border-top: 1px solid var(--line); margin-top: 18px; }
.frames { display: grid; grid-template-columns: repeat(4, minmax(0, 1fr)); gap: 12px; }
.frames figure { margin: 0; }
.frames img { width: 100%; border-radius: 4px; display: block; }
details { margin-top: 34px; } summary { cursor: pointer; font-size: 20px; font-weight: 700; color: var(--accent); }
details h2 { font-size: 17px; }
code { font: 12.5px "DejaVu Sans Mono", Consolas, monospace; overflow-wrap: anywhere; }
footer { margin-top: 34px; padding-top: 10px; border-top: 1px solid var(--line); color: var(--soft); font-size: 12.5px; }
@media screen and (max-width: 960px) { main { margin: 0; padding: 20px 22px; border-radius: 0; }
  .cards, .frames { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  .two { grid-template-columns: minmax(0, 1fr); } .three { grid-template-columns: repeat(2, minmax(0, 1fr)); }
  .columns { columns: 1; } .band { grid-template-columns: minmax(0, 1fr) auto minmax(0, 240px) 110px; } }
@media screen and (max-width: 560px) { .three, .frames, .cards { grid-template-columns: minmax(0, 1fr); }
  .banner { flex-direction: column; gap: 4px; } .banner ul { columns: 1; }
  .band { grid-template-columns: minmax(0, 1fr) auto; } }
@media print { @page { size: A4; margin: 12mm; } body { background: #fff; font-size: 11px; }
  main { box-shadow: none; margin: 0; padding: 0; max-width: none; }
  * { print-color-adjust: exact; -webkit-print-color-adjust: exact; }
  h1 { font-size: 19px; } h2 { break-after: avoid; margin-top: 16px; font-size: 15px; } h3 { break-after: avoid; font-size: 12.5px; }
  .headline { font-size: 18px; } .sub, figcaption { font-size: 10px; } .card b { font-size: 15px; } .band .value { font-size: 13px; }
  .band { padding: 3px 0; } .band small, .card small, .card span { font-size: 9.5px; } ol.improve span { font-size: 10.5px; }
  .card, tr, .frames figure, .hazard figure { break-inside: avoid; } table { font-size: 9.5px; } td, th { padding: 2px 5px; }
  ol.improve { grid-template-columns: repeat(3, 1fr); } nav, #turn-hint { display: none; } .wide { overflow: visible; } }
"""

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


def subtitle(facts):
    training, header = facts.training, facts.header
    started = facts.meta.get("start_time_utc", "")
    parts = [f"trainee {training['trainee']}" if training["trainee"] else "",
             f"exercise {words(training['exercise'])}" if training["exercise"] != "none" else "",
             f"drill {words(training['drill'])}" if training["drill"] != "none" else "",
             f"curriculum {words(training['curriculum'])}" if training["curriculum"] != "none" else "",
             f"session {facts.name}", f"started {started}" if started else "", f"hazard {words(header['hazard'])}",
             f"seed {header['seed']}", f"{facts.duration:.1f} s", f"motion {header['motion']}" if header["motion"] else ""]
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
    return (f"{behind.cards()}<h2>Faults</h2>{behind.fault_table()}{figures}<h2>Motion</h2>{behind.motion_table()}<h2>Plans</h2>{behind.plan_section()}"
            f"{behind.execution_section()}<h2>Packets</h2>{behind.packet_table()}<h2>Timing</h2>{behind.timing_table()}{histogram}"
            f"<h2>Where this comes from</h2>{behind.provenance()}")


def numbers(facts):
    rows = scorecard.all_metrics(facts)
    parts = []
    if len(facts.attempts) > 1:
        parts.append("<h3>Attempts of this session</h3>" + table(
            ["Attempt", "Began", "Length", "Exercise", "Mistakes", "Verdict"], scorecard.attempts_table(facts), {0, 1, 2}))
    if rows:
        parts.append("<h3>All metrics of this attempt</h3>" + table(
            ["", "Metric", "Value", "Expert, mean ± deviation", "Limit", "Verdict"], rows, {2, 3, 4}))
        band = facts.score.get("band") or {}
        if band:
            parts.append(f'<p class="sub">Expert: {esc(band.get("origin", "unknown"))}. How each is computed, and what passes: '
                         "doc/scores.md.</p>")
    elif facts.training["exercise"] != "none":
        parts.append("<p>There is no score yet: <code>score_session DIR</code> writes it.</p>")
    return "".join(parts)


def page(facts, others, path):
    """The whole report. `others`: directories of further sessions; `path`: where it will stand."""
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
    body = "".join(f'<section id="{ident}"><h2>{heading}</h2>{content}</section>' for ident, heading, content in sections)
    heading = title(facts)
    return f"""<!DOCTYPE html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{esc(heading)}: session {esc(facts.name)}</title><style>{CSS}</style></head><body><main>
<header><h1>{esc(heading)}</h1><p class="sub">{subtitle(facts)}</p></header>
{details.Details(facts).notices()}{scorecard.first_screen(facts)}<p class="summary">{esc(verdict.story(facts))}</p>
<nav>{links}<a href="#engineering">For engineers</a></nav>{body}
<details id="engineering" open><summary>For engineers</summary>{engineering(facts)}</details>
<footer>Written by session_report of raven2_trainer from session.rlog, score.json, metrics.json and meta.json. Comparison: X. Li,
H. Alemzadeh, D. Chen, Z. Kalbarczyk, R. K. Iyer, T. Kesavadas, “Surgeon Training in Telerobotic Surgery via a
Hardware-in-the-Loop Simulator”, 2017. A training aid, not a medical device.</footer>
</main><script>{view3d.SCRIPT}</script></body></html>
"""


def _scene_file(facts):
    """Name of the scene's URDF: the exercise's, else the one that meta.json names."""
    import os

    named = facts.scene.get("urdf") or (facts.meta.get("scene_urdf") or {}).get("path", "") or "frs_trainer.urdf"
    return os.path.basename(str(named))
