// The instructor's page.

import { byId, fill, Link, option, Picture, showHealth, showTask } from "/static/link.js";
import { drawCurve, Strip } from "/static/charts.js";

const pictures = { view: new Picture(byId("picture")), camera: new Picture(byId("camera")) };
const strips = {
  apart: new Strip(byId("strip-error"), "Distance, robot to model", "mm", 5, 3),
  force: new Strip(byId("strip-force"), "Force on the hands", "N", 2),
};
const PLANS = { choosing: "the hands show the goal", planning: "is being made", ready: "ready", armed: "press the pedal", executing: "the arm moves" };
let library = null;
let station = { phase: "idle" };
let mode = { mode: "", view: "virtual" };
let lastPicture = 0;
let shown = "";  // session of the verdict
let newest = "";  // trainee of the last session, until the tab Trainee has shown it

const link = new Link("instructor", {
  library: (m) => { library = m; showLibrary(); },
  mode: showMode,
  robot: (m) => { byId("robot").textContent = m.text; },
  health: showHealth,
  alive: showHealth,
  station: showStation,
  exercise: (m) => showTask(m, exerciseOf(m.exercise).steps, exerciseOf(m.exercise).tracks),
  plan: (m) => { byId("plan-text").textContent = m.status === "idle" ? "" : `Plan: ${PLANS[m.status] || m.status}`; },
  strips: showStrips,
  progress: showProgress,
}, showPicture, showOpen);

function showOpen(isOpen) {
  if (isOpen && shown) showVerdict(shown);  // a report may have come meanwhile
  if (!isOpen) showHealth({ level: 2, text: "The station does not answer. Trying again." });
  if (isOpen) wantPictures();
}

function wantPictures() {
  return link.wantPictures(byId("second").open ? ["view", "camera"] : ["view"]);
}

function exerciseOf(name) {
  return (library && library.exercises.find((e) => e.name === name)) || { title: "free session", steps: [], tracks: [] };
}

function showPicture(which, blob) {
  lastPicture = performance.now();
  pictures[which].show(blob);
}

function showMode(message) {
  mode = message;
  const stopped = message.mode === "stopped";
  byId("mode").textContent = message.text + (!message.pedal ? "" : message.mode === "paused" ? " (release it first)" : " (pedal down)");
  byId("clear-stop").hidden = !stopped;
  byId("end-replay").hidden = message.mode !== "replaying";
  byId("view").setAttribute("aria-pressed", message.view === "real");
  byId("view").textContent = message.view === "real" ? "Show virtual scene" : "Show real camera";
}

function showStation(message) {
  const before = station;
  station = message;
  const own = message.phase === "running";
  const runs = own || message.foreign;
  byId("start").disabled = message.phase !== "idle" || message.foreign;
  byId("next").disabled = !message.choice || message.replay || message.foreign || message.phase === "starting" || message.phase === "ending";
  byId("next").textContent = own && !message.replay ? "Stop and next attempt" : "Next attempt";
  byId("stop").disabled = !own;
  for (const id of ["pause", "restart", "inject", "stop-hazard", "view", "plan", "execute", "execute-robot", "cancel-plan"]) byId(id).disabled = !runs;
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
  if (message.last && message.last !== before.last && message.choice) newest = message.choice.trainee;
  showArmed();
  showNext();
  if (message.last && (message.last !== before.last || shown === "")) showVerdict(message.last);
}

function showArmed() {
  const choice = station.choice;
  let name = choice ? choice.hazard : "none";
  if (name === "own" && library) name = (library.exercises.find((e) => e.name === choice.exercise) || {}).drill || "none";
  const hazard = library && library.hazards.find((h) => h.name === name);
  byId("armed").textContent = hazard ? `${hazard.title}. ${choice.when === "own" ? "It comes by itself." : "It comes when you press Inject."}`
    : "No hazard chosen: Inject uses the one in Set up.";
}

function showNext() {
  const choice = station.choice;
  const hazard = choice && choice.hazard !== "none" ? `, hazard ${choice.hazard === "own" ? "of the exercise" : plain(choice.hazard)}` : "";
  byId("next-help").textContent = !choice || station.replay ? "" : choice.curriculum
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
  byId("picture-note").textContent = station.phase === "running" || station.foreign ? "No picture comes from the trainer." : "No picture: no session is running.";
}, 100);

// ---- set up

