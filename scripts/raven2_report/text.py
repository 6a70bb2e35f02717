"""Words and numbers of the report, and its tables. Whatever comes from outside goes through esc()."""

import html

KINDS = {(True, False): ' class="n"', (False, True): ' class="v"', (False, False): ""}  # of a cell: numeric, verdict
COUNT_WORDS = ("no", "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten")


def esc(value):
    return html.escape(str(value))


def words(name):
    return str(name).replace("_", " ")


def is_number(value):
    return isinstance(value, (int, float)) and not isinstance(value, bool) and value == value


def number(value, digits=2, unit=""):
    """A figure with its unit, or a dash."""
    if not is_number(value):
        return "–"
    text = f"{value:,}" if isinstance(value, int) else f"{value:,.{digits}f}"
    if text.lstrip("-0.,") == "":
        text = text.lstrip("-")  # no -0.00
    return f"{text} {unit}".rstrip()


def percent(value):
    """Cut, not rounded: 99.999 % is not 100 %."""
    return "–" if value is None else f"{int(value * 10000) / 100:.2f} %"


def times(count):
    return {0: "never", 1: "once", 2: "twice"}.get(count, f"{count} times")


def counted(count, noun, plural=None):
    """`two drops`; figures from eleven on."""
    word = COUNT_WORDS[count] if 0 <= count < len(COUNT_WORDS) else f"{count:,}"
    return f"{word} {noun if count == 1 else plural or noun + 's'}"


def listed(parts, last="and"):
    """`a`, `a and b`, `a, b and c`."""
    parts = list(parts)
    return parts[0] if len(parts) == 1 else ", ".join(parts[:-1]) + f" {last} " + parts[-1] if parts else ""


def clock(seconds):
    """`7.3 s`, `2 min 05 s`."""
    if not is_number(seconds):
        return "–"
    return f"{seconds:.1f} s" if seconds < 100 else f"{int(seconds) // 60} min {int(seconds) % 60:02d} s"


def table(titles, rows, numeric=(), kind=""):
    """An HTML table that scrolls by itself where it is wider than the page; `numeric` columns are set to the right."""

    def row(cells, tag):
        marks = (KINDS[i in numeric, titles[i] == "Verdict"] for i in range(len(cells)))
        return "<tr>" + "".join(f"<{tag}{mark}>{cell}</{tag}>" for mark, cell in zip(marks, cells)) + "</tr>"

    kind = f' class="{kind}"' if kind else ""
    return (f'<div class="wide"><table{kind}><thead>{row(titles, "th")}</thead>'
            f'<tbody>{"".join(row(r, "td") for r in rows)}</tbody></table></div>')
