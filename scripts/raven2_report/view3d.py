"""Tip paths over the scene: one view that can be turned with the mouse, drawn as it stands for print, and three
projections. Orthographic, so that lengths can be read off."""

import json
import math

import numpy as np

from raven2_report import drawing
from raven2_report.text import esc

MAX_PATH = 700  # points of a drawn path
MOST_MARKS = 60
MOVED = 0.003  # [m] an object that moved less was only touched
PLATE = 0.15  # [m] what is larger, the ground, may reach beyond the picture
VIEWS = {  # azimuth, elevation of the viewer [deg]; what points right and up
    "turned": (205.0, 32.0, ""),
    "top": (180.0, 90.0, "from above: the surgeon sits below the picture"),
    "side": (-90.0, 0.0, "from the right: away from the surgeon is right"),
    "front": (180.0, 0.0, "from the surgeon's side"),
}


def directions(azimuth, elevation):
    """Unit vectors right, up and toward the viewer at that azimuth and elevation."""
    a, e = math.radians(azimuth), math.radians(elevation)
    return (np.array([-math.sin(a), math.cos(a), 0.0]),
            np.array([-math.sin(e) * math.cos(a), -math.sin(e) * math.sin(a), math.cos(e)]),
            np.array([math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)]))


def simplified(points, most=MAX_PATH):
    """At most so many points, those kept where the path is longest between them."""
    points = points[np.isfinite(points).all(axis=1)]
    if len(points) <= 2:
        return points
    way = np.concatenate(([0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))))
    if way[-1] <= 0.0:
        return points[:1]
    keep = np.unique(np.searchsorted(way, np.linspace(0.0, way[-1], most)).clip(0, len(points) - 1))
    return points[keep]


class Picture:
    """Contents of a drawing: shapes of the scene, paths, marks. `cloud` [m]: points that have to be seen."""

    def __init__(self, shapes, paths, marks):
        self.shapes, self.paths, self.marks = shapes, paths, marks
        seen = [s.points for s in shapes if np.ptp(s.points, axis=0).max() < PLATE]
        seen += [p["points"] for p in paths if len(p["points"])]
        cloud = np.concatenate(seen) if seen else np.zeros((1, 3))
        low, high = cloud.min(axis=0), cloud.max(axis=0)
        self.centre = (low + high) / 2
        self.cloud = cloud

    # ---- drawn as it is ---------------------------------------------------------------------------------

    def drawn(self, view, width, height, ident="", label=""):
        azimuth, elevation, _ = VIEWS[view]
        right, up, toward = directions(azimuth, elevation)
        scale = self._scale(right, up, width, height)
        flat = _Flat(self.centre, right, up, toward, scale, width / 2, height / 2)
        body = "".join(self._shape(shape, flat) for shape in sorted(self.shapes, key=flat.depth))
        body += "".join(self._path(path, flat) for path in self.paths) + "".join(self._mark(m, flat)
                                                                                 for m in self.marks)
        body += _scale_bar(scale, height) + _axes(flat, width, height, bool(ident))
        return drawing.svg(width, height, body, label or VIEWS[view][2], "scene", ident), scale

    def _scale(self, right, up, width, height):
        offset = self.cloud - self.centre  # drawn about the middle, so what counts is the farther side
        across, along = (2 * float(np.abs(offset @ axis).max()) for axis in (right, up))
        return 0.9 * min(width / max(across, 1e-3), (height - 30) / max(along, 1e-3))

    @staticmethod
    def _shape(shape, flat):
        if shape.kind == "plane":
            return (f'<path class="p" fill="{shape.colour}" fill-opacity=".3" stroke="{shape.colour}" '
                    'stroke-opacity=".75" '
                    f'stroke-width=".6" d="{flat.d(shape.points)}Z"/>')
        return (f'<path class="r" stroke="{shape.colour}" stroke-opacity=".85" stroke-linecap="round" fill="none" '
                f'stroke-width="{max(2 * shape.radius * flat.scale, 1.2):.1f}" d="{flat.d(shape.points)}"/>')

    @staticmethod
    def _path(path, flat):
        if len(path["points"]) < 2:
            return ""
        dash = f' stroke-dasharray="{path["dash"]}"' if path["dash"] else ""
        return (f'<path class="t" fill="none" stroke="{path["colour"]}" stroke-width="{path["width"]}"{dash} '
                f'stroke-linejoin="round" d="{flat.d(path["points"])}"><title>{esc(path["name"])}</title></path>')

    @staticmethod
    def _mark(mark, flat):
        x, y = flat.at(mark["point"])
        return f'<g class="m" transform="translate({x:.1f} {y:.1f})">' + drawing.mark(
            0, 0, mark["shape"], mark["colour"], mark["name"]) + "</g>"

    # ---- for turning ----------------------------------------------------------------------------------------

    def data(self, scale, width, height):
        """Data for the page's script, which draws the same from elsewhere; [mm] about the centre."""

        def flat(points):
            return [round(float(v), 1) for v in ((np.atleast_2d(points) - self.centre) * 1000.0).ravel()]

        # The script sorts shapes by depth; it finds them in the order of the drawing.
        _, _, toward = directions(*VIEWS["turned"][:2])
        ordered = sorted(self.shapes, key=lambda s: float(s.points.mean(axis=0) @ toward))
        return json.dumps({"view": VIEWS["turned"][:2], "scale": scale / 1000.0, "size": [width, height],
                           "shapes": [flat(s.points) for s in ordered],
                           "paths": [flat(p["points"]) for p in self.paths if len(p["points"]) >= 2],
                           "marks": [flat(m["point"]) for m in self.marks]}, separators=(",", ":"))


