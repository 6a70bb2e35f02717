// The WebSocket to the station: reconnects, requests with replies, pictures.

const RETRY_MS = 500;
const SILENT_MS = 1500;  // the station says something every 500 ms
const WATCH_MS = 250;
const NO_ANSWER = "The station does not answer.";

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
    this.isSilent = false;
    this.connect();
    this.watch();
  }

  connect() {
    const scheme = location.protocol === "https:" ? "wss:" : "ws:";
    this.socket = new WebSocket(`${scheme}//${location.host}/ws?page=${this.page}`);
    this.socket.binaryType = "arraybuffer";
    let wasOpen = false;
    this.socket.onopen = () => {
      wasOpen = true;
      this.heard();
      this.onOpen(true);
    };
    this.socket.onmessage = (event) => {
      this.heard();
      this.take(event.data);
    };
    this.socket.onclose = async () => {
      this.giveUp();
      this.onOpen(false);
      if (!wasOpen && await this.isLoggedOut()) location.reload();
      setTimeout(() => this.connect(), RETRY_MS);
    };
  }

  // A station that was started again may not know this page's login any more.
  async isLoggedOut() {
    try {
      return (await fetch("/class.csv", { method: "HEAD" })).status === 403;
    } catch {
      return false;
    }
  }

  giveUp() {
    for (const done of this.waiting.values()) done({ ok: false, text: NO_ANSWER, more: {} });
    this.waiting.clear();
  }

  heard() {
    this.lastHeard = performance.now();
    const wasSilent = this.isSilent;
    this.isSilent = false;  // first: the page asks for something at once
    if (wasSilent) this.onOpen(true);
  }

  // A connection may stay open for minutes although nobody is at its other end.
  watch() {
    let last = performance.now();
    setInterval(() => {
      const now = performance.now();
      const wasAwake = now - last < 2 * WATCH_MS;  // else the messages of a page that slept come after this
      last = now;
      if (!wasAwake || !this.isOpen || this.isSilent || now - this.lastHeard < SILENT_MS) return;
      this.isSilent = true;
      this.giveUp();
      this.onOpen(false);
    }, WATCH_MS);
  }

  take(data) {
    if (data instanceof ArrayBuffer) {
      const which = new Uint8Array(data, 0, 1)[0] === 0 ? "view" : "second";
      this.onPicture(which, new Blob([new Uint8Array(data, 1)], { type: "image/jpeg" }));
      this.send("shown");
      return;
    }
    const message = JSON.parse(data);
    if (message.t === "reply") {
      const done = this.waiting.get(message.id);
      this.waiting.delete(message.id);
      if (done) done(message);
      else if (message.id === null) byId("said").textContent = message.text;
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
    if (!this.isOpen || this.isSilent) return Promise.resolve({ ok: false, text: NO_ANSWER, more: {} });
    this.number += 1;
    const id = this.number;
    return new Promise((resolve) => {
      this.waiting.set(id, resolve);
      this.socket.send(JSON.stringify({ id, do: what, with: settings }));
    });
  }

  // The pictures to be sent. The station waits until they are shown, so that a slow link shows new ones.
  wantPictures(which) {
    return this.ask("watch", { pictures: which, acknowledges: true });
  }

  // Without a reply: motion of the hands.
  send(what, settings = {}) {
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
export function showTask(message, steps, tracks = []) {
  byId("task-title").textContent = message.exercise ? message.title : "No exercise";
  byId("task-text").textContent = message.exercise ? (message.attempt > 1 ? `Attempt ${message.attempt}: ` : "") + message.text : "";
  byId("task-text").className = message.status === "failed" ? "bad" : message.status === "done" ? "good" : "";
  byId("task-time").textContent = message.exercise ? `(${message.elapsed.toFixed(1)} s of ${message.time_limit.toFixed(0)} s)` : "";
  // Each track, of one arm for example, has its own next step.
  const states = tracks.flatMap((count, track) => Array.from({ length: count }, (_, i) => (i < message.done[track] ? "done" : i === message.done[track] ? "now" : "")));
  const items = (steps || []).map((name, i) => {
    const item = document.createElement("li");
    item.textContent = name;
    item.className = states[i] || "";
    return item;
  });
  if (message.tracks.length > 1) byId("task-text").textContent += `, step ${message.step} of ${message.steps}`;
  byId("steps").replaceChildren(...items);
  byId("mistakes").replaceChildren(...message.mistakes.map(([name, count]) => {
    const item = document.createElement("li");
    item.textContent = count === 1 ? name : `${name}: ${count} times`;
    return item;
  }));
}

export function showHealth(message) {
  const health = byId("health");
  const text = message.detail ? `${message.text} (${message.detail})` : message.text;
  if (health.textContent !== text) health.textContent = text;
  health.dataset.level = message.level;
}
