// The instructor's page: the running session. The other parts: set_up.js, verdict.js, tabs.js.

import { byId, Link, Picture, showHealth, showTask } from "/static/link.js";
import { Strip } from "/static/charts.js";
import { page, plain, say, sentence } from "/static/instructor_parts.js";
import { hazardInSetUp, setUpAs, showLibrary, showStage } from "/static/set_up.js";
import { showProgress, showVerdict } from "/static/verdict.js";
import { closeQuestion, refreshTab } from "/static/tabs.js";

const pictures = { view: new Picture(byId("picture")), second: new Picture(byId("second-picture")) };

const strips = {
  apart: new Strip(byId("strip-error"), "Distance, robot to model", "mm", 5, 3),
  force: new Strip(byId("strip-force"), "Force on the hands", "N", 2),
};

const PLANS = { choosing: "the hands show the goal", planning: "is being made", ready: "ready", armed: "press the pedal", executing: "the arm moves" };
const IN_SESSION = ["pause", "restart", "inject", "stop-hazard", "view", "plan", "execute", "execute-robot", "cancel-plan", "repeat-trial", "repeat-robot"];
// Each asks for what it is called.
const PRACTICE = ["begin-simulation", "end-simulation", "begin-trial", "end-trial", "discard-trial", "disengage", "engage", "press-start"];
let lastPicture = 0;

const link = new Link("instructor", {
  library: (m) => { page.library = m; showLibrary(); },
  mode: showMode,
  robot: (m) => { byId("robot").textContent = m.text; },
  health: showHealth,
  alive: showHealth,
  station: showStation,
  exercise: (m) => showTask(m, exerciseOf(m.exercise).steps, exerciseOf(m.exercise).tracks),
  plan: (m) => { byId("plan-text").textContent = m.status === "idle" ? "" : `Plan: ${PLANS[m.status] || m.status}`; },
  strips: showStrips,
  progress: (m) => { showProgress(m); if (m.share === 1) refreshTab(); },
}, showPicture, showOpen);
page.link = link;

function showOpen(isOpen) {
  if (isOpen && page.shown) showVerdict(page.shown);  // a report may have come meanwhile
  if (!isOpen) showHealth({ level: 2, text: "The station does not answer. Trying again." });
  if (isOpen) wantPictures();
}

function wantPictures() {
  return link.wantPictures(byId("second").open ? ["view", "second"] : ["view"]);
}

function exerciseOf(name) {
  return (page.library && page.library.exercises.find((e) => e.name === name)) || { title: "free session", steps: [], tracks: [] };
}

function showPicture(which, blob) {
  lastPicture = performance.now();
  pictures[which].show(blob);
}

function showMode(message) {
  page.mode = message;
  const stopped = message.mode === "stopped";
  byId("mode").textContent = message.text + (!message.pedal ? "" : message.mode === "paused" ? " (release it first)" : " (pedal down)");
  byId("clear-stop").hidden = !stopped;
  byId("end-replay").hidden = message.mode !== "replaying";
  byId("view").setAttribute("aria-pressed", message.view === "real");
  byId("view").textContent = message.view === "real" ? "Show virtual scene" : "Show real camera";
}

function showStation(message) {
  const before = page.station;
  page.station = message;
  const own = message.phase === "running";
  const runs = own || message.foreign;
  byId("start").disabled = message.phase !== "idle" || message.foreign;
  byId("next").disabled = !message.choice || message.replay || message.foreign || message.phase === "starting" || message.phase === "ending";
  byId("next").textContent = own && !message.replay ? "Stop and next attempt" : "Next attempt";
  byId("stop").disabled = !own;
  for (const id of [...IN_SESSION, ...PRACTICE]) byId(id).disabled = !runs;
  byId("take-hands").setAttribute("aria-pressed", message.hands_away);
  byId("take-hands").textContent = message.hands_away ? "Give the hands back" : "Take the hands away";
  if (!runs) {
    byId("mode").textContent = { idle: "No session", starting: "Starting", ending: "Ending" }[message.phase];
    byId("robot").textContent = "";
    byId("clear-stop").hidden = byId("end-replay").hidden = true;
  }
  if (message.foreign && !before.foreign) say({ ok: true, text: "This trainer was not started here. Set up and Stop belong to its launch file." });
  if (message.phase === "idle" && before.phase !== "idle") {
    if (before.phase === "ending") say({ ok: !message.trouble, text: message.trouble || "The session has ended." });
    showStage();
  }
  const whose = message.choice ? message.choice.trainee || "guest" : "";
  byId("act-title").textContent = message.replay ? "Replay" : runs && whose ? `Session of ${whose}: ${exerciseOf(message.choice.exercise).title}` : "Session";
  if (runs && message.choice && !before.choice && !message.replay) setUpAs(message.choice);
  if (message.last && message.last !== before.last && message.choice) page.newest = message.choice.trainee;
  showArmed();
  showNext();
  if (message.last && (message.last !== before.last || page.shown === "")) showVerdict(message.last);
}

