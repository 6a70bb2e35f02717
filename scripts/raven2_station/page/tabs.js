// The instructor's page, tabs: result, history of a trainee, class, sessions.

import { byId, fill, option } from "/static/link.js";
import { drawCurve } from "/static/charts.js";
import { action, anchor, driverText, hazardsOf, number, page, passed, plain, row, say, when } from "/static/instructor_parts.js";
import { hideVerdict } from "/static/verdict.js";

const TABS = ["result", "history", "class", "sessions"];

function openTab(name) {
  for (const tab of TABS) {
    byId(tab).hidden = tab !== name;
    byId(`tab-${tab}`).setAttribute("aria-selected", tab === name);
  }
  refreshTab();
}

for (const tab of TABS) byId(`tab-${tab}`).addEventListener("click", () => openTab(tab));

export function refreshTab() {
  if (!byId("history").hidden) showHistory();
  if (!byId("class").hidden) showClass();
  if (!byId("sessions").hidden) showSessions();
}

async function showHistory() {
  const list = await page.link.ask("sessions");
  if (list.ok) fill(byId("history-trainee"), list.more.trainees.map((t) => option(t, t)));
  if (list.ok) fill(byId("trainees"), list.more.trainees.map((t) => option(t, t)), false);
  if (list.ok && list.more.trainees.includes(page.newest)) byId("history-trainee").value = page.newest;
  page.newest = "";
  const trainee = byId("history-trainee").value;
  const reply = trainee ? await page.link.ask("history", { trainee }) : { ok: false };
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
  const reply = await page.link.ask("class", { curriculum });
  if (!reply.ok) return;
  byId("class-title").textContent = reply.more.title;
  byId("class-table").replaceChildren(row(["trainee", "sessions", ...reply.more.titles, "last session"], "th"),
    ...reply.more.rows.map((r) => row([r.trainee, r.demonstrations ? `${r.sessions} (${r.demonstrations} demonstrated)` : String(r.sessions),
      ...r.stages.map(stageCell),
      when(r.last)])));
}

byId("curriculum").addEventListener("change", () => { if (!byId("class").hidden) showClass(); });

async function showSessions() {
  const reply = await page.link.ask("sessions");
  if (!reply.ok) return;
  byId("session-table").replaceChildren(row(["when", "session", "trainee", "exercise", "hazard", "moved by", "result", "length"], "th"));
  addSessions(reply.more);
}

function addSessions({ sessions, count }) {
  const table = byId("session-table");
  table.append(...sessions.flatMap((s) => {
      const files = document.createElement("span");
      files.className = "buttons";
      files.append(s.report ? anchor("Report", `/sessions/${s.name}/report.html`) : action("Write report", async () => say(await page.link.ask("report", { session: s.name })), "write-report"));
      files.append(s.video ? anchor("Video", `/sessions/${s.name}/video.mp4`) : action("Render video", async () => say(await page.link.ask("video", { session: s.name })), "render-video"));
      files.append(action("Replay", async () => say(await page.link.ask("replay", { session: s.name })), "replay"));
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
    const reply = await page.link.ask("sessions", { skip: listed });
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
export function closeQuestion(event) {
  byId("sure").close();
  if (!askedByKey || (event && event.detail > 0)) document.activeElement.blur();
}

byId("sure-no").addEventListener("click", closeQuestion);

byId("sure-yes").addEventListener("click", async (event) => {
  closeQuestion(event);
  const name = byId("sure").dataset.session;
  const reply = await page.link.ask("delete", { session: name, sure: true });
  say(reply);
  if (reply.ok && name === page.shown) hideVerdict("The session was deleted.");
  refreshTab();
});