class _Flat:
    """Projects points of W onto the page."""

    def __init__(self, centre, right, up, toward, scale, x, y):
        self.centre, self.right, self.up, self.toward = centre, right, up, toward
        self.scale, self.x, self.y = scale, x, y

    def at(self, point):
        offset = np.asarray(point) - self.centre
        return self.x + self.scale * float(offset @ self.right), self.y - self.scale * float(offset @ self.up)

    def d(self, points):
        offset = points - self.centre
        xs, ys = self.x + self.scale * (offset @ self.right), self.y - self.scale * (offset @ self.up)
        return "M" + "L".join(f"{a:.1f},{b:.1f}" for a, b in zip(xs, ys))

    def depth(self, shape):
        return float(shape.points.mean(axis=0) @ self.toward)


def _scale_bar(scale, height):
    length = next((mm for mm in (100, 50, 20, 10, 5, 2, 1) if mm / 1000 * scale <= 130), 1)
    x, y = 14, height - 14
    end = x + length / 1000 * scale
    return ('<g class="bar">' + drawing.line(x, y, end, y, drawing.INK, 2)
            + drawing.line(x, y - 4, x, y + 4, drawing.INK, 2)
            + drawing.line(end, y - 4, end, y + 4, drawing.INK, 2)
            + drawing.text((x + end) / 2, y - 7, f"{length} mm", 12, "middle") + "</g>")


def _axes(flat, width, height, turns):
    """x away from the surgeon, y to the left, z up."""
    cx, cy, parts = width - 46, height - 40, []
    for axis, name in zip(np.eye(3), "xyz"):
        dx, dy = 26 * float(axis @ flat.right), -26 * float(axis @ flat.up)
        if math.hypot(dx, dy) < 3 and not turns:
            continue
        parts.append(f'<g class="a">{drawing.line(cx, cy, cx + dx, cy + dy, drawing.SOFT, 1.6)}'
                     f"{drawing.text(cx + 1.35 * dx, cy + 1.35 * dy + 4, name, 12, 'middle', drawing.SOFT)}</g>")
    return "".join(parts)


