"""Passed or not, said in one line, and what to work on."""

from raven2_report import metric_words
from raven2_report.text import counted, is_number, listed, number, words

UNJUDGED = ("not_judged", "coincidence")


def metric_of(facts, name):
    found = (facts.attempt or {}).get("metrics", {}).get(name)
    return found if isinstance(found, dict) else {}


def failed_metrics(facts):
    """Names of the metrics out of their band, the farthest first."""
    metrics = (facts.attempt or {}).get("metrics", {})
    failed = [(m.get("excess") or 0.0, name) for name, m in metrics.items() if isinstance(m, dict)
              and m.get("passed") is False]
    return [name for _, name in sorted(failed, key=lambda entry: -entry[0])]


def badly_answered(facts):
    """The attempt's hazards that could be noticed and were not answered rightly and in time."""
    hazards = [h for h in (facts.attempt or {}).get("hazards", []) if isinstance(h, dict)]
    return [h for h in hazards if h.get("verdict") not in UNJUDGED + ("right",)]


def lacked_its_drill(facts):
    """A drill in which there was no hazard that could be noticed."""
    hazards = [h for h in (facts.attempt or {}).get("hazards", []) if isinstance(h, dict)]
    return facts.training["drill"] != "none" and all(h.get("verdict") in UNJUDGED for h in hazards)


def _any_right(hazards):
    return any(isinstance(h, dict) and h.get("verdict") == "right" for h in hazards)


def state(facts):
    """passed, failed or open (nobody judged it)."""
    passed = (facts.attempt or {}).get("passed")
    return {True: "passed", False: "failed"}.get(passed, "open")


def hazard_words(hazard):
    """`sudden jump answered wrongly (pushed on)`."""
    verdict = metric_words.VERDICTS.get(hazard.get("verdict"), words(hazard.get("verdict", "not judged")))
    answer = hazard.get("deciding") or hazard.get("reaction") or {}
    response = metric_words.RESPONSES.get(answer.get("response")) if isinstance(answer, dict) else None
    return f"{words(hazard.get('scenario', 'hazard'))} {verdict}" + (
        f" ({response})" if response and hazard.get("verdict") != "none" else "")


def reasons(facts):
    """Why it was not passed, the one that decides first."""
    attempt, found = facts.attempt or {}, []
    if attempt.get("status") == "failed":
        found.append(metric_words.FAILURES.get(attempt.get("failure"), words(attempt.get("failure", "failed"))))
    elif attempt.get("status") in ("running", "waiting"):
        total = sum(len(track) for track in facts.header.get("step_names", []))
        found.append(f"the exercise was not finished ({attempt.get('steps_done', 0)} of {total} steps done)"
                     if attempt["status"] == "running" else "the exercise was not begun")
    found += [hazard_words(h) for h in badly_answered(facts)[:1]]
    found += [metric_words.said(name, metric_of(facts, name)) for name in failed_metrics(facts)]
    return found


def _drill_words(facts):
    """Why nothing could be judged of a drill's hazard."""
    came = [h for h in (facts.attempt or {}).get("hazards", []) if isinstance(h, dict)]
    why = [metric_words.why_unjudged(h) for h in came]
    noticed = [reason for reason in why if reason and reason != metric_words.NOTHING_CAME]
    if noticed:
        return f"in the drill {noticed[0]}"
    return "the hazard of the drill " + ("gave nothing to feel or to see in time" if came else "did not come")


def headline(facts):
    """One line; the failing figure that weighs most is named in it."""
    kind = state(facts)
    if kind == "passed":
        judged = [m for m in facts.attempt["metrics"].values() if isinstance(m, dict) and m.get("passed") is True]
        return f"Passed: {counted(len(judged), 'metric')} within the expert's band" + (
            ", and the hazard answered rightly" if _any_right(facts.attempt.get("hazards", [])) else "")
    if kind == "failed":
        why = reasons(facts)
        more = f", and {counted(len(why) - 1, 'more reason')}" if len(why) > 1 else ""
        return f"Not passed: {why[0]}{more}" if why else "Not passed"
    if facts.training["exercise"] == "none":
        return "Free session: no exercise was set, so nothing is passed or failed"
    if facts.attempt is None:
        return "Not judged: this session has no score"
    if facts.attempt.get("status") == "done" and facts.score.get("band") and lacked_its_drill(facts):
        return f"Not judged: all else passed, but {_drill_words(facts)}"
    if facts.attempt.get("status") == "done":
        return "Not judged: the exercise was done, but there is no expert band for it"
    why = (reasons(facts) or ["the exercise was not finished"])[0]
    return f"Not judged: {why}, and there is no expert band for the exercise"


