// The instructor's page, Set up: the choices for the next session.

import { byId, fill, option } from "/static/link.js";
import { anchor, driverText, page, plain, say } from "/static/instructor_parts.js";

const SEVERITY = { high: "Severe", medium: "Moderate", low: "Light", none: "No harm on record" };

export function showLibrary() {
  fill(byId("trainees"), page.library.trainees.map((t) => option(t, t)), false);
  fill(byId("history-trainee"), page.library.trainees.map((t) => option(t, t)));
  fill(byId("curriculum"), [option("", "none: choose the exercise"), ...page.library.curricula.map((c) => option(c.name, c.title))]);
  fill(byId("exercise"), [option("none", "free session"), ...page.library.exercises.map((e) => option(e.name, `${plain(e.name)}: ${e.title}`))]);
  fill(byId("link"), page.library.links.map((l) => option(l.name, l.name === "none" ? "good link" : plain(l.name))));
  showChoices();
}

function hazardGroups() {
  return Object.entries(SEVERITY).map(([severity, title]) => {
    const group = document.createElement("optgroup");
    group.label = title;
    group.append(...page.library.hazards.filter((h) => h.severity === severity).map((h) => option(h.name, h.title)));
    return group;
  }).filter((group) => group.children.length);
}

function driverHelp(driver) {
  if (driver === "browser") return "Press Take the hands on the trainee's page.";
  if (!driver.startsWith("master:")) return "A simulated surgeon moves the arms. With a trainee's ID, the attempt counts for the trainee.";
  return `${page.library.masters.find((m) => m.name === driver.slice(7)).title}. Start its driver after the station.`;
}

// `own` is of the exercise in Set up. Another one may run.
export function hazardInSetUp() {
  const exercise = page.library.exercises.find((e) => e.name === byId("exercise").value);
  return byId("hazard").value === "own" && exercise ? exercise.drill : byId("hazard").value;
}

function showChoices() {
  const exercise = page.library.exercises.find((e) => e.name === byId("exercise").value);
  const hazards = [option("none", "none")];
  if (exercise && exercise.drill) hazards.push(option("own", `the exercise's own: ${plain(exercise.drill)}`));
  fill(byId("hazard"), [...hazards, ...hazardGroups()]);
  const drivers = ["browser"];
  if (exercise && exercise.expert) drivers.push("expert");
  if (exercise) drivers.push(...exercise.clumsy.map((name) => `clumsy:${name}`));
  if (!exercise) drivers.push("scripted");
  fill(byId("driver"), [...drivers, ...page.library.masters.map((m) => `master:${m.name}`)].map((d) => option(d, driverText(d))));
  byId("exercise-help").textContent = exercise ? `Time limit ${exercise.time_limit} s. Trains: ${exercise.skills.join(", ").replaceAll("_", " ")}.`
    : "The arms move freely; nothing is scored.";
  const hazard = page.library.hazards.find((h) => h.name === hazardInSetUp());
  byId("hazard-help").textContent = hazard ? `${hazard.expected} Right response: ${hazard.response}` : "Nothing goes wrong.";
  byId("driver-help").textContent = `${driverHelp(byId("driver").value)} `;
  if (byId("driver").value === "browser") byId("driver-help").append(anchor("Open it", "/trainee"));
  const linkName = byId("link").value;
  byId("link-help").textContent = linkName === "none" ? "A bad link delays or loses motion between console and trainer."
    : `Between console and trainer: ${page.library.links.find((l) => l.name === linkName).title}.`;
  for (const id of ["exercise", "hazard", "when"]) byId(id).disabled = byId("curriculum").value !== "";
}

// A curriculum shows its stage in the fields that it decides.
export async function showStage() {
  const curriculum = byId("curriculum").value;
  if (!curriculum) {
    byId("stage").textContent = "With a curriculum, the trainee's stage chooses exercise and hazard.";
    return showChoices();
  }
  const reply = await page.link.ask("stage", { curriculum, trainee: byId("trainee").value.trim() });
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
for (const id of ["exercise", "hazard", "driver", "link"]) byId(id).addEventListener("change", showChoices);

// A page that is opened again shows the session that runs.
export function setUpAs(choice) {
  if (!page.library) return;
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

byId("form").addEventListener("submit", async (event) => {
  event.preventDefault();
  byId("start").disabled = true;  // against a second click
  say({ ok: true, text: "The session starts." });
  const reply = await page.link.ask("start", settings());
  say(reply);
  if (!reply.ok) byId("start").disabled = page.station.phase !== "idle" || Boolean(page.station.foreign);
});
