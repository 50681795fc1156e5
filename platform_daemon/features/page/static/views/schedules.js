// Schedules: what is due, and the ledger of what became of it.
import { get, getList, send } from "../api.js";
import { actionButton, errorText, facts, fill, h, table } from "../dom.js";
import { duration, plain, readingInWords, when } from "../format.js";
import { mayOperate } from "./job_actions.js";

export const title = "Schedules";
const COMING = 60;
const DAYS = 14;
const SHOWN_A_DAY = 4;
const DID_NOT_RUN = ["skipped", "missed", "failed"]; // "late" did, "due" and "started" may yet
const DAY = new Intl.DateTimeFormat(undefined, { weekday: "short", day: "numeric", month: "short" });
const HOUR = new Intl.DateTimeFormat(undefined, { timeStyle: "short" });

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  if (parts[0]) return showLedger(root, parts[0]);
  const list = h("div");
  const calendar = h("div");
  root.replaceChildren(list, calendar, newSchedule(load));

  async function load() {
    const all = await getList("schedules?limit=200", 1000);
    fill(list, table("Schedules", ["Name", "When", "What", "Next", "State", "Failures in a row", "Actions"], all.map((each) => [
      h("a", { href: `#/schedules/${each.id}` }, each.request.name), trigger(each.request.trigger, each.cron_in_words), work(each.request.work), each.active ? when(each.next_due) : "–",
      stateOf(each), each.failures || "", h("span", { class: "buttons" }, actions(each, load)),
    ]), "none yet"));
    const coming = await Promise.all(all.filter((each) => each.active).map(async (each) => {
      const asked = { ...each.request, start: each.request.start ?? each.created }; // an interval counts from there
      const found = await send("POST", `schedules/preview?count=${COMING}`, asked).catch(() => ({}));
      return instants(found).map((due) => ({ due, name: each.request.name, when: trigger(each.request.trigger, each.cron_in_words) }));
    }));
    fill(calendar, h("h2", {}, `What is due in the next ${DAYS} days`), days(coming.flat().sort((a, b) => Date.parse(a.due) - Date.parse(b.due))),
      coming.filter((due) => due.length >= COMING && Date.parse(due.at(-1)?.due ?? "") < Date.now() + DAYS * 86_400_000).map((due) => h("p", { class: "hint" }, `${due[0].name} (${due[0].when}) is due after `, when(due.at(-1)?.due), " as well.")));
  }

  await load();
  return { load, concerns: (/** @type {any} */ what) => what.kind === "schedule" };
}

/** @param {any} schedule */
function stateOf(schedule) {
  return schedule.active ? "active" : `off${schedule.reason ? `: ${schedule.reason}` : ""}`;
}

/** Buttons of a schedule. @param {any} schedule @param {() => Promise<void>} after */
function actions(schedule, after) {
  const button = (/** @type {string} */ text, /** @type {string} */ what) => actionButton(text, async () => {
    await send("POST", `schedules/${schedule.id}/${what}`);
    await after();
  }, { disabled: !mayOperate() });
  return [schedule.active ? button("Pause", "pause") : button("Resume", "resume"), button("Run now", "run")];
}

/** A calendar: each day with what is due then. @param {{due: string, name: string}[]} coming in their order */
function days(coming) {
  return h("ol", { class: "calendar" }, Array.from({ length: DAYS }, (_, k) => {
    const day = new Date();
    day.setDate(day.getDate() + k);
    const due = coming.filter((each) => new Date(each.due).toDateString() === day.toDateString());
    return h("li", { class: due.length ? "" : "empty" }, h("strong", {}, DAY.format(day)),
      due.slice(0, SHOWN_A_DAY).map((each) => h("div", {}, `${HOUR.format(new Date(each.due))} ${each.name}`)),
      due.length > SHOWN_A_DAY ? h("div", { class: "hint" }, `and ${due.length - SHOWN_A_DAY} more`) : null,
      due.length === 0 && h("div", { class: "hint" }, "nothing"));
  }));
}

/** The instants of a preview. @param {any} found @returns {string[]} */
function instants(found) {
  const listed = Object.values(found).find((value) => Array.isArray(value)) ?? [];
  return /** @type {any[]} */ (listed).map((each) => (typeof each === "string" ? each : (each.due ?? each.at))).filter(Boolean);
}

/** When it is due, in words, with the zone that these are in. @param {any} t @param {string | null} cronInWords */
function trigger(t, cronInWords) {
  if (t.every_s) return `Every ${duration(t.every_s)}`;
  return t.cron ? `${cronInWords}, ${t.time_zone} (cron: ${t.cron})` : `At ${t.at.length} instants`;
}

/** @param {any} w */
function work(w) {
  const request = w.request ?? w;
  return [plain(request.kind ?? w.kind), request.resonator ?? request.acquisition?.resonator].filter(Boolean).join(" of ");
}

