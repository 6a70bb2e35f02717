"""The first screen: passed or not, what to improve, and each judged metric with the expert's band."""

from raven2_report import drawing, metric_words, verdict
from raven2_report.text import clock, esc, is_number, number, words

SIGNS = {"passed": "✓", "failed": "✕", "open": "–"}


def first_screen(facts):
    return _banner(facts) + _improvements(facts) + _bands(facts)


def _banner(facts):
    kind = verdict.state(facts)
    listed = {entry["what"].lower() for entry in verdict.improvements(facts)}  # the list below has them
    why = [r for r in verdict.reasons(facts)[1:] if r.lower() not in listed] if kind == "failed" else []
    more = "".join(f"<li>{esc(reason)}</li>" for reason in why[:6])
    also = f"<p>Also outside what was asked for:</p><ul>{more}</ul>" if more else ""
    return (f'<section class="banner {kind}"><div class="sign" aria-hidden="true">{SIGNS[kind]}</div><div>'
            f'<p class="headline">{esc(verdict.headline(facts))}</p><p class="sub">{_attempt_line(facts)}</p>{also}'
            '</div></section>')


def _attempt_line(facts):
    if facts.attempt is None:
        return ""
    first, last = facts.attempt_span()
    began = facts.attempt.get("status") != "failed" or is_number(facts.attempt.get("first_tick"))
    parts = [f"Attempt {facts.attempt.get('number', 1)} of {len(facts.attempts)}",
             f"{clock(last - first)} long" if began else "over before its time began"]
    if is_number(facts.attempt.get("composite")):
        parts.append(f"{100 * facts.attempt['composite']:.0f} % of the judged metrics passed (to pass, all "
                     "have to)")
    return esc(", ".join(parts))


def _improvements(facts):
    entries = verdict.improvements(facts)
    if not entries:
        nothing = no_advice(facts)
        return f"<section><h2>What to improve</h2><p>{nothing}</p></section>" if nothing else ""
    title = {1: "The thing", 2: "The two things"}.get(len(entries), "The three things")
    items = "".join(f"<li><b>{esc(e['what'])}</b><span>{esc(e['how'])}</span></li>" for e in entries)
    return f'<section><h2>{title} to improve</h2><ol class="improve">{items}</ol></section>'


def no_advice(facts):
    """What is said where score.json has no advice; empty for an attempt that did not end."""
    attempt = facts.attempt or {}
    if attempt.get("passed") is False or attempt.get("status") == "failed":
        return "The reason is given above. No figure needs work."
    if attempt.get("status") != "done":
        return ""
    if not judged(facts):
        return "Unknown: no figure was judged."
    return "Nothing: every figure is well within its band."


# ---- bands ------------------------------------------------------------------------------------------------------


def judged(facts):
    """(name, metric) of the attempt that have a limit, by group, failed ones first."""
    metrics = (facts.attempt or {}).get("metrics", {})
    found = [(name, m) for name, m in metrics.items() if isinstance(m, dict) and is_number(m.get("limit"))
             and is_number(m.get("value"))]
    return sorted(found, key=lambda entry: (entry[1].get("passed") is not False, -(entry[1].get("excess") or 0.0)))


def _bands(facts):
    rows = judged(facts)
    if not rows:
        return ""
    parts, columns = [_band_origin(facts)], []
    for group, title, meaning in metric_words.GROUPS:
        inside = [(name, m) for name, m in rows if m.get("group") == group]
        if inside:
            inside.sort(key=lambda entry: list(facts.attempt["metrics"]).index(entry[0]))
            passed = sum(m.get("passed") is True for _, m in inside)
            columns.append(f'<div class="bands"><h3>{title} <small>{meaning}; {passed} of {len(inside)} within the '
                           'band</small></h3>'
                           f'{"".join(_row(name, m, facts.score) for name, m in inside)}</div>')
    parts.append(f'<div class="columns">{"".join(columns)}</div>')
    missing = [metric_words.words_of(name).title for name in facts.attempt.get("not_judged", [])]
    if missing:
        parts.append(f'<p class="sub">Not judged: {esc(", ".join(missing))} (not measured in this attempt, or '
                     'not in the band).</p>')
    return f'<section><h2>Score by metric</h2>{"".join(parts)}</section>'


def _band_origin(facts):
    band = facts.score.get("band") or {}
    origin = str(band.get("origin", "unknown"))
    # The word belongs next to every figure that judges a trainee.
    warning = "" if "not surgeons" in origin else " The origin of this band is as its maker stated it."
    sessions = f", {band['sessions']} sessions" if is_number(band.get("sessions")) else ""
    key = drawing.legend(2, 14, [("within the band", "#d9dee4", "area"), ("expert's mean", drawing.INK, "3 2"),
                                 ("limit", drawing.INK, ""), ("passed", drawing.GOOD, "circle"),
                                 ("not passed", drawing.BAD, "cross")], 12.5)
    return (f'<p class="sub">Expert band: {esc(origin)}{sessions}.{warning}</p>'
            f'<div class="bandkey">{drawing.svg(640, 20, key, "Legend")}</div>')


