"""report.json: what the page shows, for programs. Schema: doc/report.md."""

import json
import os

from raven2_report import curves, metric_words, scorecard, verdict
from raven2_report.facts import PHASES
from raven2_report.text import is_number

VERSION = 1


def _number(value):
    return value if is_number(value) and abs(value) != float("inf") else None


def _metric(name, metric, score):
    title, definition = metric_words.words_of(name).title, metric_words.meaning_of(name, score)
    return {"name": name, "title": title, "definition": definition, "unit": metric.get("unit"),
            "group": metric.get("group"), "better": metric.get("better"), "value": _number(metric.get("value")),
            "mean": _number(metric.get("mean")), "deviation": _number(metric.get("deviation")),
            "limit": _number(metric.get("limit")), "passed": metric.get("passed")}


def _hazard(facts, hazard):
    judged, fault = hazard["judged"], hazard["fault"]
    after, response = facts.reaction(hazard)
    return {"scenario": hazard["name"], "at_s": hazard["at_s"], "end_s": hazard["end_s"],
            "largest_error_mm": _number(fault.get("max_error_mm", judged.get("error_mm"))),
            "excursion_mm": _number(judged.get("excursion_mm")),
            "largest_force_N": _number(fault.get("max_force_N", judged.get("peak_force_N"))),
            "cue_after_s": judged["cue_after_ms"] / 1000.0 if is_number(judged.get("cue_after_ms")) else None,
            "reaction": response, "reaction_after_s": after, "verdict": judged.get("verdict")}


def _session(facts):
    return {"directory": facts.name, "start_time_utc": facts.meta.get("start_time_utc"), "duration_s": facts.duration,
            "exercise": facts.training["exercise"], "drill": facts.training["drill"],
            "trainee": facts.training["trainee"],
            "curriculum": facts.training["curriculum"], "hazard": facts.header["hazard"], "seed": facts.header["seed"],
            "motion": facts.header["motion"]}


def build(facts, others):
    """The record as a dict, without wall-clock values."""
    attempt = facts.attempt or {}
    points, left_out = curves.collect(facts, others)
    improve = verdict.improvements(facts)
    return {
        "version": VERSION, "session": _session(facts),
        "verdict": {"headline": verdict.headline(facts), "passed": attempt.get("passed"),
                    "reasons": verdict.reasons(facts) if attempt.get("passed") is False else [],
                    "attempt": attempt.get("number"),
                    "attempts": len(facts.attempts)},
        "summary": verdict.story(facts), "improve": improve, "no_advice": "" if improve else scorecard.no_advice(facts), "band": facts.score.get("band"),
        "metrics": [_metric(name, m, facts.score) for name, m in attempt.get("metrics", {}).items()
                    if isinstance(m, dict)],
        "not_judged": attempt.get("not_judged", []),
        "phases": [{"mode": mode, "name": PHASES.get(mode, (mode, ""))[0], "from_s": a, "to_s": b}
                   for a, b, mode in facts.phases],
        "steps": facts.steps,
        "mistakes": [{"at_s": e["at_s"], "kind": e["mistake"], "what": facts.mistake_text(e)}
                     for e in facts.mistakes()],
        "hazards": [_hazard(facts, h) for h in facts.hazards], "deviations": facts.deviations, "moments": facts.moments(),
        "curve": [{"session": p.session, "start_time_utc": p.start, "status": p.status, "passed": p.passed,
                   "metrics": p.metrics}
                  for p in points],
        "left_out": list(left_out),
    }


def write(facts, others, path):
    draft = path + ".part"
    with open(draft, "w", encoding="utf-8") as file:
        json.dump(build(facts, others), file, indent=1, ensure_ascii=False, allow_nan=False)
        file.write("\n")
    os.replace(draft, path)