const SEVERITY = { high: "Severe", medium: "Moderate", low: "Light", none: "No harm expected" };
const plain = (name) => (name || "").replaceAll("_", " ");
const DRIVERS = { browser: "mouse, keyboard or gamepad", expert: "demonstration: expert surgeon", scripted: "demonstration: scripted motion" };
const clumsy = (name) => library.clumsy[name] || plain(name);

function driverText(driver) {
  if (driver.startsWith("clumsy:")) return `demonstration: surgeon who ${clumsy(driver.slice(7))}`;
  return DRIVERS[driver] || plain(driver.replace("master:", "hand device: "));
}

function showLibrary() {
  fill(byId("trainees"), library.trainees.map((t) => option(t, t)), false);
  fill(byId("history-trainee"), library.trainees.map((t) => option(t, t)));
  fill(byId("curriculum"), [option("", "none: choose the exercise"), ...library.curricula.map((c) => option(c.name, c.title))]);
  fill(byId("exercise"), [option("none", "free session"), ...library.exercises.map((e) => option(e.name, `${plain(e.name)}: ${e.title}`))]);
  fill(byId("link"), library.links.map((l) => option(l.name, l.name === "none" ? "good link" : plain(l.name))));
  showChoices();
}

function hazardGroups() {
  return Object.entries(SEVERITY).map(([severity, title]) => {
    const group = document.createElement("optgroup");
    group.label = title;
    group.append(...library.hazards.filter((h) => h.severity === severity).map((h) => option(h.name, h.title)));
    return group;
  }).filter((group) => group.children.length);
}

function driverHelp(driver) {
  if (driver === "browser") return "Press Take the hands on the trainee's page.";
  if (!driver.startsWith("master:")) return "A simulated surgeon moves the arms. With a trainee's ID, the attempt counts for the trainee.";
  return `${library.masters.find((m) => m.name === driver.slice(7)).title}. Start its driver after the station.`;
}

// `own` is of the exercise in Set up. Another one may run.
function hazardInSetUp() {
  const exercise = library.exercises.find((e) => e.name === byId("exercise").value);
  return byId("hazard").value === "own" && exercise ? exercise.drill : byId("hazard").value;
}

function showChoices() {
  const exercise = library.exercises.find((e) => e.name === byId("exercise").value);
  const hazards = [option("none", "none")];
  if (exercise && exercise.drill) hazards.push(option("own", `the exercise's own: ${plain(exercise.drill)}`));
  fill(byId("hazard"), [...hazards, ...hazardGroups()]);
  const drivers = ["browser"];
  if (exercise && exercise.expert) drivers.push("expert");
  if (exercise) drivers.push(...exercise.clumsy.map((name) => `clumsy:${name}`));
  if (!exercise) drivers.push("scripted");
  fill(byId("driver"), [...drivers, ...library.masters.map((m) => `master:${m.name}`)].map((d) => option(d, driverText(d))));
  byId("exercise-help").textContent = exercise ? `Time limit ${exercise.time_limit} s. Trains: ${exercise.skills.join(", ").replaceAll("_", " ")}.`
    : "The arms move freely; nothing is scored.";
  const hazard = library.hazards.find((h) => h.name === hazardInSetUp());
  byId("hazard-help").textContent = hazard ? `${hazard.expected} Right response: ${hazard.response}` : "Nothing goes wrong.";
  byId("driver-help").textContent = `${driverHelp(byId("driver").value)} `;
  if (byId("driver").value === "browser") byId("driver-help").append(anchor("Open it", "/trainee"));
  const linkName = byId("link").value;
  byId("link-help").textContent = linkName === "none" ? "A bad link delays or loses motion between console and trainer."
    : `Between console and trainer: ${library.links.find((l) => l.name === linkName).title}.`;
  for (const id of ["exercise", "hazard", "when"]) byId(id).disabled = byId("curriculum").value !== "";
}

// A curriculum shows its stage in the fields that it decides.
async function showStage() {
  const curriculum = byId("curriculum").value;
  if (!curriculum) {
    byId("stage").textContent = "With a curriculum, the trainee's stage chooses exercise and hazard.";
    return showChoices();
  }
  const reply = await link.ask("stage", { curriculum, trainee: byId("trainee").value.trim() });
  if (!reply.ok || byId("curriculum").value !== curriculum) return undefined;
  const { stages, current } = reply.more;
  if (current === stages.length) {
    byId("stage").textContent = `All ${stages.length} stages are done. Choose another curriculum, or none.`;
    return showChoices();
  }
  const stage = stages[current];
  const more = stage.extra ? `, ${stage.more} of ${stage.extra} more` : "";
  byId("stage").textContent = `Stage ${current + 1} of ${stages.length}: ${stage.title}. Passed ${stage.in_a_row} of ${stage.passes} in a row${more}.`;
  byId("exercise").value = stage.exercise;
  showChoices();
  byId("hazard").value = stage.drill || "none";
  byId("when").value = "own";
  return showChoices();
}

