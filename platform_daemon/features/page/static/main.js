// The frame of the page: bar, views by their addresses, freshness, token, keys.
import { get, onRefusedToken, setToken } from "./api.js";
import { errorBox, fill, h, oneAtATime, say } from "./dom.js";
import { duration, loadDefinitions, plain, zone } from "./format.js";
import { follow, isOld, live, onChange, onEvent, refresh } from "./live.js";
import { installStop } from "./stop.js";

/**
 * What a view does while it is shown.  update: draws what live.js knows.  load: reads and draws again; it is called
 * after an event for which `concerns` is true, after a gap, and every `every_ms`.  close: ends what would go on.
 * @typedef {{update?: () => void, concerns?: (what: any) => boolean, load?: () => Promise<void>, every_ms?: number, close?: () => void}} Shown
 */
/** @typedef {{title: string, show: (root: HTMLElement, parts: string[]) => Shown | void | Promise<Shown | void>}} View */
/** @typedef {{id: string, name: string, key: string, load: () => Promise<View>}} Entry */

/** @type {Entry[]} */
const VIEWS = [
  { id: "now", name: "Now", key: "n", load: () => import("./views/now.js") },
  { id: "shot", name: "Last shot", key: "l", load: () => import("./views/shot.js") },
  { id: "series", name: "Series", key: "s", load: () => import("./views/series.js") },
  { id: "start", name: "Start", key: "m", load: () => import("./views/start.js") },
  { id: "jobs", name: "Jobs", key: "j", load: () => import("./views/jobs.js") },
  { id: "questions", name: "Questions", key: "q", load: () => import("./views/questions.js") },
  { id: "alarms", name: "Alarms", key: "a", load: () => import("./views/alarms.js") },
  { id: "recordings", name: "Recordings", key: "r", load: () => import("./views/recordings.js") },
  { id: "schedules", name: "Schedules", key: "c", load: () => import("./views/schedules.js") },
  { id: "specimens", name: "Specimens", key: "p", load: () => import("./views/specimens.js") },
  { id: "ramp", name: "Ramp", key: "u", load: () => import("./views/ramp.js") },
  { id: "diagnosis", name: "Diagnosis", key: "d", load: () => import("./views/diagnosis.js") },
  { id: "devices", name: "Devices", key: "e", load: () => import("./views/devices.js") },
  { id: "keys", name: "Keys", key: "?", load: () => import("./views/keys.js") },
];
const WALL = ["now", "shot", "series"];
const WALL_MS = 15_000;
const CLOCK_OFF_S = 60;
const AGAIN_MS = 1000;
export const isWall = new URLSearchParams(location.search).has("wall");

/** @type {Shown} */
let shown = {};
let failed = false;
/** @type {Element} where the view says what went wrong */
let complaint = document.createElement("div");
let turn = 0;
const root = /** @type {HTMLElement} */ (document.getElementById("view"));

