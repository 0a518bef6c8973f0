// The page asks the server of `beltsort watch` for the run and shows what it answers. Names in the data are those of
// beltsort/watch/state.py.

import { Scene } from "/scene.js";

const MOST_CLASSES = 10; // rows of a position
const INTERVAL = 1000; // ms between two questions
const SILENT = 15; // seconds without an entry, after which a run that should go on is told to be silent
const FAILURE = 8000; // ms that the failure of a request is shown
const EXPLAIN_AFTER = 200; // ms that a step is shown before it is explained

const NO_SCAN = "the run has kept no scan yet";

const byId = (id) => document.getElementById(id);
const scene = new Scene(byId("cloud"), byId("sphere"));
const explanations = new Map();
const asked = new Set(); // steps whose explanation is under way
let shown = null; // number of the step shown; null: the latest
let latest = null; // last answer
let cloud = null; // last answer about a scan
let cloudOf = ""; // the scan that it was asked for
let lost = false;
let explaining = 0;
let failure = { text: "", until: 0 }; // of a request, shown for a while

// The token is in the part of the address that browsers send to nobody; it leaves the address bar at once.
const token = new URLSearchParams(location.hash.slice(1)).get("token") ?? sessionStorage.getItem("token");
if (location.hash) history.replaceState(null, "", location.pathname);
if (token) sessionStorage.setItem("token", token);

async function ask(path, options) {
  const answer = await fetch(path, options);
  const content = await answer.json();
  if (!answer.ok) throw new Error(content.error);
  return content;
}

function element(tag, text = "", className = "") {
  const made = document.createElement(tag);
  made.textContent = text;
  if (className) made.className = className;
  return made;
}

function bar(name, share, number, className, colour) {
  const row = element("div", "", `bar ${className}`);
  const label = element("span", name, "name");
  label.title = name;
  const track = element("span", "", "track");
  const fill = element("span", "", "fill");
  fill.style.left = `${100 * share[0]}%`;
  fill.style.width = `${100 * (share[1] - share[0])}%`;
  if (colour) fill.style.background = colour;
  track.append(fill);
  row.append(label, track, element("span", number, "number"));
  return row;
}

const classColour = (index) => `var(--class-${index % 8})`;
const clock = (time) => new Date(time).toLocaleTimeString([], { hour12: false });

function showBelt({ classes, bins, moving }, moment) {
  const longest = Math.max(...classes.map((name) => name.length));
  byId("main").style.setProperty("--names", `${Math.min(16, Math.max(5, 0.58 * longest + 0.8))}em`);
  byId("main").classList.toggle("many", moment.positions.length > 2);
  byId("belt").replaceChildren(...moment.positions.map((position, j) => {
    const box = element("div", "", j ? "position" : "position end");
    const title = element("h3", position.object == null ? "no object " : `object ${position.object} `);
    title.append(element("small", j ? `position ${j + 1}` : moving ? "exit" : "belt end"));
    box.append(title);
    if (position.object == null) return box;
    const ranked = [...position.belief.keys()].sort((a, b) => position.belief[b] - position.belief[a]);
    const rows = classes.length > MOST_CLASSES ? ranked.slice(0, MOST_CLASSES - 1).sort((a, b) => a - b) : classes.keys();
    let others = 1;
    for (const i of rows) {
      const p = position.belief[i];
      others -= p;
      box.append(bar(classes[i], [0, p], p.toFixed(2), i === position.likely ? "likely" : "", classColour(i)));
    }
    if (classes.length > MOST_CLASSES) {
      const count = classes.length - MOST_CLASSES + 1;
      box.append(bar(`${count} others`, [0, Math.max(0, others)], Math.max(0, others).toFixed(2), "", "var(--quiet)"));
    }
    if (position.bins.length) {
      const right = element("div", "", "of-bins");
      position.bins.forEach((p, b) => {
        if (p > 0) right.append(bar(`→ ${bins[b]}`, [0, p], p.toFixed(2), ""));
      });
      box.append(right);
    }
    const looks = position.looks === 1 ? "1 look" : `${position.looks} looks`;
    const seen = position.looks || position.seen ? `${looks}, last: ${position.seen || "-"}` : "not seen yet";
    box.append(element("div", seen, "seen"));
    if (position.decided) box.append(element("div", `decided: ${position.decided}`, "decided"));
    return box;
  }));
}

function showPlan({ moving, viewpoints }, moment) {
  const { plan } = moment;
  byId("plan-note").textContent = `${plan ? `step ${plan.step}, ` : ""}camera at ${viewpoints[moment.viewpoint]}`;
  byId("action").textContent = plan ? plan.action[0].toUpperCase() + plan.action.slice(1) : "No action yet";
  if (plan?.reason) byId("action").textContent += ` (${plan.reason})`;
  const values = plan?.values ?? [];
  const low = Math.min(0, ...values.map((action) => action.value));
  const span = Math.max(0, ...values.map((action) => action.value)) - low || 1;
  const at = (value) => (value - low) / span;
  byId("values").replaceChildren(...values.map((action) => bar(
    action.name,
    action.value < 0 ? [at(action.value), at(0)] : [at(0), at(action.value)],
    action.value.toFixed(2),
    action.chosen ? "chosen" : "",
  )));
  byId("values").classList.toggle("placed", moving); // actions name a position
  byId("explanation").hidden = moving;
  byId("explanation").textContent = (plan && explanations.get(plan.step)) ?? "";
  clearTimeout(explaining);
  if (plan && !plan.reason && !moving && !explanations.has(plan.step)) {
    explaining = setTimeout(() => explain(plan.step), EXPLAIN_AFTER);
  }
}

