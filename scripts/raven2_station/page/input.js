// Mouse, keyboard and gamepad as two hands. Motion is of the device [m, rad], in the axes of config/masters/browser.yaml:
// x right, y forward, z up.

const M_PER_PIXEL = 0.001;     // [m] of the device: the tool moves a tenth of it
const M_PER_NOTCH = 0.012;     // [m] of the device, a notch of the wheel along the view
const RAD_PER_PIXEL = 0.004;
const RAD_PER_NOTCH = 0.12;
const STICK_SPEED = 0.25;      // [m/s] of the device at a stick's end
const JAW_OPEN = 0.6;          // [rad]
// Axes of the picture until the station sends them: the endoscope's, which looks forward and down.
const HELD = { right: [1, 0, 0], up: [0, 0, 1], into: [0, 1, 0] };
const VIEW = { right: [1, 0, 0], up: [0, 0.65, 0.76], into: [0, 0.76, -0.65] };
const DEAD_BAND = 0.12;
const NOTCH = 100;             // wheel units of a notch

export const ACTIONS = {
  pedal: "Pedal: hold to move", arm: "Change arm", camera: "Camera: hold to move it", roll_left: "Roll left", roll_right: "Roll right",
  jaw: "Close or open the jaws (also left button)",
};
const DEFAULT_KEYS = { pedal: "Space", arm: "KeyX", camera: "KeyC", roll_left: "KeyQ", roll_right: "KeyE", jaw: "KeyJ" };
const STORE = "raven2_station_keys";

// Ctrl, Alt and Meta begin shortcuts of the browser, Tab leaves the picture, Enter presses buttons. "": a key without a name.
export function isUsable(code) {
  return !/^(|(Control|Alt|Meta|OS)(Left|Right)|Tab|(Numpad)?Enter)$/.test(code);
}

export function loadKeys() {
  try {
    const own = JSON.parse(localStorage.getItem(STORE) || "{}");
    return { ...DEFAULT_KEYS, ...Object.fromEntries(Object.entries(own).filter(([, code]) => isUsable(code))) };
  } catch {
    return { ...DEFAULT_KEYS };
  }
}

export function saveKeys(keys) {
  localStorage.setItem(STORE, JSON.stringify(keys));
}

export class Hands {
  constructor(screen, keys) {
    this.screen = screen;
    this.keys = keys;
    this.arm = "gold";
    this.jaws = { gold: JAW_OPEN, green: JAW_OPEN };
    this.speed = 1;
    this.triggers = { gold: 0, green: 0 };
    this.gripping = null;  // the arm whose jaws the left button holds
    this.look(null);
    this.reset();
    screen.addEventListener("mousemove", (e) => this.mouse(e));
    screen.addEventListener("wheel", (e) => this.wheel(e), { passive: false });
    screen.addEventListener("mousedown", (e) => this.button(e, true));
    window.addEventListener("mouseup", (e) => this.button(e, false));
    screen.addEventListener("contextmenu", (e) => e.preventDefault());
    window.addEventListener("keydown", (e) => this.key(e, true));
    window.addEventListener("keyup", (e) => this.key(e, false));
  }

  reset() {
    this.pedal = this.camera = this.turning = false;
    this.held = new Set();
    this.padPedal = false;
    this.moves = { gold: [0, 0, 0], green: [0, 0, 0] };
    this.turns = { gold: [0, 0, 0], green: [0, 0, 0] };
  }

  get isLocked() {
    return document.pointerLockElement === this.screen;
  }

  // The axes of the present picture, or null: unknown.
  look(axes) {
    this.view = axes ? { right: axes[0], up: axes[1], into: axes[2] } : VIEW;
    const size = Math.hypot(this.view.right[0], this.view.right[1]);
    const [x, y] = size > 0.1 ? this.view.right.map((v) => v / size) : [1, 0];
    this.level = { right: [x, y, 0], up: [0, 0, 1], into: [-y, x, 0] };
  }

  // Of a direction [right, forward, up]: its parts to the right and up in the picture.
  inPicture(direction) {
    return [this.view.right, this.view.up].map((axis) => axis.reduce((sum, v, i) => sum + v * direction[i], 0));
  }

  // Adds way or angle along the axes of the view, or of the level.
  add(list, axes, right, up, into) {
    list.forEach((_, i) => { list[i] += this.speed * (right * axes.right[i] + up * axes.up[i] + into * axes.into[i]); });
  }

  // The hands move the camera as if they held it, wherever it is.
  get axes() {
    return this.camera ? HELD : this.view;
  }