async function route() {
  const [id = "", ...parts] = location.hash.replace(/^#\/?/, "").split("/").map(decoded);
  const entry = VIEWS.find((each) => each.id === id) ?? VIEWS[0];
  const mine = ++turn;
  shown.close?.();
  shown = {};
  failed = false;
  for (const link of document.querySelectorAll("#nav a")) {
    if (link.getAttribute("href") === `#/${entry.id}`) {
      link.setAttribute("aria-current", "page");
      link.scrollIntoView({ block: "nearest", inline: "center" }); // on a phone the bar is wider than the screen
    }
    else link.removeAttribute("aria-current");
  }
  document.title = `${entry.name} · platform-daemon`;
  const section = h("div", {}, h("h1", { id: "heading" }, entry.name));
  const content = h("div", { class: `view ${entry.id}` });
  const problem = (complaint = h("div", {}));
  section.append(problem, content);
  root.replaceChildren(section);
  scrollTo(0, 0); // another view begins at its top
  try {
    const view = await entry.load();
    const made = (await view.show(content, parts)) ?? {};
    if (mine !== turn) made.close?.();
    else {
      shown = kept(made, problem);
      shown.update?.();
    }
  } catch (error) {
    if (mine !== turn) return;
    failed = true;
    const odd = error instanceof TypeError || error instanceof SyntaxError; // a module that is missing, or of another version
    content.replaceChildren(errorBox(odd ? `This view cannot be shown: ${error.message}. Remedy: reload the page, which may be older than the daemon.` : error));
  }
}

/** A part of an address; one that was cut within an escape stays as it is. @param {string} part */
function decoded(part) {
  try {
    return decodeURIComponent(part);
  } catch {
    return part;
  }
}

/** The same view, whose `load` runs once at a time and says what went wrong. @param {Shown} made @param {Element} problem @returns {Shown} */
function kept(made, problem) {
  const { load, every_ms, close } = made;
  if (!load) return made;
  const safe = oneAtATime(async () => {
    try {
      await load();
      fill(problem);
    } catch (error) {
      fill(problem, errorBox(error));
    }
  });
  const timer = every_ms ? setInterval(() => document.hidden || safe(), every_ms) : 0;
  const closeAll = () => {
    clearInterval(timer);
    close?.();
  };
  return { ...made, load: safe, close: closeAll };
}

/** Reads what is shown again, after a gap.  A form that is being filled in stays as it is. */
function reload() {
  if (failed) route();
  else shown.load?.();
}

function drawBar() {
  const fresh = /** @type {HTMLElement} */ (document.getElementById("fresh"));
  const old = isOld();
  const age_s = (performance.now() - live.heard_ms) / 1000;
  const text = !old ? "live" : Number.isFinite(age_s) ? `OLD: nothing heard for ${duration(age_s)}` : "connecting …";
  if (fresh.dataset.old !== String(old)) {
    say(old ? "What is shown is old." : "Live again.");
    if (fresh.dataset.old && !old) reload();
  }
  if (fresh.dataset.old !== String(old)) fresh.dataset.old = String(old);
  if (fresh.textContent !== text) fresh.textContent = text; // to write the same would lay the bar out again
  document.body.classList.toggle("old", old);
  const name = live.platform?.platform;
  const heading = /** @type {HTMLElement} */ (document.getElementById("platform"));
  if (name && heading.textContent !== name) heading.textContent = name;
  drawStanding();
}

function drawStanding() {
  const place = /** @type {HTMLElement} */ (document.getElementById("standing"));
  const alarms = live.alarms.filter((each) => !each.cleared && !each.acknowledged_by);
  fill(
    place,
    live.problem && h("p", { class: "error" }, live.problem),
    Math.abs(live.clock_off_s) > CLOCK_OFF_S &&
      h("p", { class: "warn" }, `The clock of this device is ${duration(Math.abs(live.clock_off_s))} ${live.clock_off_s > 0 ? "ahead of" : "behind"} the daemon's, by which all times here are.`),
    live.platform?.interlock && h("p", { class: "error" }, `Interlock closed: ${live.platform.interlock}`),
    live.platform?.error && h("p", { class: "error" }, `Devices: ${live.platform.error}`),
    (live.job?.question || live.outer?.question) && h("p", { class: "warn" }, h("a", { href: "#/questions" }, `Waits for you: ${live.job.question || live.outer.question}`)),
    alarms.length > 0 &&
      h("p", { class: "warn" }, h("a", { href: "#/alarms" }, `${alarms.length} alarm${alarms.length > 1 ? "s" : ""}: ${alarms[0].what}`)),
  );
}

/** Asks for the token, once at a time. */
function askForToken() {
  if (document.querySelector("dialog.token")) return;
  const input = h("input", { type: "password", autocomplete: "current-password", required: true, id: "token", size: 44 });
  const message = h("p", { class: "inline-error", role: "alert" });
  const form = h(
    "form",
    { method: "dialog" },
    h("h2", {}, "This daemon asks for a token"),
    h("p", {}, "An administrator makes one with `platform-daemon token add`. This tab keeps it until it is closed."),
    h("label", { for: "token" }, "Token "),
    input,
    message,
    h("p", {}, h("button", {}, "Go on")),
  );
  const dialog = h("dialog", { class: "token", "aria-label": "Token" }, form);
  form.addEventListener("submit", async (/** @type {Event} */ event) => {
    event.preventDefault();
    setToken(input.value.trim());
    const before = document.body.dataset.role;
    const who = await loadCaller().catch((error) => ({ refused: error.message, role: null }));
    if (who.role) {
      dialog.close();
      dialog.remove();
      refresh();
      if (who.role === before) reload(); // a form that was being filled in stays
      else route();
    } else message.textContent = who.refused ?? "It is not accepted.";
  });
  dialog.addEventListener("cancel", (/** @type {Event} */ event) => event.preventDefault());
  document.body.append(dialog);
  dialog.showModal();
}

async function loadCaller() {
  const who = await get("caller");
  const may = isWall ? "viewer" : (who.role ?? "nobody");
  document.body.dataset.role = may;
  fill(
    /** @type {HTMLElement} */ (document.getElementById("footer")),
    h("p", {}, `${who.name ? `${who.name} (${who.role})` : "no token"} · times in ${zone()} · `, h("a", { href: "../docs" }, "REST interface")),
  );
  return who;
}

function installKeys() {
  addEventListener("keydown", (event) => {
    const target = /** @type {HTMLElement} */ (event.target);
    if (event.ctrlKey || event.metaKey || event.altKey || target.closest("input, textarea, select, dialog, [contenteditable]")) return;
    const entry = VIEWS.find((each) => each.key === event.key);
    if (entry) {
      location.hash = `#/${entry.id}`;
      root.focus();
    }
  });
}

/** What `load` gives; where it fails, that is said, and it is tried again.  Null: a token is asked for. @param {() => Promise<any>} load */
async function untilAnswered(load) {
  for (;;) {
    try {
      return await load();
    } catch (error) {
      if (/** @type {any} */ (error).status === 401) return null;
      root.replaceChildren(errorBox(error));
      await new Promise((resolve) => setTimeout(resolve, AGAIN_MS));
    }
  }
}

async function begin() {
  if (isWall) document.body.classList.add("wall");
  installStop();
  installKeys();
  fill(
    /** @type {HTMLElement} */ (document.getElementById("nav")),
    VIEWS.map((each) => h("a", { href: `#/${each.id}`, "aria-keyshortcuts": each.key }, each.name)),
  );
  onRefusedToken(askForToken);
  onChange(() => {
    drawBar();
    shown.update?.();
  });
  onEvent(({ what }) => {
    if (what.kind === "job") say(`${plain(what.job_kind)} ${what.state}.`);
    if (what.kind === "interlock") say(what.why ? `Interlock closed: ${what.why}` : "Interlock open.");
    if (what.kind === "alarm" && what.state === "raised") say(`Alarm: ${what.what}`);
    if (what.kind === "dropped") reload();
    else if (shown.concerns?.(what)) shown.load?.();
  });
  addEventListener("hashchange", route);
  addEventListener("unhandledrejection", (event) => {
    event.preventDefault();
    fill(complaint, errorBox(event.reason));
  });
  await Promise.all([untilAnswered(loadDefinitions), untilAnswered(loadCaller).then((who) => !who || who.role || askForToken())]);
  follow();
  route();
  if (isWall) {
    let place = 0;
    setInterval(() => {
      place = (place + 1) % WALL.length;
      location.hash = `#/${WALL[place]}`;
    }, WALL_MS);
  }
}

begin();
