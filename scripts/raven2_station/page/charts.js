// Curves on a canvas: the strips of the last 20 s, and a trainee's learning curve.

const COLOURS = { gold: "#8a6500", green: "#0e6b43" };
const DASHES = { gold: [], green: [7, 4] };
const SECONDS = 20;

function axes(context, width, height, top, unit, text) {
  context.clearRect(0, 0, width, height);
  context.fillStyle = "#4a5a69";
  context.font = "20px system-ui, sans-serif";
  context.fillText(text, 8, 22);
  context.textAlign = "right";
  context.fillText(`${top} ${unit}`, width - 8, 22);
  context.textAlign = "left";
  context.strokeStyle = "#c6d0da";
  context.beginPath();
  context.moveTo(0, height - 1);
  context.lineTo(width, height - 1);
  context.stroke();
}

// The last 20 s of one value of both arms.
export class Strip {
  // least: the smallest range of the axis; limit: a line to look at
  constructor(canvas, text, unit, least, limit) {
    Object.assign(this, { canvas, text, unit, least, limit, samples: [] });
  }

  add(now, values) {
    this.samples.push([now, values]);
    while (this.samples.length && now - this.samples[0][0] > SECONDS) this.samples.shift();
  }

  draw(now) {
    const { width, height } = this.canvas;
    const context = this.canvas.getContext("2d");
    const largest = Math.max(this.least, ...this.samples.flatMap(([, v]) => [v.gold || 0, v.green || 0]));
    const top = largest > this.least ? Math.ceil(largest) : this.least;
    axes(context, width, height, top, this.unit, this.text);
    const y = (value) => height - 2 - (value / top) * (height - 34);
    if (this.limit !== undefined) {
      context.strokeStyle = "#b3160e";
      context.setLineDash([2, 6]);
      context.beginPath();
      context.moveTo(0, y(this.limit));
      context.lineTo(width, y(this.limit));
      context.stroke();
    }
    for (const arm of ["gold", "green"]) {
      context.strokeStyle = COLOURS[arm];
      context.setLineDash(DASHES[arm]);
      context.lineWidth = 2.5;
      context.beginPath();
      let isDown = false;
      for (const [time, values] of this.samples) {
        if (values[arm] === null || values[arm] === undefined) {
          isDown = false;
          continue;
        }
        const x = width * (1 - (now - time) / SECONDS);
        if (isDown) context.lineTo(x, y(values[arm]));
        else context.moveTo(x, y(values[arm]));
        isDown = true;
      }
      context.stroke();
    }
    context.setLineDash([]);
    context.lineWidth = 1;
  }
}

function cross(context, x, y) {
  context.strokeStyle = "#b3160e";
  context.lineWidth = 3;
  for (const side of [-1, 1]) line(context, [[x - 6, y - 6 * side], [x + 6, y + 6 * side]], false);
  context.lineWidth = 1;
}

function line(context, points, isClosed) {
  context.beginPath();
  context.moveTo(...points[0]);
  for (const point of points.slice(1)) context.lineTo(...point);
  if (isClosed) context.closePath();
  context.stroke();
}

function disc(context, x, y, isFilled) {
  context.beginPath();
  context.arc(x, y, 6, 0, 2 * Math.PI);
  if (isFilled) context.fill();
  context.stroke();
}

const square = (context, x, y) => context.strokeRect(x - 6, y - 6, 12, 12);
const triangle = (context, x, y) => line(context, [[x, y - 7], [x + 7, y + 5], [x - 7, y + 5]], true);

// [field of an attempt, colour, share of the axis, mark]
const CURVES = [
  ["time", "#0b5cad", (value, top) => value / top, disc],
  ["score", "#186a3b", (value) => value, square],
  ["response", "#b3160e", (value) => Math.min(value, 5) / 5, triangle],
];

// Score, time and hazard response over a trainee's attempts. A filled mark: passed. A cross on the axis: not passed, with
// or without a time. Lines connect the attempts at one exercise: times of two exercises cannot be compared.
export function drawCurve(canvas, attempts) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  const values = attempts.map((a) => a.time).filter((t) => typeof t === "number");
  const top = Math.max(10, Math.ceil(Math.max(0, ...values)));
  axes(context, width, height, top, "s", "Time");
  const x = (i) => 24 + (i + 0.5) * ((width - 48) / Math.max(attempts.length, 1));
  attempts.forEach((attempt, i) => {
    if (attempt.passed === false) cross(context, x(i), height - 12);
  });
  for (const [field, colour, share, mark] of CURVES) {
    const last = {};  // place of the attempt before, by exercise
    context.strokeStyle = context.fillStyle = colour;
    attempts.forEach((attempt, i) => {
      if (typeof attempt[field] !== "number") return;
      const place = [x(i), height - 12 - share(attempt[field], top) * (height - 56)];
      if (last[attempt.exercise]) line(context, [last[attempt.exercise], place], false);
      last[attempt.exercise] = place;
      mark(context, ...place, attempt.passed === true);
    });
  }
}