  mouse(event) {
    if (!this.isLocked) return;
    const [dx, dy] = [event.movementX, event.movementY];
    if (this.turning) this.add(this.turns[this.arm], this.level, -dy * RAD_PER_PIXEL, -dx * RAD_PER_PIXEL, 0);
    else this.add(this.moves[this.arm], this.axes, dx * M_PER_PIXEL, -dy * M_PER_PIXEL, 0);
  }

  wheel(event) {
    if (!this.isLocked) return;
    event.preventDefault();
    const notches = Math.max(-3, Math.min(3, -event.deltaY / NOTCH));
    if (this.turning) this.add(this.turns[this.arm], this.level, 0, 0, notches * RAD_PER_NOTCH);
    else this.add(this.moves[this.arm], this.axes, 0, 0, notches * M_PER_NOTCH);
  }

  button(event, isDown) {
    if (!this.isLocked) return;
    if (event.button === 2) this.turning = isDown;
    if (event.button !== 0) return;
    const arm = isDown ? this.arm : this.gripping || this.arm;  // the other arm may have been chosen meanwhile
    this.jaws[arm] = isDown ? 0 : JAW_OPEN;
    this.gripping = isDown ? arm : null;
  }

  key(event, isDown) {
    const action = Object.keys(this.keys).find((a) => this.keys[a] === event.code);
    if (!action || !this.isActive) return;
    if (isDown && !this.isLocked && document.activeElement !== this.screen) return; // keys elsewhere are the page's own
    if (isDown && (event.ctrlKey || event.altKey || event.metaKey)) return;
    if (!isDown && !this.held.has(action)) return;
    event.preventDefault();
    if (event.repeat) return;
    if (action === "pedal") this.pedal = isDown;
    if (action === "camera") this.camera = isDown;
    if (action === "arm" && isDown) this.arm = this.arm === "gold" ? "green" : "gold";
    if (action === "jaw" && isDown) this.jaws[this.arm] = this.jaws[this.arm] > 0 ? 0 : JAW_OPEN;
    if (isDown) this.held.add(action);
    else this.held.delete(action);
  }

  // Sticks are speeds: called once a frame. Left stick and left trigger are gold, right ones green. @return what the page says of it.
  gamepad(seconds) {
    const pads = [...(navigator.getGamepads ? navigator.getGamepads() : [])].filter((p) => p && p.connected);
    const known = pads.find((p) => p.mapping !== "");  // "": axes and buttons in an order that is not known
    const pad = known || pads[0];
    this.padPedal = false;
    this.pad = known || null;
    if (!pad) return "";
    if (!this.pad) return `Gamepad not used: the browser does not know the layout of ${pad.id}.`;
    const stick = (i) => (Math.abs(pad.axes[i] || 0) > DEAD_BAND ? pad.axes[i] : 0);
    const pressed = (i) => Boolean(pad.buttons[i] && pad.buttons[i].pressed);
    const step = STICK_SPEED * seconds;
    const up = (pressed(12) ? 1 : 0) - (pressed(13) ? 1 : 0);
    const upGreen = (pressed(3) ? 1 : 0) - (pressed(0) ? 1 : 0);
    const axes = this.camera ? HELD : this.level;
    this.add(this.moves.gold, axes, stick(0) * step, up * step, -stick(1) * step);
    this.add(this.moves.green, axes, stick(2) * step, upGreen * step, -stick(3) * step);
    this.padPedal = pressed(4) || pressed(5);
    this.trigger("gold", pad.buttons[6]);
    this.trigger("green", pad.buttons[7]);
    return `Gamepad: ${pad.id}`;
  }

  // Only while it moves: at rest, mouse and key have the jaws.
  trigger(arm, button) {
    if (!button || button.value === this.triggers[arm]) return;
    this.triggers[arm] = button.value;
    this.jaws[arm] = JAW_OPEN * (1 - button.value);
  }

  rumble(strength) {
    const motor = this.pad && this.pad.vibrationActuator;
    if (motor && motor.playEffect) motor.playEffect("dual-rumble", { duration: 120, strongMagnitude: strength, weakMagnitude: strength }).catch(() => {});
  }

  // The motion since the last call, as a message of the hands.
  take(seconds) {
    const roll = (this.held.has("roll_right") ? 1 : 0) - (this.held.has("roll_left") ? 1 : 0);
    this.level.into.forEach((v, i) => { this.turns[this.arm][i] += roll * 1.5 * seconds * v; });
    const message = { pedal: this.pedal || this.padPedal, camera: this.camera, arms: {} };
    for (const arm of ["gold", "green"]) message.arms[arm] = { move: this.moves[arm], turn: this.turns[arm], jaw: this.jaws[arm] };
    this.moves = { gold: [0, 0, 0], green: [0, 0, 0] };
    this.turns = { gold: [0, 0, 0], green: [0, 0, 0] };
    return message;
  }
}
