// The trainee's page: the picture, forces for eyes and ears, and hands without hardware.

import { byId, Link, Picture, showHealth, showTask } from "/static/link.js";
import { ACTIONS, Hands, isUsable, loadKeys, saveKeys } from "/static/input.js";

const LEAST_MS = 8;  // between two messages of the hands: a page that was held up gets its ticks at once
const NOTICEABLE = 0.5;  // [N] as in doc/scores.md
const FORCE_SILENT_MS = 1000;  // no force is known any more
const REFUSED_MS = 700;  // a held pedal counts within 100 ms, on a busy computer a little later
const PEDAL_TEXTS = { yes: "Pedal DOWN", no: "Pedal up", refused: "Let the pedal go, then press it again" };
if (!window.isSecureContext) byId("gamepad").textContent = "No gamepad: browsers allow one only on this computer or over https (--tls-certificate).";
const NO_GAMEPAD = byId("gamepad").textContent;
const picture = new Picture(byId("picture"));
const screen = byId("screen");
const keys = loadKeys();
const hands = new Hands(screen, keys);
let station = { phase: "idle" };
let me = null;
let steps = {};
let tracks = {};
let drives = false;
let isConnected = false;
let mode = "";
let pedalCounts = false;  // as the trainer sees it
let downSince = null;     // [ms] the pedal is held on this page
let lastPicture = 0;
let lastSent = performance.now();

const link = new Link("trainee", {
  hello: (m) => { me = m.number; },
  library: (m) => { steps = m.steps; tracks = m.tracks; },
  mode: showMode,
  health: showHealth,
  alive: showHealth,
  station: showStation,
  exercise: (m) => showTask(m, steps[m.exercise] || [], tracks[m.exercise] || []),
  strips: showForce,
  axes: (m) => hands.look(m.axes),
}, (_, blob) => { lastPicture = performance.now(); picture.show(blob); }, (isOpen) => {
  isConnected = isOpen;
  if (isOpen) link.wantPictures(["view"]);  // the station answers with its state
  if (!isOpen) {
    showStation({ ...station, drives: null });
    pedalCounts = false;
    byId("mode").textContent = "No connection";
    showHealth({ level: 2, text: "The station does not answer. Trying again." });
  }
});

function loseHands() {
  release();
  if (hands.isLocked) document.exitPointerLock();
}

function showMode(message) {
  mode = message.mode;
  pedalCounts = message.pedal;
  byId("mode").textContent = message.text;
  const banner = byId("banner");
  const text = mode === "stopped" ? "STOPPED" : mode === "paused" ? "PAUSED" : "";
  if (text && banner.hidden) beep(220, 0.5);
  banner.hidden = !text;
  banner.textContent = text;
}

function showStation(message) {
  station = message;
  const isMine = message.drives !== null && message.drives === me;
  const isLost = drives && !isMine;
  drives = isMine;
  if (isLost) loseHands();
  hands.isActive = drives;
  const may = message.foreign || (!message.replay && message.choice && message.choice.driver === "browser" && message.phase === "running");
  byId("drive").disabled = !may && !drives;
  byId("drive").textContent = drives ? "Give the hands back" : "Take the hands";
  const runs = message.phase === "running" || message.foreign;
  byId("picture-note").textContent = !isConnected ? "No connection to the station." : runs ? "No picture comes from the trainer." : "No picture: no session is running.";
  if (!runs) {
    byId("mode").textContent = "No session";
    byId("banner").hidden = true;
    clearForce();
  }
  if (!isConnected) byId("said").textContent = "Wait: the page connects again by itself.";
  else if (!may) byId("said").textContent = waitFor(message);
  else if (message.hands_away) byId("said").textContent = "The instructor has taken the hands away.";
  else if (!drives && message.drives !== null) byId("said").textContent = "Another page moves the arms.";
  else if (drives && !hands.isLocked) byId("said").textContent = "Click the picture. Then hold the pedal key and move the mouse.";
  else byId("said").textContent = drives ? "Esc gives the mouse back." : "Press Take the hands.";
}

function waitFor({ phase, replay, choice }) {
  if (phase !== "running" || !choice) return "Wait: the instructor starts a session.";
  if (replay) return "A past session is shown.";
  return choice.driver.startsWith("master:") ? "Hand devices move the arms." : "A demonstration runs.";
}

// ---- forces without haptics

let context = null;

// Browsers let a page make sounds only from a click on.
function allowSound() {
  try {
    context = context || new AudioContext();
    context.resume().catch(() => {});
  } catch {
    // no sound on this computer
  }
}

document.addEventListener("click", allowSound);
document.addEventListener("keydown", allowSound);

function beep(frequency, seconds, volume = 0.2) {
  if (!byId("sound").checked || !context || context.state !== "running") return;
  try {
    const tone = context.createOscillator();
    const gain = context.createGain();
    tone.frequency.value = frequency;
    gain.gain.value = volume;
    tone.connect(gain).connect(context.destination);
    tone.start();
    tone.stop(context.currentTime + seconds);
  } catch {
    // no sound on this computer
  }
}

let lastBeep = 0;
let lastForce = 0;

function clearForce() {
  for (const arm of ["gold", "green"]) byId(`push-${arm}`).hidden = true;
  screen.classList.remove("forced");
}

