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
  context.beginPath();
  for (const side of [-1, 1]) {
    context.moveTo(x - 6, y - 6 * side);
    context.lineTo(x + 6, y + 6 * side);
  }
  context.stroke();
  context.lineWidth = 1;
}

// Score, time and hazard response over a trainee's attempts. A filled mark: passed. A cross on the axis: not passed, with
// or without a time.
export function drawCurve(canvas, attempts) {
  const context = canvas.getContext("2d");
  const { width, height } = canvas;
  const values = attempts.map((a) => a.time).filter((t) => typeof t === "number");
  const top = Math.max(10, Math.ceil(Math.max(0, ...values)));
  axes(context, width, height, top, "s", "Time");
  const x = (i) => 24 + (i + 0.5) * ((width - 48) / Math.max(attempts.length, 1));
  attempts.forEach((attempt, i) => {
    if (attempt.passed === false) cross(context, x(i), height - 12);
    context.strokeStyle = "#0b5cad";
    context.fillStyle = "#0b5cad";
    if (typeof attempt.time === "number") {
      context.beginPath();
      context.arc(x(i), height - 12 - (attempt.time / top) * (height - 56), 6, 0, 2 * Math.PI);
      if (attempt.passed === true) context.fill();
      context.stroke();
    }
    if (typeof attempt.score === "number") {
      context.strokeStyle = "#186a3b";
      context.strokeRect(x(i) - 6, height - 18 - attempt.score * (height - 56), 12, 12);
    }
    if (typeof attempt.response === "number") {
      const y = height - 12 - (Math.min(attempt.response, 5) / 5) * (height - 56);
      context.strokeStyle = "#b3160e";
      context.beginPath();
      context.moveTo(x(i), y - 7);
      context.lineTo(x(i) + 7, y + 5);
      context.lineTo(x(i) - 7, y + 5);
      context.closePath();
      context.stroke();
    }
  });
}