async function explain(step) {
  if (asked.has(step)) return;
  asked.add(step);
  try {
    explanations.set(step, (await ask(`/api/explanation?step=${step}`)).text);
  } catch {
    return; // asked again when the step is shown again
  } finally {
    asked.delete(step);
  }
  if (latest?.run.moment.plan?.step === step) byId("explanation").textContent = explanations.get(step);
}

function showBins({ classes }, { tally }) {
  const known = tally.right != null;
  for (const cell of document.querySelectorAll("th.truth")) cell.hidden = !known;
  byId("bins-note").textContent = known ? "the true classes of this simulated run are known" : "";
  byId("bins").replaceChildren(...tally.bins.map((bin) => {
    const row = element("tr");
    const name = element("td");
    const own = classes.indexOf(bin.name);
    if (own >= 0) {
      const swatch = element("span", "", "swatch");
      swatch.style.background = classColour(own);
      name.append(swatch);
    }
    name.append(bin.name);
    row.append(name, element("td", bin.objects));
    if (known) {
      row.append(element("td", bin.right ?? "-"));
      row.append(element("td", bin.purity == null ? "-" : `${(100 * bin.purity).toFixed(0)} %`));
    }
    return row;
  }));
  const figures = [
    ["sorted", known ? `${tally.sorted}, ${tally.right} right` : tally.sorted],
    ["objects per minute", tally.objects_per_minute?.toFixed(1) ?? "-"],
    ["looks per object", tally.looks_per_object?.toFixed(1) ?? "-"],
    ["empty cups", tally.skipped],
  ];
  if (tally.forced != null) figures.push(["forced decisions", tally.forced]);
  if (tally.passed && !tally.fates) figures.push(["passed unsorted", tally.passed]);
  figures.push(...Object.entries(tally.fates ?? {}).filter(([fate, n]) => n && !["in bin", "empty"].includes(fate)));
  if (tally.uncounted) figures.push(["uncounted", `up to ${tally.uncounted}`]);
  byId("figures").replaceChildren(...figures.map(([name, value]) => {
    const group = element("div");
    group.append(element("dt", name), element("dd", value));
    return group;
  }));
}

function showAlarms({ alarms, alarm_counts: counts }) {
  const total = Object.values(counts).reduce((sum, n) => sum + n, 0);
  byId("alarms-note").textContent = Object.entries(counts).map(([kind, n]) => `${n} ${kind}`).join(", ") || "none";
  byId("alarm-count").textContent = total === 1 ? "1 alarm" : `${total} alarms`;
  byId("alarm-count").hidden = total === 0;
  byId("alarms").replaceChildren(...alarms.map((alarm) => {
    const row = element("li");
    const severe = ["emergency stop", "aborted", "held", "encoder"].includes(alarm.kind);
    row.append(element("time", clock(alarm.time)), element("b", alarm.kind, severe ? "bad" : ""), alarm.text);
    return row;
  }));
}

function showScene({ viewpoints }, moment) {
  const { scan } = moment;
  byId("scene").hidden = !cloud || Boolean(cloud.error);
  if (!cloud || cloud.error) {
    byId("scene-note").textContent = cloud?.error ?? "";
    scene.show(null);
    return;
  }
  const here = scan != null && scan.entry === cloud.entry;
  byId("scene-note").textContent = here
    ? `from ${viewpoints[scan.viewpoint]}, object ${scan.object} at the belt end`
    : cloud.missing;
  scene.show({
    scene: cloud,
    cloud: here,
    classes: here ? scan.classes : moment.positions.map((position) => position.likely),
    viewpoint: moment.viewpoint,
    names: viewpoints,
  });
}

function showHeader({ run, takes_requests: takes, request }) {
  const { moment } = run;
  const silent = (Date.now() - new Date(run.updated)) / 1000;
  const running = run.state === "Execute" && run.ended == null;
  byId("state").textContent = running && silent > SILENT ? `Silent for ${Math.round(silent)} s` : run.state;
  byId("state").className = `state ${running && silent > SILENT ? "Held" : run.state}`;
  byId("doing").textContent = shown == null ? moment.doing : `as it was before step ${shown}, ${clock(moment.time)}`;
  const done = run.objects == null ? moment.left : `${Math.min(run.objects, moment.left)} of ${run.objects}`;
  byId("progress").textContent = `${done} objects, run ${run.run}`;
  const asked = request?.action === "hold";
  const held = run.state === "Held" && run.ended == null;
  let notice = "";
  if (run.state === "Held" || run.state === "Aborted") notice = `${run.state}: ${run.reason}`;
  if (asked && takes && running) notice = "The run holds after this step.";
  if (Date.now() < failure.until) notify(failure.text, true);
  else notify(notice, run.state === "Aborted");
  showQuestion(run, Boolean(token && takes));
  byId("control").hidden = !(token && takes);
  byId("hold").disabled = asked || !running;
  byId("continue").disabled = !(asked && (held || running));
}

