"""Small SVG drawings: a plot over an axis, and what the report's pictures share. Readable in grey and by the
colour-blind: lines differ by dashes, marks by shape, and each has its name next to it (colours: Okabe and Ito)."""

import math

import numpy as np

from raven2_report.text import esc

INK, SOFT, LINE, PANEL = "#1f2933", "#56616c", "#d5dae0", "#f6f7f9"
MODEL, ROBOT = "#0072b2", "#d55e00"
ARM_COLOURS = {"gold": "#c47f00", "green": "#00734f"}
ARM_DASHES = {"gold": "", "green": "7 3"}
GOOD, BAD, HAZARD = "#1b6e53", "#a63603", "#f0c05a"
HALO = {"paint_order": "stroke", "stroke": "#fff", "stroke_width": 4, "stroke_linejoin": "round"}  # of words on lines
MAX_POINTS = 900  # of a drawn line


def attributes(values):
    return "".join(f' {key.replace("_", "-")}="{esc(value)}"' for key, value in values.items()
                   if value not in ("", None))


def tag(name, inside="", **values):
    return f"<{name}{attributes(values)}>{inside}</{name}>" if inside else f"<{name}{attributes(values)}/>"


def text(x, y, words, size=13, anchor="start", colour=INK, **more):
    return tag("text", esc(words), x=f"{x:.1f}", y=f"{y:.1f}", font_size=size, text_anchor=anchor, fill=colour, **more)


def line(x1, y1, x2, y2, colour=LINE, width=1.0, dash="", **more):
    return tag("line", x1=f"{x1:.1f}", y1=f"{y1:.1f}", x2=f"{x2:.1f}", y2=f"{y2:.1f}", stroke=colour,
               stroke_width=width,
               stroke_dasharray=dash, **more)


def rect(x, y, width, height, fill, title="", **more):
    inside = f"<title>{esc(title)}</title>" if title else ""
    return tag("rect", inside, x=f"{x:.1f}", y=f"{y:.1f}", width=f"{max(width, 0.0):.1f}",
               height=f"{max(height, 0.0):.1f}",
               fill=fill, **more)


def mark(x, y, shape, colour, title="", size=6.0):
    """circle (fine), cross (mistake), diamond (hazard), triangle (response), square (step)."""
    inside = f"<title>{esc(title)}</title>" if title else ""
    s = size
    shapes = {"cross": f"M{-s},{-s}L{s},{s}M{-s},{s}L{s},{-s}", "diamond": f"M0,{-1.3 * s}L{s},0L0,{1.3 * s}L{-s},0Z",
              "triangle": f"M0,{s}L{-s},{-s}L{s},{-s}Z", "square": f"M{-s},{-s}H{s}V{s}H{-s}Z",
              "circle": f"M{-s},0A{s},{s} 0 1 0 {s},0A{s},{s} 0 1 0 {-s},0Z"}
    style = ({"stroke": colour, "stroke_width": 2.6, "fill": "none"} if shape == "cross"
             else {"fill": colour, "stroke": "#fff", "stroke_width": 1})
    return tag("path", inside, d=shapes[shape], transform=f"translate({x:.1f} {y:.1f})", **style)


def svg(width, height, body, label, kind="", ident=""):
    return (f'<svg viewBox="0 0 {width:g} {height:g}" role="img" aria-label="{esc(label)}"'
            f'{attributes({"class": kind, "id": ident})}>{body}</svg>')


def nice_ticks(low, high, count=5):
    """Round numbers in [low, high], about `count` of them."""
    if not (math.isfinite(low) and math.isfinite(high)) or high <= low:
        return [low] if math.isfinite(low) else []
    raw = (high - low) / max(count, 1)
    power = 10.0 ** math.floor(math.log10(raw))
    step = next(f * power for f in (1, 2, 5, 10) if f * power >= raw * 0.999)
    first = math.ceil(low / step - 1e-9)
    return [round(i * step, 12) for i in range(first, int(math.floor(high / step + 1e-9)) + 1)]


def tick_word(value):
    return f"{value:g}" if abs(value) < 1e4 else f"{value:,.0f}"