function showArmed() {
  const choice = page.station.choice;
  let name = choice ? choice.hazard : "none";
  if (name === "own" && page.library) name = (page.library.exercises.find((e) => e.name === choice.exercise) || {}).drill || "none";
  const hazard = page.library && page.library.hazards.find((h) => h.name === name);
  byId("armed").textContent = hazard ? `${hazard.title}. ${choice.when === "own" ? "It comes by itself." : "It comes when you press Inject now."}`
    : "No hazard chosen: Inject now uses the one in Set up.";
}

function showNext() {
  const choice = page.station.choice;
  const hazard = choice && choice.hazard !== "none" ? `, hazard ${choice.hazard === "own" ? "of the exercise" : plain(choice.hazard)}` : "";
  byId("next-help").textContent = !choice || page.station.replay ? "" : choice.curriculum
    ? `Next attempt: ${choice.trainee || "guest"}, ${plain(choice.curriculum)}, the stage by then.`
    : `Next attempt: ${choice.trainee || "guest"}, ${choice.exercise === "none" ? "free session" : plain(choice.exercise)}${hazard}, as last time.`;
}

function showStrips(message) {
  const now = performance.now() / 1000;
  const mm = (v) => (v === null || v === undefined ? null : 1000 * v);
  strips.apart.add(now, { gold: mm(message.apart.gold), green: mm(message.apart.green) });
  strips.force.add(now, message.force);
}

setInterval(() => {
  if (document.hidden) return;
  const now = performance.now();
  strips.apart.draw(now / 1000);
  strips.force.draw(now / 1000);
  byId("picture-note").hidden = now - lastPicture < 1500;
  byId("picture-note").textContent = page.station.phase === "running" || page.station.foreign ? "No picture comes from the trainer." : "No picture: no session is running.";
}, 100);

function press(id, what, given = () => ({})) {
  byId(id).addEventListener("click", async () => {
    say({ ok: true, text: `${byId(id).textContent} …` });  // some answers take seconds
    const reply = await link.ask(what, given());
    say({ ok: reply.ok, text: sentence(reply.text || (reply.ok ? "done" : "it did not happen")) });
  });
}

press("next", "next");
press("stop", "stop");
press("pause", "pause");
press("restart", "restart-exercise");
press("end-replay", "end-replay");

byId("emergency-stop").addEventListener("click", async () => {
  const reply = await link.ask("emergency-stop");
  say({ ok: reply.ok, text: reply.ok ? "Stopped." : `The emergency stop is not confirmed. ${sentence(reply.text)} Use the stop button of the robot.` });
});

press("clear-stop", "clear-stop");
press("inject", "inject", () => (page.station.choice && page.station.choice.hazard !== "none" ? {} : { hazard: hazardInSetUp() }));
press("stop-hazard", "stop-hazard");
press("view", "view", () => ({ real: page.mode.view !== "real" }));
press("take-hands", "take-hands", () => ({ away: !page.station.hands_away }));
press("plan", "plan");
press("execute", "execute", () => ({ on_robot: false }));
press("execute-robot", "execute", () => ({ on_robot: true }));
press("cancel-plan", "cancel-plan");
press("repeat-trial", "repeat-trial", () => ({ on_robot: false }));
press("repeat-robot", "repeat-trial", () => ({ on_robot: true }));
for (const id of PRACTICE) press(id, id);

// A button that was clicked with the mouse would take the next press of the space bar for itself, and so would a list.
document.addEventListener("click", (event) => {
  const pressed = event.target.closest("button, a, summary");
  if (event.detail > 0 && pressed) pressed.blur();
});

let isPointing = false;  // the last input was the mouse's
document.addEventListener("pointerdown", () => { isPointing = true; });
document.addEventListener("keydown", () => { isPointing = false; });
document.addEventListener("change", (event) => { if (isPointing && event.target.tagName === "SELECT") event.target.blur(); });

// In the question whether to delete, the space bar stops as well: it must not answer.
const isQuestion = () => byId("sure").contains(document.activeElement);

document.addEventListener("keydown", (event) => {
  if (event.code === "Escape" && byId("sure").open) closeQuestion();
  const typing = ["INPUT", "SELECT", "TEXTAREA", "BUTTON", "A", "SUMMARY"].includes(document.activeElement.tagName) && !isQuestion();
  if (event.code !== "Space" || typing) return;
  event.preventDefault();
  if (!event.repeat) byId("emergency-stop").click();
});

document.addEventListener("keyup", (event) => { if (event.code === "Space" && isQuestion()) event.preventDefault(); });
byId("second").addEventListener("toggle", wantPictures);