function showForce(message) {
  const now = performance.now();
  lastForce = now;
  let strongest = 0;
  for (const arm of ["gold", "green"]) {
    const force = message.force[arm] || 0;
    strongest = Math.max(strongest, force);
    const arrow = byId(`push-${arm}`);
    arrow.hidden = force < NOTICEABLE;
    // base frames: gold x up, y to the surgeon, z right; green x up, y forward, z left
    const [x, y, z] = message.push[arm];
    const [right, up] = hands.inPicture(arm === "gold" ? [z, -y, x] : [-z, y, x]);
    arrow.style.transform = `rotate(${Math.atan2(-up, right)}rad) scale(${Math.min(1.6, 0.6 + force / 3)})`;
  }
  screen.classList.toggle("forced", strongest >= NOTICEABLE);
  if (strongest >= NOTICEABLE && now - lastBeep > 150) {
    lastBeep = now;
    beep(440 + 60 * strongest, 0.1);
    hands.rumble(Math.min(1, strongest / 3));
  }
}

// ---- hands

byId("drive").addEventListener("click", async () => {
  if (drives) {
    release();
    await link.ask("leave");
    return;
  }
  const reply = await link.ask("drive");
  showStation(station);
  if (reply.ok) screen.focus();
  else byId("said").textContent = reply.text;
});

screen.addEventListener("click", () => {
  if (drives && !hands.isLocked) lockMouse();
});

// Browsers refuse the lock for a second after Esc. Old ones return no promise and send an event.
const NOT_LOCKED = "The browser did not lock the mouse to the picture. Wait a second, then click the picture again.";

async function lockMouse() {
  try {
    await screen.requestPointerLock();
  } catch {
    byId("said").textContent = NOT_LOCKED;
  }
}

document.addEventListener("pointerlockerror", () => { byId("said").textContent = NOT_LOCKED; });
document.addEventListener("pointerlockchange", () => {
  if (!hands.isLocked) hands.turning = false;
  showStation(station);
});

// The pedal comes up at once when the page loses the focus or is hidden.
function release() {
  hands.reset();
  if (drives) link.send("hands", hands.take(0));
  showPedal(false);
}

window.addEventListener("blur", release);
screen.addEventListener("blur", release);
window.addEventListener("pagehide", release);
document.addEventListener("visibilitychange", () => { if (document.hidden) release(); });

// A pedal does not count while the robot is not ready, nor after the console lost it, until the next press. The page says
// so, because the key is held and nothing moves.
function showPedal(isDown) {
  const now = performance.now();
  downSince = isDown ? downSince ?? now : null;
  const isRefused = isDown && !pedalCounts && mode !== "camera_moving" && now - downSince > REFUSED_MS;
  const shown = isRefused ? "refused" : isDown ? "yes" : "no";
  if (byId("pedal").dataset.down === shown) return;
  byId("pedal").dataset.down = shown;
  byId("pedal").textContent = PEDAL_TEXTS[shown];
}

// Every 16 ms. A timer of the page itself comes up to 120 ms late on a busy computer, and then the pedal comes up.
new Worker("/static/ticker.js").onmessage = () => {
  const now = performance.now();
  if (now - lastSent < LEAST_MS) return;
  const seconds = Math.min(0.1, (now - lastSent) / 1000);
  lastSent = now;
  byId("picture-note").hidden = now - lastPicture < 1500;
  if (now - lastForce > FORCE_SILENT_MS) clearForce();
  byId("arm").textContent = hands.arm === "gold" ? "gold (left)" : "green (right)";
  byId("jaw").textContent = hands.jaws[hands.arm] > 0.3 ? "open" : "closed";
  if (!drives || document.hidden || !document.hasFocus()) return;
  byId("gamepad").textContent = hands.gamepad(seconds) || NO_GAMEPAD;
  const message = hands.take(seconds);
  showPedal(message.pedal);
  link.send("hands", message);
};

// ---- keys

const NAMES = (code) => code.replace(/^Key|^Digit/, "").replace(/([a-z])([A-Z])/g, "$1 $2");

function showKeys() {
  const rows = Object.entries(ACTIONS).map(([action, text]) => {
    const line = document.createElement("tr");
    const what = document.createElement("td");
    what.textContent = text;
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = NAMES(keys[action]);
    button.dataset.test = `key-${action}`;
    button.addEventListener("click", () => changeKey(action, button));
    const key = document.createElement("td");
    key.append(button);
    line.append(what, key);
    return line;
  });
  const fixed = [["Move in the picture's plane", "mouse"], ["Along the view", "wheel"], ["Turn the tool", "right button"], ["Jaws", "left button"]];
  byId("keys").replaceChildren(byId("keys").caption, ...rows, ...fixed.map(([text, how]) => {
    const line = document.createElement("tr");
    for (const cell of [text, how]) {
      const element = document.createElement("td");
      element.textContent = cell;
      line.append(element);
    }
    return line;
  }));
}

let asked = null;  // { action, button } of the key that is asked for

function changeKey(action, button) {
  giveUpKey();
  asked = { action, button };
  button.textContent = "press a key";
}

function giveUpKey() {
  if (asked) asked.button.textContent = NAMES(keys[asked.action]);
  asked = null;
}

window.addEventListener("keydown", (event) => {
  if (!asked) return;
  event.preventDefault();
  event.stopImmediatePropagation();
  if (event.repeat) return;  // of the Enter that pressed the button
  if (!isUsable(event.code)) {
    byId("said").textContent = `${NAMES(event.code) || "This key"} cannot be chosen: the browser needs it. Press another key, or Esc.`;
    return;
  }
  const { action } = asked;
  if (event.code !== "Escape") {
    const other = Object.keys(keys).find((a) => keys[a] === event.code);
    if (other) keys[other] = keys[action];
    keys[action] = event.code;
    saveKeys(keys);
  }
  giveUpKey();
  showKeys();
}, { capture: true });
// A press elsewhere is no answer.
window.addEventListener("blur", giveUpKey);
window.addEventListener("pointerdown", (event) => { if (asked && event.target !== asked.button) giveUpKey(); }, { capture: true });

byId("speed").addEventListener("input", () => { hands.speed = Number(byId("speed").value); });
showKeys();
