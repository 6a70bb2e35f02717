// The parts of the instructor's page share this: its state, and words, rows, buttons and links of its tables.

import { byId } from "/static/link.js";

// All parts read it, some write it.
export const page = {
  library: null,
  station: { phase: "idle" },
  mode: { mode: "", view: "virtual" },
  shown: "",  // session of the verdict
  newest: "",  // trainee of the last session, until the tab Trainee has shown it
  link: null,  // to the station
};

export const plain = (name) => (name || "").replaceAll("_", " ");
const DRIVERS = { browser: "mouse, keyboard or gamepad", expert: "demonstration: expert surgeon", scripted: "demonstration: scripted motion" };
const clumsy = (name) => page.library.clumsy[name] || plain(name);

export function driverText(driver) {
  if (driver.startsWith("clumsy:")) return `demonstration: surgeon who ${clumsy(driver.slice(7))}`;
  return DRIVERS[driver] || plain(driver.replace("master:", "hand device: "));
}

export const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1).replace(/\.?$/, ".");

export function say(reply) {
  byId("said").textContent = reply.text;
  byId("said").className = reply.ok ? "good" : "bad";
}

export function row(cells, tag = "td") {
  const line = document.createElement("tr");
  for (const cell of cells) {
    const element = document.createElement(tag);
    if (cell instanceof Node) element.append(cell);
    else element.textContent = cell;
    line.append(element);
  }
  return line;
}

// Times of the records are UTC; people see those of their clock.
export function when(utc) {
  const time = new Date(utc);
  return Number.isNaN(time.getTime()) ? "" : time.toLocaleString("sv-SE", { dateStyle: "short", timeStyle: "short" });
}

// The hazards that acted; else the drill that did not come.
export function hazardsOf(session) {
  if (session.hazards.length) return session.hazards.map(plain).join(", ");
  return session.drill && session.drill !== "none" ? `${plain(session.drill)} (did not act)` : "none";
}

export const passed = (value) => (value === true ? "passed" : value === false ? "not passed" : "not judged");
export const number = (value, unit) => (typeof value === "number" ? `${value.toFixed(1)} ${unit}` : "");

export function anchor(text, href, download = false) {
  const element = document.createElement("a");
  element.className = "button";
  element.textContent = text;
  element.href = href;
  if (download) element.download = "";
  else Object.assign(element, { target: "_blank", rel: "noopener" });
  return element;
}

export function action(text, run, name) {
  const element = document.createElement("button");
  element.type = "button";
  element.textContent = text;
  element.dataset.test = name;
  element.addEventListener("click", run);
  return element;
}
