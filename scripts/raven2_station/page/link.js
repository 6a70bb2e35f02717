// The WebSocket to the station: reconnects, requests with replies, pictures.

const RETRY_MS = 500;

export const byId = (id) => document.getElementById(id);

export class Link {
  // handlers: message kind -> function(message); onPicture(which, blob); onOpen(isOpen)
  constructor(page, handlers, onPicture, onOpen) {
    this.page = page;
    this.handlers = handlers;
    this.onPicture = onPicture;
    this.onOpen = onOpen;
    this.number = 0;
    this.waiting = new Map();
    this.connect();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/ws?page=${this.page}`);
    this.socket.binaryType = "arraybuffer";
    this.socket.onopen = () => this.onOpen(true);
    this.socket.onmessage = (event) => this.take(event.data);
    this.socket.onclose = () => {
      for (const done of this.waiting.values()) done({ ok: false, text: "The station does not answer.", more: {} });
      this.waiting.clear();
      this.onOpen(false);
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  take(data) {
    if (data instanceof ArrayBuffer) {
      const which = new Uint8Array(data, 0, 1)[0] === 0 ? "view" : "camera";
      this.onPicture(which, new Blob([new Uint8Array(data, 1)], { type: "image/jpeg" }));
      return;
    }
    const message = JSON.parse(data);
    if (message.t === "reply") {
      const done = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (done) done(message);
      return;
    }
    const handler = this.handlers[message.t];
    if (handler) handler(message);
  }

  get isOpen() {
    return this.socket.readyState === WebSocket.OPEN;
  }

  // A request; resolves with { ok, text, more }.
  ask(what, settings = {}) {
    if (!this.isOpen) return Promise.resolve({ ok: false, text: "The station does not answer.", more: {} });
    this.number += 1;
    const id = this.number;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.socket.send(JSON.stringify({ id, do: what, with: settings }));
    });
  }

  // Without a reply: motion of the hands.
  send(what, settings) {
    if (this.isOpen && this.socket.bufferedAmount < 65536) this.socket.send(JSON.stringify({ do: what, with: settings }));
  }
}

// Draws JPEG pictures on a canvas; a newer picture replaces one that is still being decoded.
export class Picture {
  constructor(canvas) {
    this.canvas = canvas;
    this.context = canvas.getContext("2d");
    this.next = null;
    this.busy = false;
    this.frames = 0;
  }

  show(blob) {
    this.next = blob;
    if (!this.busy) this.draw();
  }

  async draw() {
    this.busy = true;
    while (this.next) {
      const blob = this.next;
      this.next = null;
      try {
        const image = await createImageBitmap(blob);
        if (this.canvas.width !== image.width || this.canvas.height !== image.height) {
          this.canvas.width = image.width;
          this.canvas.height = image.height;
        }
        this.context.drawImage(image, 0, 0);
        image.close();
        this.frames += 1;
        this.canvas.dataset.frames = this.frames;
      } catch {
        // a picture that was cut off: the next one comes soon
      }
    }
    this.busy = false;
  }
}

export function option(value, text) {
  const element = document.createElement("option");
  element.value = value;
  element.textContent = text;
  return element;
}

export function fill(select, options, keep = true) {
  const before = select.value;
  select.replaceChildren(...options);
  if (keep && [...select.options].some((o) => o.value === before)) select.value = before;
}

// Steps, time and mistakes of the exercise, on both pages.
export function showTask(message, steps) {
  byId("task-title").textContent = message.exercise ? message.title : "No exercise";
  byId("task-text").textContent = message.exercise ? `Attempt ${message.attempt}: ${message.text}` : "";
  byId("task-text").className = message.status === "failed" ? "bad" : message.status === "done" ? "good" : "";
  byId("task-time").textContent = message.exercise ? `(${message.elapsed.toFixed(1)} s of ${message.time_limit.toFixed(0)} s)` : "";
  const done = message.tracks.length === 1 ? message.done[0] : null;
  const items = (steps || []).map((name, i) => {
    const item = document.createElement("li");
    item.textContent = name;
    if (done !== null) item.className = i < done ? "done" : i === done ? "now" : "";
    return item;
  });
  if (done === null && steps) byId("task-text").textContent += `, step ${message.step} of ${message.steps}`;
  byId("steps").replaceChildren(...items);
  byId("mistakes").replaceChildren(...message.mistakes.map(([name, count]) => {
    const item = document.createElement("li");
    item.textContent = count === 1 ? name : `${name}: ${count} times`;
    return item;
  }));
}

export function showHealth(message) {
  const health = byId("health");
  health.textContent = message.text;
  health.dataset.level = message.level;
}