def _row(name, metric, score):
    known = metric_words.words_of(name)
    value = metric_words.figure(name, metric, metric["value"])
    limit = metric_words.figure(name, metric, metric_words.limit_of(metric))
    sign = "at most" if metric.get("better") == "lower" else "at least"
    own = ", the exercise's own limit" if is_number(metric.get("bound")) and metric["bound"] == metric["limit"] else ""
    good = metric.get("passed") is True
    return (f'<div class="band {"good" if good else "bad"}"><div class="what"><b>{esc(known.title)}</b></div>'
            f'<div class="value">{esc(value)}</div><div class="chart">{band_svg(name, metric)}</div>'
            f'<div class="mark"><b>{"✓ passed" if good else "✕ not passed"}</b></div>'
            f'<small>{esc(metric_words.meaning_of(name, score))}; <span class="limit">{sign} {esc(limit)}</span>{own}'
            "</small></div>")


def band_range(metric):
    """(low, high) of the drawn axis."""
    value, limit = metric["value"], metric["limit"]
    mean = metric.get("mean") if is_number(metric.get("mean")) else limit
    spread = metric.get("deviation") if is_number(metric.get("deviation")) else 0.0
    low, high = min(value, limit, mean - spread), max(value, limit, mean + spread)
    if low >= 0.0:
        return 0.0, (high if high > 0.0 else 1.0) * 1.12
    room = 0.15 * (high - low) if high > low else 1.0
    return low - room, min(high + room, 0.0) if high <= 0.0 else high + room


def band_svg(name, metric):
    panel = drawing.Panel(9, 5, 202, 16, band_range(metric), (0, 1))
    limit, lower = metric["limit"], metric.get("better") == "lower"
    zone = (panel.x_range[0], limit) if lower else (limit, panel.x_range[1])
    colour = drawing.GOOD if metric.get("passed") is True else drawing.BAD
    parts = [drawing.rect(panel.x, 10, panel.width, 8, "#fff", stroke=drawing.LINE),
             panel.shade(*zone, "#d9dee4"), drawing.line(panel.to_x(limit), 3, panel.to_x(limit), 25, drawing.INK, 1.8)]
    if is_number(metric.get("mean")):
        parts.append(drawing.line(panel.to_x(metric["mean"]), 6, panel.to_x(metric["mean"]), 22, drawing.INK, 1.2,
                                  "3 2"))
    shape = "circle" if metric.get("passed") is True else "cross"
    parts.append(drawing.mark(panel.to_x(metric["value"]), 14, shape, colour, size=6))
    label = f"{metric_words.words_of(name).title}: {metric_words.figure(name, metric, metric['value'])}"
    return drawing.svg(220, 27, "".join(parts), label)


# ---- all of them ------------------------------------------------------------------------------------------------


def all_metrics(facts):
    """Every number with its unit, what it is, and the expert's."""
    metrics = (facts.attempt or {}).get("metrics", {})
    rows = []
    for group, title, _ in metric_words.GROUPS:
        for name, metric in metrics.items():
            if not isinstance(metric, dict) or metric.get("group") != group:
                continue
            known = metric_words.words_of(name)
            passed = {True: "✓ passed", False: "✕ not passed"}.get(metric.get("passed"), "not judged")
            if not is_number(metric.get("value")):
                passed = "not measured"
            mean, spread = metric.get("mean"), metric.get("deviation")
            shown = [metric_words.figure(name, metric, value) for value in (mean, spread)]
            expert = " ± ".join(shown) if is_number(mean) else "–"
            meaning = metric_words.meaning_of(name, facts.score)
            rows.append([title, f"<b>{esc(known.title)}</b><br><small>{esc(meaning)}</small>",
                         esc(metric_words.figure(name, metric, metric.get("value"))), esc(expert),
                         esc(metric_words.figure(name, metric, metric_words.limit_of(metric))), esc(passed)])
    return rows


def attempts_table(facts):
    rows = []
    for attempt in facts.attempts:
        first, last = attempt.get("first_tick"), attempt.get("last_tick")
        length = (last - first) / 1000.0 if is_number(first) and is_number(last) else None
        passed = {True: "✓ passed", False: "✕ not passed"}.get(attempt.get("passed"), "not judged")
        mistakes = attempt.get("mistakes") if isinstance(attempt.get("mistakes"), dict) else {}
        made = ", ".join(f"{metric_words.MISTAKES.get(k, words(k))}: {v}" for k, v in mistakes.items() if v) or "none"
        rows.append([number(attempt.get("number")), clock(first / 1000.0) if is_number(first) else "–", clock(length),
                     esc(words(attempt.get("status", ""))), esc(made), passed])
    return rows