# Turns the drawing: pointer or arrow keys. Without it the drawing stays as it is.
SCRIPT = """
(function () {
  var box = document.getElementById('turn'), raw = document.getElementById('turn-data');
  if (!box || !raw) return;
  var data = JSON.parse(raw.textContent), all = function (c) { return [].slice.call(box.querySelectorAll(c)); };
  var shapes = all('path.p,path.r'), paths = all('path.t'), marks = all('g.m'), axes = all('g.a');
  var a = data.view[0], e = data.view[1], zoom = 1, w = data.size[0], h = data.size[1], queued = false;
  var layer = shapes.length ? shapes[0].parentNode : null, first = paths[0] || marks[0] || axes[0] || null;
  function draw() {
    queued = false;
    var A = a * Math.PI / 180, E = e * Math.PI / 180, s = data.scale * zoom;
    var r = [-Math.sin(A), Math.cos(A), 0], u = [-Math.sin(E) * Math.cos(A), -Math.sin(E) * Math.sin(A), Math.cos(E)];
    var t = [Math.cos(E) * Math.cos(A), Math.cos(E) * Math.sin(A), Math.sin(E)];
    function px(p, i) { return w / 2 + s * (p[i] * r[0] + p[i + 1] * r[1]); }
    function py(p, i) { return h / 2 - s * (p[i] * u[0] + p[i + 1] * u[1] + p[i + 2] * u[2]); }
    function d(p) {
      var out = '';
      for (var i = 0; i < p.length; i += 3) out += (i ? 'L' : 'M') + px(p, i).toFixed(1) + ',' + py(p, i).toFixed(1);
      return out;
    }
    var order = shapes.map(function (el, k) {
      var p = data.shapes[k], z = 0;
      for (var i = 0; i < p.length; i += 3) z += p[i] * t[0] + p[i + 1] * t[1] + p[i + 2] * t[2];
      el.setAttribute('d', d(p) + (el.classList.contains('p') ? 'Z' : ''));
      if (el.classList.contains('r')) {
        if (!el.dataset.w) el.dataset.w = el.getAttribute('stroke-width');
        el.setAttribute('stroke-width', el.dataset.w * zoom);
      }
      return [3 * z / p.length, el];
    }).sort(function (x, y) { return x[0] - y[0]; });
    order.forEach(function (o) { layer.insertBefore(o[1], first); });
    paths.forEach(function (el, k) { el.setAttribute('d', d(data.paths[k])); });
    marks.forEach(function (el, k) {
      el.setAttribute('transform', 'translate(' + px(data.marks[k], 0) + ' ' + py(data.marks[k], 0) + ')');
    });
    axes.forEach(function (el, k) {
      var dx = 26 * r[k], dy = -26 * u[k], l = el.querySelector('line'), n = el.querySelector('text');
      l.setAttribute('x2', w - 46 + dx); l.setAttribute('y2', h - 40 + dy);
      n.setAttribute('x', w - 46 + 1.35 * dx); n.setAttribute('y', h - 40 + 1.35 * dy + 4);
    });
    var bar = box.querySelector('.bar');
    if (bar) bar.style.display = zoom === 1 ? '' : 'none';
  }
  function ask() { if (!queued) { queued = true; requestAnimationFrame(draw); } }
  function turn(da, de) { a += da; e = Math.max(-90, Math.min(90, e + de)); }
  var last = null;
  box.addEventListener('pointerdown', function (ev) {
    last = [ev.clientX, ev.clientY]; box.setPointerCapture(ev.pointerId); ev.preventDefault();
  });
  box.addEventListener('pointermove', function (ev) {
    if (!last) return;
    turn(-(ev.clientX - last[0]) / 2.5, (ev.clientY - last[1]) / 2.5); last = [ev.clientX, ev.clientY]; ask();
  });
  ['pointerup', 'pointercancel'].forEach(function (n) { box.addEventListener(n, function () { last = null; }); });
  box.addEventListener('keydown', function (ev) {
    var k = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[ev.key];
    if (k) { turn(k[0], k[1]); ev.preventDefault(); draw(); }
    if (ev.key === '+' || ev.key === '-') { zoom *= ev.key === '+' ? 1.15 : 1 / 1.15; draw(); }
  });
  box.setAttribute('tabindex', '0'); box.style.cursor = 'grab'; box.style.touchAction = 'none';
  var hint = document.getElementById('turn-hint');
  if (hint) hint.hidden = false;
})();
"""


