// The instructor's page: the verdict on the newest session, and the progress of its report and video.

import { byId } from "/static/link.js";
import { page, say } from "/static/instructor_parts.js";

export async function showVerdict(name) {
  page.shown = name;
  byId("verdict").textContent = "The report is being written.";
  const reply = await page.link.ask("verdict", { session: name });
  if (page.shown !== name) return;
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

export function hideVerdict(text) {
  byId("verdict").textContent = text;
  byId("verdict").className = "";
  byId("improve").replaceChildren();
  byId("no-advice").textContent = "";
  for (const id of ["report", "video", "video-link", "progress"]) byId(id).hidden = true;
}

byId("video").addEventListener("click", async () => {
  const reply = await page.link.ask("video", { session: page.shown });
  byId("progress-text").textContent = reply.text;
});

export function showProgress(message) {
  const done = message.share === 1;
  if (message.session === page.shown) {
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
  if (message.session !== page.shown && (message.what === "video" || message.share === null)) sayProgress(message);
}

// Of a session in the list, whose progress has no other place. Percents do not take the place of another text, such as that of an
// emergency stop that is not confirmed.
function sayProgress({ session, what, share, text }) {
  const isPercent = share !== null && share < 1;
  if (isPercent && !/^($|The video |Video of )/.test(byId("said").textContent)) return;
  say({ ok: share !== null, text: share === null ? `The ${what} of ${session} failed: ${text}`
    : share === 1 ? `The video of ${session} is ready.` : `Video of ${session}: ${Math.round(100 * share)} %` });
}
