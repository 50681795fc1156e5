// Queue and jobs: what waits, in its order; what has ended, and how.
import { get, send } from "../api.js";
import { actionButton, errorText, facts, fill, h, table } from "../dom.js";
import { duration, nameOf, plain, stateOf, when } from "../format.js";
import { live, pathOfJob, refresh } from "../live.js";
import { jobActions, mayOperate, reportButton } from "./job_actions.js";

export const title = "Jobs";
const PAGE = 30;
const STATES = ["", "done", "failed", "cancelled", "running", "queued"];

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  if (parts[0]) return showJob(root, parts[0]);
  const queue = h("div");
  const list = h("div");
  const state = h("select", { id: "state", onchange: () => { pages = [firstPage()]; load(); } }, STATES.map((each) => h("option", { value: each }, each || "any end")));
  root.replaceChildren(h("h2", {}, "Queue"), queue, h("h2", {}, "All jobs, newest first"), h("div", { class: "filters" }, h("label", { for: "state" }, "How it ended ", state)), list);
  /** @type {any[]} */ let waiting = [];
  const firstPage = () => `jobs?limit=${PAGE}${state.value ? `&state=${state.value}` : ""}`;
  let pages = [firstPage()];

  async function load() {
    const found = await get(/** @type {string} */ (pages.at(-1)));
    waiting = (await get("jobs?state=queued&state=running&limit=200")).items;
    update();
    fill(list, table("Jobs", ["Job", "State", "Asked for", "From request to end, or left", "What became of it", "Actions"], found.items.map((/** @type {any} */ job) => row(job, load))), h("p", { class: "buttons" },
      pages.length > 1 && h("button", { type: "button", onclick: () => { pages.pop(); load(); } }, "Newer"),
      found.next && h("button", { type: "button", onclick: () => { pages.push(found.next); load(); } }, "Older")));
  }

  /** The job that runs is read by each poll. */
  function update() {
    const running = [live.job, live.outer].filter(Boolean);
    drawQueue(queue, waiting.map((job) => {
      const now = running.find((each) => each.id === job.id);
      return now ? { ...job, progress: now.progress, paused: now.paused } : job;
    }), load);
  }

  await load();
  return { load, update, concerns: (/** @type {any} */ what) => what.kind === "job" };
}

/** @param {any} job */
function name(job) {
  return (job.within ? "↳ " : "") + [plain(job.procedure ?? job.kind), job.resonator].filter(Boolean).join(" of ");
}

/** @param {any} job @param {() => void} load */
function row(job, load) {
  const took = job.finished && job.created ? (Date.parse(job.finished) - Date.parse(job.created)) / 1000 : job.progress.time_left_s;
  const became = job.error ?? (job.question ? `waits for you: ${job.question}` : job.recording ? h("a", { href: `#/series/${job.recording}` }, "series") : job.kind === "diagnosis" ? h("a", { href: `#/diagnosis/${job.id}` }, "report") : stateOf(job));
  return [
    h("a", { href: `#/jobs/${job.id}` }, name(job)),
    h("span", { class: { done: "good", failed: "bad" }[/** @type {string} */ (job.state)] ?? "" }, job.paused ? "paused" : job.state),
    when(job.created), duration(took), became,
    h("span", { class: "buttons" }, h("a", { href: `#/start/again/${job.id}` }, "again"), job.state === "queued" && h("a", { href: `#/start/edit/${job.id}` }, "edit"), job.state === "failed" && job.kind === "acquisition" && jobActions(job, load)),
  ];
}