for (const id of ["curriculum", "trainee"]) byId(id).addEventListener("change", showStage);
byId("curriculum").addEventListener("change", () => { if (!byId("class").hidden) showClass(); });
for (const id of ["exercise", "hazard", "driver", "link"]) byId(id).addEventListener("change", showChoices);

// A page that is opened again shows the session that runs.
function setUpAs(choice) {
  if (!library) return;
  byId("trainee").value = choice.trainee;
  byId("curriculum").value = choice.curriculum;
  byId("exercise").value = choice.exercise;
  showChoices();
  for (const id of ["hazard", "when", "driver", "link"]) byId(id).value = choice[id];
  showChoices();
  showStage();
}

function settings() {
  return {
    trainee: byId("trainee").value.trim(), curriculum: byId("curriculum").value, exercise: byId("exercise").value,
    hazard: byId("hazard").value, when: byId("when").value, link: byId("link").value, driver: byId("driver").value,
    seed: -1,
  };
}

const sentence = (text) => text.charAt(0).toUpperCase() + text.slice(1).replace(/\.?$/, ".");

function say(reply) {
  byId("said").textContent = reply.text;
  byId("said").className = reply.ok ? "good" : "bad";
}

byId("form").addEventListener("submit", async (event) => {
  event.preventDefault();
  byId("start").disabled = true;  // against a second click
  say({ ok: true, text: "The session starts." });
  const reply = await link.ask("start", settings());
  say(reply);
  if (!reply.ok) byId("start").disabled = station.phase !== "idle" || Boolean(station.foreign);
});