// What a held run asks: each way to go on, with a button where it is an answer that may be given here.
function showQuestion({ question, ended }, mayAnswer) {
  const list = byId("question");
  const text = JSON.stringify([question, ended, mayAnswer]);
  list.hidden = question == null;
  if (question == null || list.dataset.shown === text) return;
  list.dataset.shown = text;
  list.replaceChildren(...question.ways.map(({ when, answer, home }) => {
    const item = element("li", `${when}: `);
    const homing = home == null ? [] : [`home the belt to ${home === "NUMBER" ? "its number" : home}`];
    if (answer == null) item.append([...homing, "resume the run"].join(", then "));
    else if (!mayAnswer) item.append([...homing, `settle it as ${answer}`].join(", then "));
    else {
      const button = element("button", answer);
      button.type = "button";
      button.disabled = question.settled != null;
      button.addEventListener("click", () => request(`/api/settle/${answer}/${question.entry}`));
      item.append(...homing.map((words) => `${words}, then `), button);
    }
    return item;
  }));
  if (question.settled != null) list.append(element("li", `answered: ${question.settled}; resume the run`));
}

function notify(text, bad = false) {
  byId("notice").hidden = !text;
  byId("notice").textContent = text;
  byId("notice").classList.toggle("bad", bad);
}

function showSteps({ first_step: first, last_step: last, moment }) {
  const slider = byId("slider");
  slider.min = first;
  slider.max = last;
  slider.value = shown ?? last;
  slider.disabled = last === 0;
  byId("step").textContent = last === 0 ? "no step yet" : shown == null ? `now, ${last} steps` : `step ${shown} of ${last}`;
  byId("back").disabled = last === 0 || (shown ?? last + 1) <= first;
  byId("forth").disabled = shown == null;
  byId("now").className = shown == null ? "on" : "";
  byId("belt-note").textContent = shown == null ? "" : `before step ${moment.step}`;
}

function render() {
  const { run } = latest;
  showHeader(latest);
  showSteps(run);
  showBelt(run, run.moment);
  showPlan(run, run.moment);
  showBins(run, run.moment);
  showAlarms(run);
  showScene(run, run.moment);
  document.title = `${run.state} - beltsort`;
}

async function refresh() {
  const wanted = shown;
  try {
    const answer = await ask(wanted == null ? "/api/state" : `/api/state?step=${wanted}`);
    if (wanted !== shown) return;
    const changed = lost || JSON.stringify(answer) !== JSON.stringify(latest);
    lost = false;
    latest = answer;
    const scan = JSON.stringify([answer.run.moment.scan?.entry, answer.kept_scan, answer.kept_scans > 0]);
    if (scan !== cloudOf) {
      const found = answer.kept_scans > 0 ? await sceneBefore(wanted) : { error: NO_SCAN };
      if (wanted !== shown) return;
      [cloud, cloudOf] = [found, scan];
    }
    if (changed) render();
    else showHeader(latest); // the time since the last entry
  } catch (error) {
    lost = true;
    byId("state").textContent = "No answer";
    byId("state").className = "state lost";
    notify(error instanceof TypeError ? "`beltsort watch` has ended; what is shown may be out of date." : error.message, true);
  }
}

async function sceneBefore(step) {
  try {
    return await ask(step == null ? "/api/scene" : `/api/scene?step=${step}`);
  } catch (error) {
    return { error: error.message };
  }
}

function go(step) {
  const last = latest?.run.last_step ?? 0;
  shown = step == null || step > last ? null : Math.max(step, latest.run.first_step);
  if (latest) showSteps(latest.run);
  refresh();
}

async function request(path) {
  try {
    await ask(path, { method: "POST", headers: { Authorization: `Bearer ${token}` } });
  } catch (error) {
    failure = { text: error.message, until: Date.now() + FAILURE };
  }
  await refresh();
}

byId("slider").addEventListener("input", (event) => go(Number(event.target.value)));
byId("back").addEventListener("click", () => go((shown ?? latest.run.last_step + 1) - 1));
byId("forth").addEventListener("click", () => go(shown + 1));
byId("now").addEventListener("click", () => go(null));
byId("hold").addEventListener("click", () => request("/api/hold"));
byId("continue").addEventListener("click", () => request("/api/continue"));
document.addEventListener("keydown", (event) => {
  if (event.target instanceof HTMLInputElement) return; // the slider has its own keys
  if (event.key === "ArrowLeft" && latest && !byId("back").disabled) byId("back").click();
  if (event.key === "ArrowRight" && !byId("forth").disabled) byId("forth").click();
});

async function follow() {
  await refresh();
  setTimeout(follow, document.hidden ? 5 * INTERVAL : INTERVAL);
}
follow();