/** @param {HTMLElement} place @param {any[]} waiting @param {() => void} load */
function drawQueue(place, waiting, load) {
  const order = /** @type {string[]} */ (live.platform?.queued ?? []);
  const rank = (/** @type {any} */ job) => (job.state === "running" ? -1 : order.includes(job.id) ? order.indexOf(job.id) : order.length);
  const rows = [...waiting].sort((a, b) => rank(a) - rank(b));
  const disabled = !mayOperate();
  /** @param {string} id @param {number} by */
  const move = async (id, by) => {
    const next = [...order];
    const from = next.indexOf(id);
    next.splice(from, 1);
    next.splice(Math.max(0, from + by), 0, id);
    await send("POST", "platform/queue", { order: next });
    refresh();
    setTimeout(load, 300);
  };
  fill(place, table("What runs and what waits, the next one first", ["Job", "State", "Priority", "Progress", "Actions"], rows.map((job) => {
    const k = order.indexOf(job.id);
    const priority = () => [h("input", { type: "number", "data-key": "priority", min: -100, max: 100, value: job.priority, "aria-label": `Priority of ${name(job)}`, onchange: async (/** @type {any} */ { target }) => {
      target.nextElementSibling.textContent = "";
      try {
        await send("POST", "platform/queue", { priority: { [job.id]: Number(target.value) } });
        refresh();
        setTimeout(load, 300);
      } catch (error) {
        target.nextElementSibling.textContent = errorText(error);
      }
    } }), h("span", { class: "inline-error", role: "alert", "data-own": true })];
    return [
      h("a", { href: `#/jobs/${job.id}` }, name(job)), job.paused ? "paused" : job.state,
      k >= 0 && !disabled ? priority() : job.priority,
      `${job.progress.phase}, ${Math.round(100 * job.progress.fraction)} %`,
      h("span", { class: "buttons" }, k > 0 && actionButton("Earlier", () => move(job.id, -1), { disabled }), k >= 0 && k < order.length - 1 && actionButton("Later", () => move(job.id, 1), { disabled }), jobActions(job, load)),
    ];
  }), "nothing runs and nothing waits"));
}

/** @param {HTMLElement} root @param {string} id */
async function showJob(root, id) {
  async function load() {
    const job = await get(pathOfJob(id));
    const result = job.result ?? {};
    const simple = Object.entries(result).filter(([, value]) => ["string", "number"].includes(typeof value) && value !== id);
    // The buttons stand above the facts, whose rows come and go while the job runs: what moves just before a press gets no click.
    fill(root, h("h2", { class: "words" }, nameOf(job)), h("p", { class: "buttons" }, jobActions(job, load), result.recording && h("a", { href: `#/series/${id}` }, "Shots"), job.kind === "diagnosis" && h("a", { href: `#/diagnosis/${id}` }, "Report"), job.links.report && job.kind === "reproduction" && reportButton(pathOfJob(id)), job.request.kind === "ramp" && h("a", { href: `#/ramp/${id}` }, "Ramp"), h("a", { href: `#/start/again/${id}` }, "Again")),
    facts([
      ["Job", id],
      ["State", job.paused ? "paused" : job.state],
      ["Progress", job.finished ? null : `${job.progress.phase}, ${Math.round(100 * job.progress.fraction)} %, ${duration(job.progress.time_left_s)} left`],
      ["Asked for", when(job.created)], ["Began", when(job.started)], ["Ended", when(job.finished)],
      ["Times of its shots", job.clock && `${job.clock} time`],
      ["Why it failed", job.error && h("span", { class: "bad" }, job.error.detail)],
      ["Warnings", job.warnings.join("; ")],
      ["Waits for you", job.question],
      ["Claims of the paper", result.claims && Object.entries(Object.groupBy(result.claims, (/** @type {any} */ claim) => claim.verdict)).map(([verdict, each]) => `${each?.length} ${plain(verdict)}`).join(", ")],
      ...simple.map(([key, value]) => /** @type {[string, any]} */ ([plain(key), String(value)])),
    ]),
    h("details", {}, h("summary", {}, "What was asked for"), h("pre", { class: "scroll", tabindex: 0 }, JSON.stringify(job.request, null, 2))));
  }
  await load();
  return { load, concerns: (/** @type {any} */ what) => what.job === id };
}