/** @param {HTMLElement} root @param {string} id */
async function showLedger(root, id) {
  const head = h("div");
  const only = h("select", { id: "only", onchange: load }, h("option", { value: "" }, "everything"), h("option", { value: "not" }, "what did not run"));
  const list = h("div");
  fill(root, head, h("div", { class: "filters" }, h("label", { for: "only" }, "Show ", only)), list);

  async function load() {
    const found = await get(`schedules/${id}`);
    fill(head, h("h2", {}, found.request.name), facts([
      ["When", trigger(found.request.trigger, found.cron_in_words)], ["What", work(found.request.work)], ["Next", found.active ? when(found.next_due) : null], ["State", stateOf(found)], ["Failures in a row", found.failures],
    ]), h("p", { class: "buttons" }, actions(found, load), actionButton("Remove the schedule", async () => { await send("DELETE", `schedules/${id}`); location.hash = "#/schedules"; }, { disabled: !mayOperate() })));
    const rows = await getList(`schedules/${id}/ledger?limit=1000`, Infinity);
    const shown = only.value ? rows.filter((row) => DID_NOT_RUN.includes(row.state)) : rows;
    const counts = Object.entries(Object.groupBy(rows, (row) => row.state)).map(([state, each]) => `${each?.length} ${plain(state)}`);
    const reads = rows.some((row) => row.measurand);
    fill(list, h("p", {}, counts.join(", ")), table(`Ledger, newest first (${shown.length} of ${rows.length})`, ["Due", "What became of it", "Why", "Late", "Job", "Recording", ...(reads ? ["Reads"] : [])], [...shown].reverse().slice(0, 300).map((row) => [
      when(row.due), h("span", { class: row.state === "run" ? "good" : DID_NOT_RUN.includes(row.state) ? "warn" : "" }, plain(row.state)), row.reason ?? "", row.late_s === null ? "" : duration(row.late_s),
      row.job && h("a", { href: `#/jobs/${row.job}` }, "job"), row.recording && h("a", { href: `#/series/${row.recording}` }, "series"), ...(reads ? [row.measurand ? readingInWords(row.measurand) : ""] : []),
    ]), "nothing was due yet"));
  }
  await load();
  return { load, concerns: (/** @type {any} */ what) => what.schedule === id };
}

/** A schedule for a series: the common case; others by REST or the command line. @param {() => Promise<void>} after */
function newSchedule(after) {
  const field = (/** @type {string} */ name, /** @type {string} */ text, /** @type {string} */ value = "") => h("label", {}, text, " ", h("input", { name, type: "text", value, required: true }));
  const message = h("p", { class: "inline-error", role: "alert" });
  const preview = h("div");
  let busy = false;
  const request_ = () => {
    const f = Object.fromEntries(/** @type {any} */ (new FormData(form)));
    return { name: f.name, trigger: { cron: f.cron, time_zone: f.time_zone }, work: { kind: "acquisition", request: { resonator: f.resonator, shots: Number(f.shots), sample: f.sample } } };
  };
  /** @param {() => Promise<any>} action */
  const once = async (action) => {
    if (busy) return;
    busy = true;
    message.textContent = "";
    try {
      await action();
    } catch (error) {
      message.textContent = errorText(error);
    } finally {
      busy = false;
    }
  };
  const form = h("form", { onsubmit: (/** @type {Event} */ event) => {
    event.preventDefault();
    once(async () => {
      await send("POST", "schedules", request_());
      /** @type {HTMLInputElement} */ (form.elements.namedItem("name")).value = ""; // pressed again, it adds no second one
      preview.replaceChildren(h("p", { class: "good", role: "status" }, "The schedule is active."));
      await after();
    });
  } }, h("div", { class: "filters" }, field("name", "Name"), field("cron", "Cron: minute hour day month weekday", "0 22 * * 1-5"), field("time_zone", "Time zone", Intl.DateTimeFormat().resolvedOptions().timeZone), field("resonator", "Resonator", "thread"), field("shots", "Shots", "10"), field("sample", "Sample")),
  h("p", { class: "buttons" }, h("button", { type: "button", disabled: !mayOperate(), onclick: () => once(async () => {
    const found = await send("POST", "schedules/preview?count=5", request_());
    const { trigger: asked } = request_();
    fill(preview, h("p", {}, `${trigger(asked, found.cron_in_words)}.`), table("It would be due, in the zone of this browser", ["When"], instants(found).map((due) => [when(due)])));
  }) }, "When would it be due?"), h("button", { class: "main", disabled: !mayOperate() }, "Add the schedule")), message, preview);
  return h("details", {}, h("summary", {}, "Add a schedule of a series"), form);
}