function press(id, what, given = () => ({})) {
  byId(id).addEventListener("click", async () => {
    say({ ok: true, text: `${byId(id).textContent} …` });  // some answers take seconds
    const reply = await link.ask(what, given());
    say({ ok: reply.ok, text: reply.text || (reply.ok ? "Done." : "It did not happen.") });
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
press("inject", "inject", () => (station.choice && station.choice.hazard !== "none" ? {} : { hazard: hazardInSetUp() }));
press("stop-hazard", "stop-hazard");
press("view", "view", () => ({ real: mode.view !== "real" }));
press("take-hands", "take-hands", () => ({ away: !station.hands_away }));
press("plan", "plan");
press("execute", "execute", () => ({ on_robot: false }));
press("execute-robot", "execute", () => ({ on_robot: true }));
press("cancel-plan", "cancel-plan");

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

// ---- learn

async function showVerdict(name) {
  shown = name;
  byId("verdict").textContent = "The report is being written.";
  const reply = await link.ask("verdict", { session: name });
  if (shown !== name) return;
  if (!reply.ok) return hideVerdict(reply.text);
  const verdict = reply.more;
  const hasReport = verdict.headline !== "No report yet";
  byId("verdict").textContent = hasReport ? verdict.headline : verdict.trouble ? "There is no report." : "The report is being written.";
  if (verdict.trouble) byId("progress-text").textContent = `The report failed: ${verdict.trouble}`;
  byId("verdict").className = verdict.passed === true ? "good" : verdict.passed === false ? "bad" : "";
  byId("improve").replaceChildren(...verdict.improve.map((advice) => {
    const item = document.createElement("li");
    item.textContent = advice.how ? `${advice.what}: ${advice.how}` : advice.what;
    return item;
  }));
  byId("no-advice").textContent = verdict.improve.length ? "" : verdict.no_advice;
  byId("report").hidden = !hasReport;
  byId("report").href = `/sessions/${name}/report.html`;
  byId("video").hidden = !hasReport;
  byId("video-link").hidden = !verdict.video;
  byId("video-link").href = `/sessions/${name}/video.mp4`;
  return undefined;
}

function hideVerdict(text) {
  byId("verdict").textContent = text;
  byId("verdict").className = "";
  byId("improve").replaceChildren();
  byId("no-advice").textContent = "";
  for (const id of ["report", "video", "video-link", "progress"]) byId(id).hidden = true;
}

byId("video").addEventListener("click", async () => {
  const reply = await link.ask("video", { session: shown });
  byId("progress-text").textContent = reply.text;
});

function showProgress(message) {
  const done = message.share === 1;
  if (message.session === shown) {
    byId("progress").hidden = done || message.share === null;
    byId("progress").value = message.share || 0;
    byId("progress-text").textContent = message.share === null ? `The ${message.what} failed: ${message.text}`
      : done ? "" : `${message.what} ${Math.round(100 * message.share)} %`;
    if (message.what === "report" && done) showVerdict(message.session);
    if (message.what === "report" && message.share === null) byId("verdict").textContent = "There is no report.";
    if (message.what === "video" && done) {
      byId("video-link").hidden = false;
      byId("video-link").href = `/sessions/${message.session}/video.mp4`;
    }
  }
  if (message.session !== shown && (message.what === "video" || message.share === null)) sayProgress(message);
  if (done) refreshTab();
}

// Of a session in the list, whose progress has no other place. Percents do not take the place of another text, such as that of an
// emergency stop that is not confirmed.
function sayProgress({ session, what, share, text }) {
  const isPercent = share !== null && share < 1;
  if (isPercent && !/^($|The video |Video of )/.test(byId("said").textContent)) return;
  say({ ok: share !== null, text: share === null ? `The ${what} of ${session} failed: ${text}`
    : share === 1 ? `The video of ${session} is ready.` : `Video of ${session}: ${Math.round(100 * share)} %` });
}

const TABS = ["result", "history", "class", "sessions"];

function openTab(name) {
  for (const tab of TABS) {
    byId(tab).hidden = tab !== name;
    byId(`tab-${tab}`).setAttribute("aria-selected", tab === name);
  }
  refreshTab();
}

for (const tab of TABS) byId(`tab-${tab}`).addEventListener("click", () => openTab(tab));

function refreshTab() {
  if (!byId("history").hidden) showHistory();
  if (!byId("class").hidden) showClass();
  if (!byId("sessions").hidden) showSessions();
}

function row(cells, tag = "td") {
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
function when(utc) {
  const time = new Date(utc);
  return Number.isNaN(time.getTime()) ? "" : time.toLocaleString("sv-SE", { dateStyle: "short", timeStyle: "short" });
}

// The hazards that acted; else the drill that did not come.
function hazardsOf(session) {
  if (session.hazards.length) return session.hazards.map(plain).join(", ");
  return session.drill && session.drill !== "none" ? `${plain(session.drill)} (did not act)` : "none";
}

const passed = (value) => (value === true ? "passed" : value === false ? "not passed" : "not judged");
const number = (value, unit) => (typeof value === "number" ? `${value.toFixed(1)} ${unit}` : "");

async function showHistory() {
  const list = await link.ask("sessions");
  if (list.ok) fill(byId("history-trainee"), list.more.trainees.map((t) => option(t, t)));
  if (list.ok) fill(byId("trainees"), list.more.trainees.map((t) => option(t, t)), false);
  if (list.ok && list.more.trainees.includes(newest)) byId("history-trainee").value = newest;
  newest = "";
  const trainee = byId("history-trainee").value;
  const reply = trainee ? await link.ask("history", { trainee }) : { ok: false };
  if (trainee !== byId("history-trainee").value) return;  // another one was chosen meanwhile
  const all = reply.ok ? reply.more.attempts : [];
  const exercises = [...new Set(all.map((a) => a.exercise))].sort();
  if (reply.ok) fill(byId("history-exercise"), [option("", "all"), ...exercises.map((e) => option(e, plain(e)))]);
  const chosen = byId("history-exercise").value;  // times of two exercises cannot be compared
  const attempts = all.filter((a) => chosen === "" || a.exercise === chosen);
  drawCurve(byId("curve"), attempts);
  byId("history-table").replaceChildren(row(["when", "exercise", "hazard", "moved by", "result", "score", "time", "time to answer"], "th"),
    ...attempts.map((a) => row([when(a.start), plain(a.exercise), hazardsOf(a), driverText(a.driver), passed(a.passed), number(typeof a.score === "number" ? 100 * a.score : null, "%"), number(a.time, "s"),
      number(a.response, "s")])));
}

for (const choice of ["history-trainee", "history-exercise"]) byId(choice).addEventListener("change", showHistory);

function stageCell(stage) {
  if (stage.done) return `done (${stage.attempts} ${stage.attempts === 1 ? "attempt" : "attempts"})`;
  if (stage.attempts === 0) return "";
  return `${stage.in_a_row} of ${stage.passes} in a row` + (stage.extra ? `, ${stage.more} of ${stage.extra} more` : "") + ` (${stage.attempts} ${stage.attempts === 1 ? "attempt" : "attempts"})`;
}

async function showClass() {
  const curriculum = byId("curriculum").value;
  byId("class-csv").href = `/class.csv?curriculum=${encodeURIComponent(curriculum)}`;
  const reply = await link.ask("class", { curriculum });
  if (!reply.ok) return;
  byId("class-title").textContent = reply.more.title;
  byId("class-table").replaceChildren(row(["trainee", "sessions", ...reply.more.titles, "last session"], "th"),
    ...reply.more.rows.map((r) => row([r.trainee, r.demonstrations ? `${r.sessions} (${r.demonstrations} demonstrated)` : String(r.sessions),
      ...r.stages.map(stageCell),
      when(r.last)])));
}

function anchor(text, href, download = false) {
  const element = document.createElement("a");
  element.className = "button";
  element.textContent = text;
  element.href = href;
  if (download) element.download = "";
  else Object.assign(element, { target: "_blank", rel: "noopener" });
  return element;
}

function action(text, run, name) {
  const element = document.createElement("button");
  element.type = "button";
  element.textContent = text;
  element.dataset.test = name;
  element.addEventListener("click", run);
  return element;
}

async function showSessions() {
  const reply = await link.ask("sessions");
  if (!reply.ok) return;
  byId("session-table").replaceChildren(row(["when", "session", "trainee", "exercise", "hazard", "moved by", "result", "length"], "th"));
  addSessions(reply.more);
}

function addSessions({ sessions, count }) {
  const table = byId("session-table");
  table.append(...sessions.flatMap((s) => {
      const files = document.createElement("span");
      files.className = "buttons";
      files.append(s.report ? anchor("Report", `/sessions/${s.name}/report.html`) : action("Write report", async () => say(await link.ask("report", { session: s.name })), "write-report"));
      files.append(s.video ? anchor("Video", `/sessions/${s.name}/video.mp4`) : action("Render video", async () => say(await link.ask("video", { session: s.name })), "render-video"));
      files.append(action("Replay", async () => say(await link.ask("replay", { session: s.name })), "replay"));
      files.append(anchor("Log", `/sessions/${s.name}/session.rlog?download`, true));
      files.append(action("Delete", (event) => askToDelete(s.name, event.detail === 0), "delete"));
      const what = row([when(s.start), s.name, s.trainee, s.exercise === "none" ? "free session" : plain(s.exercise), hazardsOf(s), driverText(s.driver), passed(s.passed),
        number(s.duration, "s")]);
      what.className = "what";
      const how = row([files]);
      how.cells[0].colSpan = what.cells.length;
      return [what, how];
  }));
  const listed = table.querySelectorAll(".what").length;
  if (listed >= count) return;
  const more = row([action(`Show older sessions (${count - listed})`, async () => {
    const reply = await link.ask("sessions", { skip: listed });
    more.remove();
    if (reply.ok) addSessions(reply.more);
  }, "older")]);
  table.append(more);
}

let askedByKey = false;  // the button Delete was pressed with the keyboard

function askToDelete(name, isKey) {
  byId("sure-text").textContent = `Delete session ${name} with all its files? This cannot be undone.`;
  byId("sure").dataset.session = name;
  askedByKey = isKey;
  byId("sure").show();  // not modal: the emergency stop stays within reach
  byId("sure-no").focus();
}

// The browser gives the focus back to the button Delete. There the space bar asks again instead of stopping the robot, so only
// the keyboard's user keeps it.
function closeQuestion(event) {
  byId("sure").close();
  if (!askedByKey || (event && event.detail > 0)) document.activeElement.blur();
}

byId("sure-no").addEventListener("click", closeQuestion);
byId("sure-yes").addEventListener("click", async (event) => {
  closeQuestion(event);
  const name = byId("sure").dataset.session;
  const reply = await link.ask("delete", { session: name, sure: true });
  say(reply);
  if (reply.ok && name === shown) hideVerdict("The session was deleted.");
  refreshTab();
});