def improvements(facts):
    """At most three: {what, how, failed}."""
    return [entry for entry in (_improvement(facts, name) for name in (facts.attempt or {}).get("improve", [])[:3])
            if entry]


def _improvement(facts, name):
    if name == "hazard_response":
        bad = badly_answered(facts)
        rule = facts.score.get("response_rule") or {}
        right = listed([metric_words.ANSWERS.get(r, words(r)) for r in rule.get("right", [])], "or")
        within = rule.get("within_s")
        how = f"The right answer: {right}, within {number(within, 1, 's')} of the cue." if right else ""
        said = hazard_words(bad[0]) if bad else _drill_words(facts)
        return {"metric": name, "what": said[0].upper() + said[1:], "how": how, "failed": True}
    metric = metric_of(facts, name)
    if not metric:
        return None
    said = metric_words.said(name, metric)
    failed = metric.get("passed") is False
    near = "" if failed else " – passed, but near the limit"
    return {"metric": name, "what": said[0].upper() + said[1:] + near, "how": metric_words.words_of(name).advice,
            "failed": failed}


def story(facts):
    """The course of the session, for a reader who knows surgery and not this program."""
    faults = facts.faults
    parts = [f"A session of {number(facts.duration, 0, 's')}"]
    if not faults:
        count = len(facts.deviations)
        parts.append("without any known fault, in which the robot left its model "
                     f"{_times(count)} for an unknown cause" if count else
                     "without any known fault" if facts.unmerged else "without any injected fault")
    else:
        names = " and ".join(sorted({f"“{words(f['name'])}”" for f in faults}))
        parts.append(f"in which the hazard {names} acted {_times(len(faults))}")
    text = " ".join(parts)
    errors = [f["max_error_mm"] for f in faults if "max_error_mm" in f]
    if errors:
        text += f": the robot's tip left that of its model by up to {max(errors):.1f} mm{_warning(facts)}"
    text += "."
    if faults and facts.deviations:
        text += f" Apart from that, the robot left its model {_times(len(facts.deviations))} for an unknown cause."
    if facts.emergency_stop() is not None:
        text += f" The robot's emergency stop acted after {facts.emergency_stop():.1f} s."
    return text


def _times(count):
    return {1: "once", 2: "twice"}.get(count, f"{count} times")


def _largest_force(hazards):
    """`2.2 N`; empty if no force is known."""
    forces = [h["fault"].get("max_force_N", h["judged"].get("peak_force_N")) for h in hazards]
    known = [force for force in forces if is_number(force)]
    return f"{max(known):.1f} N" if known else ""


def _warning(facts):
    """Only the score knows whether a force lasted long enough to be a cue: without one the largest force alone."""
    judged = [h for h in facts.hazards if h["judged"]]
    if not judged:
        most = _largest_force(facts.hazards)
        return f", and the largest force on the hand was {most}" if most else ""
    felt = [h for h in judged if metric_words.is_felt(h["judged"])]
    if not felt:
        seen = any(h["judged"].get("cue") == "ghost" for h in judged)
        return ", and " + ("the picture warned the surgeon before any force" if seen else "no force warned the surgeon")
    if len(felt) == len(facts.hazards):
        cases = "" if len(felt) == 1 else "each time "
    else:
        cases = f"in {len(felt)} of {len(judged)} {'judged ' if len(judged) < len(facts.hazards) else ''}cases "
    most = _largest_force(felt)
    return f", and {cases}the surgeon was warned through the hand controller" + (f", with up to {most}" if most else "")