def thinned(t, values, most=MAX_POINTS):
    """Fewer points of a line that keep its peaks: the least and the largest of each stretch."""
    if len(t) <= most:
        return t, values
    bounds = np.linspace(0, len(t), most // 2 + 1).astype(int)
    low, high = np.where(np.isnan(values), np.inf, values), np.where(np.isnan(values), -np.inf, values)
    extremes = ((np.argmin, low), (np.argmax, high))
    keep = np.unique([f(part[a:b]) + a for a, b in zip(bounds[:-1], bounds[1:]) for f, part in extremes])
    return t[keep], values[keep]


class Panel:
    """A plot: a rectangle on the page with a range of x and of y."""

    def __init__(self, x, y, width, height, x_range, y_range):
        self.x, self.y, self.width, self.height = x, y, width, height
        self.x_range = x_range if x_range[1] > x_range[0] else (x_range[0], x_range[0] + 1.0)
        self.y_range = y_range if y_range[1] > y_range[0] else (y_range[0] - 0.5, y_range[0] + 0.5)

    def to_x(self, value):
        low, high = self.x_range
        return self.x + (value - low) / (high - low) * self.width

    def to_y(self, value):
        low, high = self.y_range
        return self.y + self.height - (value - low) / (high - low) * self.height

    def inside(self, value):
        return self.x_range[0] <= value <= self.x_range[1]

    def frame(self, label="", ticks=3, size=12):
        """Grid, numbers on the left, and what they are above them."""
        parts = []
        for value in nice_ticks(*self.y_range, ticks):
            y = self.to_y(value)
            parts.append(line(self.x, y, self.x + self.width, y))
            parts.append(text(self.x - 6, y + 4, tick_word(value), size, "end", SOFT))
        parts.append(line(self.x, self.y, self.x, self.y + self.height, SOFT))
        if label:
            parts.append(text(self.x + 2, self.y - 6, label, size + 0.5, font_weight=600, **HALO))
        return "".join(parts)

    def x_axis(self, label, ticks=8, size=12, show=tick_word):
        bottom = self.y + self.height
        parts = [line(self.x, bottom, self.x + self.width, bottom, SOFT)]
        for value in nice_ticks(*self.x_range, ticks):
            x = self.to_x(value)
            parts += [line(x, bottom, x, bottom + 4, SOFT), text(x, bottom + 17, show(value), size, "middle", SOFT)]
        return "".join(parts) + text(self.x + self.width, bottom + 33, label, size, "end", SOFT)

    def curve(self, t, values, colour, width=1.6, dash="", title=""):
        """A line that is interrupted where values are not numbers, and cut at the panel's edges."""
        t, values = np.asarray(t, float), np.asarray(values, float)
        near = (t >= self.x_range[0]) & (t <= self.x_range[1])
        t, values = thinned(t[near], values[near])
        values = np.clip(values, *self.y_range)
        parts, fresh = [], True
        for a, b in zip(t, values):
            if not math.isfinite(b):
                fresh = True
                continue
            parts.append(f"{'M' if fresh else 'L'}{self.to_x(a):.1f},{self.to_y(b):.1f}")
            fresh = False
        if not parts:
            return ""
        inside = f"<title>{esc(title)}</title>" if title else ""
        return tag("path", inside, d="".join(parts), fill="none", stroke=colour, stroke_width=width,
                   stroke_dasharray=dash,
                   stroke_linejoin="round")

    def shade(self, first, last, fill, title="", **more):
        a, b = (min(max(v, self.x_range[0]), self.x_range[1]) for v in (first, last))
        return rect(self.to_x(a), self.y, max(self.to_x(b) - self.to_x(a), 1.5), self.height, fill, title, **more)

    def upright(self, at, colour, dash="4 3", width=1.4):
        return line(self.to_x(at), self.y, self.to_x(at), self.y + self.height, colour, width, dash)


def legend(x, y, entries, size=13, room=9.0):
    """Entries (name, colour, dash or shape) in one row; SVG and the width it takes."""
    parts, at = [], x
    for name, colour, style in entries:
        if style in ("cross", "diamond", "triangle", "square", "circle"):
            parts.append(mark(at + 10, y - 4, style, colour, size=5))
        elif style == "area":
            parts.append(rect(at, y - 10, 20, 11, colour))
        else:
            parts.append(line(at, y - 4, at + 22, y - 4, colour, 2.2, style))
        parts.append(text(at + 27, y, name, size, colour=SOFT))
        at += 27 + len(name) * size * 0.53 + 2 * room
    return "".join(parts)