def world_paths(facts, bases):
    """Of model and robot in W: [{name, points, colour, dash, width}]."""
    first, last = (facts.index(t) for t in facts.attempt_span())
    paths = []
    for arm, name in enumerate(("gold", "green")):
        R, p = bases[arm]
        for who, points, dash, width in (("robot", facts.series.p_robot, "5 3", 1.4),
                                         ("model", facts.series.p_model, "", 2.2)):
            colour = drawing.ARM_COLOURS[name]
            paths.append({"name": f"{name} tool, {who}", "arm": name, "who": who, "colour": colour, "dash": dash,
                          "width": width, "points": simplified(points[first:last + 1, arm] @ R.T + p)})
    return paths


def object_paths(facts, free):
    """Of the scene's objects that were moved: a dotted line each."""
    ticks = facts.series.ticks["model"]
    if "bodies" not in (ticks.dtype.names or ()):
        return []
    first, last = (facts.index(t) for t in facts.attempt_span())
    paths = []
    for i, name in enumerate(free):
        points = simplified(ticks["bodies"]["p"][first:last + 1, i])
        if len(points) > 1 and np.ptp(points, axis=0).max() > MOVED:
            paths.append({"name": f"way of {name}", "colour": drawing.INK, "dash": "1.5 3.5", "width": 1.5,
                          "points": points})
    return paths


def event_marks(facts, bases):
    """Hazards at the tip that the robot left, mistakes at the tip of the arm that made them."""
    found = [(f"Hazard: {h['name']}, {h['at_s']:.1f} s", h["at_s"], facts.worst_gap(h)[0], "diamond", drawing.BAD)
             for h in facts.hazards]
    found += [(f"{facts.mistake_text(e)}, {e['at_s']:.1f} s", e["at_s"], facts.arm_of(e), "cross", drawing.INK)
              for e in facts.mistakes()]
    first, last = facts.attempt_span()
    marks = []
    for name, at, arm, shape, colour in found[:MOST_MARKS]:
        if first <= at <= last:
            R, p = bases[arm]
            marks.append({"name": name, "point": R @ facts.series.p_model[facts.index(at), arm] + p, "shape": shape,
                          "colour": colour})
    return marks


def section(facts, scene, bases):
    """HTML of the paths; without the robot's URDF there is no common frame to draw them in."""
    if bases is None or not len(facts.series.t):
        return ""
    first, _ = facts.attempt_span()
    shapes = list(scene.shapes)
    ticks = facts.series.ticks["model"]
    if "bodies" in (ticks.dtype.names or ()) and scene.free:
        shapes += scene.add_free(ticks["bodies"][facts.index(first)])
    paths = object_paths(facts, scene.free) + world_paths(facts, bases)
    marks = event_marks(facts, bases)
    picture = Picture(shapes, paths, marks)
    turned, scale = picture.drawn("turned", 1000, 560, "turn", "Paths of the tool tips over the scene, in three "
                                                               "dimensions")
    data = picture.data(scale, 1000, 560).replace("<", "\\u003c")
    flat = "".join(f"<figure>{picture.drawn(view, 460, 380, '', 'Paths ' + VIEWS[view][2])[0]}"
                   f"<figcaption>{VIEWS[view][2][0].upper() + VIEWS[view][2][1:]}</figcaption></figure>"
                   for view in ("top", "side", "front"))
    key = drawing.legend(4, 16, [("gold tool, model", drawing.ARM_COLOURS["gold"], ""),
                                 ("its robot", drawing.ARM_COLOURS["gold"], "5 3"),
                                 ("green tool, model", drawing.ARM_COLOURS["green"], ""),
                                 ("its robot", drawing.ARM_COLOURS["green"], "5 3"),
                                 ("object", drawing.INK, "1.5 3.5"), ("hazard", drawing.BAD, "diamond"),
                                 ("mistake", drawing.INK, "cross")], 12.5, 7.0)
    return (f'<figure>{drawing.svg(1000, 24, key, "Legend", "key")}{turned}<figcaption><span id="turn-hint" '
            'hidden>Drag, or '
            "use the arrow keys, to turn it; + and - change its size. </span>x points away from the surgeon, y to the "
            "left, "
            f'z up.</figcaption></figure><div class="three">{flat}</div>'
            f'<script type="application/json" id="turn-data">{data}</script>')
