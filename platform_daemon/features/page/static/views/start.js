// Start: a form from the schema of the request; the dry run is shown before anything moves.
import { get, getList, send } from "../api.js";
import { errorBox, errorText, facts, fill, h, say, table } from "../dom.js";
import { SchemaForm } from "../form.js";
import { duration, microtesla, plain, significant, size, valueOf, words } from "../format.js";
import { pathOfJob, refresh } from "../live.js";
import { mayOperate } from "./job_actions.js";

export const title = "Start";

/** @type {Record<string, {path: string, schema: string, dryRun: boolean, text: string}>} */
const KINDS = {
  measure: { path: "acquisitions", schema: "AcquisitionRequest", dryRun: true, text: "Measure: a series of shots" },
  sweep: { path: "procedures", schema: "SweepRequest", dryRun: true, text: "Sweep: the same series with other values of some keys" },
  tune: { path: "procedures", schema: "TuneRequest", dryRun: true, text: "Tune: find frequency and sequence of a resonator" },
  ramp: { path: "procedures", schema: "RampRequest", dryRun: true, text: "Ramp: raise the field until side modes show" },
  characterise: { path: "procedures", schema: "CharacteriseRequest", dryRun: true, text: "Characterise: many shots and the paper's tables" },
  reproduce: { path: "reproductions", schema: "ReproductionRequest", dryRun: false, text: "Reproduce: both resonators and the paper's numbers" },
  calibrate: { path: "calibrations", schema: "CalibrationRequest", dryRun: false, text: "Calibrate receive or transmit" },
  "self-test": { path: "self-tests", schema: "SelfTestRequest", dryRun: false, text: "Self-test" },
  diagnose: { path: "diagnoses", schema: "DiagnosisRequest", dryRun: false, text: "Diagnose recordings" },
  fit: { path: "fits", schema: "RecordingFitRequest", dryRun: false, text: "Fit a recording again" },
};
const PRIMARY = [
  "resonator", "shots", "blank_shots", "sample", "operator", "comment", "over", "start_t", "step_t", "max_t", "max_field_t",
  "name", "repetitions", "recordings", "recording", "window", "acquisition", "tune",
];
/** @type {Promise<any> | null} */
let document_ = null;

/** @param {HTMLElement} root @param {string[]} parts kind, and with "again" or "edit" the id of a job; or kind and a recording */
export async function show(root, parts) {
  const [first = "measure", id = ""] = parts;
  root.textContent = "Loading the form …";
  document_ ??= get("openapi.json", { slow: true });
  document_.catch(() => { document_ = null; });
  const schema = await document_;
  const job = first === "again" || first === "edit" ? await get(pathOfJob(id)) : null;
  const kind = job ? kindOf(job) : first in KINDS ? first : "measure";
  const { path, dryRun, schema: name } = KINDS[kind];
  const form = new SchemaForm(schema.components.schemas, name, PRIMARY);
  const request = job?.request ?? (id && { recording: id, recordings: [id] });
  if (request) form.write(request);
  const edits = first === "edit";

  const choice = h("select", { id: "kind", onchange: () => { location.hash = `#/start/${choice.value}`; } }, Object.entries(KINDS).map(([key, each]) => h("option", { value: key, selected: key === kind }, each.text)));
  const message = h("div");
  const plan = h("div", { class: "plan", "aria-live": "polite" });
  const check = h("button", { type: "submit", class: dryRun ? "main" : "" }, "Check (dry run)");
  const start = h("button", { type: "button", class: "main", disabled: dryRun }, edits ? "Change the job" : "Start");
  let checked = "";
  let asked = "";
  let key = "";
  let busy = false;
  let sent = false;

  if (!mayOperate()) {
    for (const button of [check, start]) button.disabled = true;
    fill(message, h("p", { class: "warn" }, "Your token may look and stop. Starting needs the role operator."));
  }

  /** Runs one request at a time. @param {HTMLElement} button @param {() => Promise<void>} action */
  async function once(button, action) {
    if (busy || sent || !mayOperate()) return;
    busy = true;
    form.clearProblems();
    message.replaceChildren();
    button.setAttribute("aria-busy", "true");
    try {
      await action();
    } catch (error) {
      if (!form.showProblem(/** @type {any} */ (error))) message.replaceChildren(errorBox(error));
      else message.replaceChildren(h("p", { class: "error" }, "Refused; nothing has moved. ", errorText(error)));
    } finally {
      busy = false;
      button.removeAttribute("aria-busy");
    }
  }

  /** The same key for the same request: where its answer was lost, Start again leads to the job that has begun. @param {any} body */
  function keyOf(body) {
    const text = JSON.stringify(body);
    if (text !== asked) key = Array.from(crypto.getRandomValues(new Uint32Array(4)), (part) => part.toString(16)).join("-");
    asked = text;
    return key;
  }

  const element = h("form", { novalidate: true, onsubmit: (/** @type {Event} */ event) => {
    event.preventDefault();
    if (!dryRun) return;
    once(check, async () => {
      const body = form.read();
      plan.replaceChildren(h("p", {}, "Checking; nothing moves …"));
      plan.scrollIntoView({ block: "nearest" });
      try {
        const heading = h("h2", { tabindex: -1 }, "What would happen");
        plan.replaceChildren(heading, planOf(await send("POST", `${path}/dry-run`, body)));
        heading.focus({ preventScroll: true }); // the next stop of Tab is Start, which stands below
        plan.scrollIntoView({ block: "nearest" });
      } catch (error) {
        plan.replaceChildren();
        throw error;
      }
      checked = JSON.stringify(body);
      start.disabled = false;
      say("The request can be carried out. Start is enabled.");
    });
  }, oninput: () => {
    if (dryRun && JSON.stringify(form.read()) !== checked) start.disabled = true;
  } }, form.element, dryRun && h("p", { class: "buttons" }, check), message, plan, h("p", { class: "buttons last" }, start));
  start.addEventListener("click", () => once(start, async () => {
    const body = form.read();
    const made = edits ? await send("PUT", pathOfJob(id), body) : await send("POST", path, body, { "Idempotency-Key": keyOf(body) });
    sent = true;
    start.disabled = check.disabled = true;
    refresh();
    plan.replaceChildren(h("p", { class: "good", role: "status" }, edits ? "Changed: " : "Accepted: ", h("a", { href: `#/jobs/${made.id}` }, made.id), ". ", h("a", { href: "#/now" }, "See it run"), " or ", h("a", { href: `#/start/again/${made.id}` }, "start another one like it"), "."));
  }));
  fill(root, h("div", { class: "field" }, h("label", { for: "kind" }, edits ? "Change a job that waits" : "What to do"), h("div", { class: "row" }, choice)), element);
  offerResonators(form);
}

/** @param {any} job */
function kindOf(job) {
  const kind = job.request.kind in KINDS ? job.request.kind : job.kind;
  return /** @type {Record<string, string>} */ ({ acquisition: "measure", calibration: "calibrate", self_test: "self-test", diagnosis: "diagnose", reproduction: "reproduce" })[kind] ?? kind;
}

/** Names of the resonators, and the preset of the chosen one in the empty fields of the sequence. @param {SchemaForm} form */
async function offerResonators(form) {
  const field = form.fields.find((each) => /(^|\.)resonator$/.test(each.path));
  if (!field) return;
  const input = /** @type {HTMLInputElement} */ (field.input);
  const all = await getList("resonators").catch(() => []);
  const list = h("datalist", { id: "resonators" }, all.map((each) => h("option", { value: each.id }, each.name)));
  input.after(list);
  input.setAttribute("list", "resonators");
  const hint = document.getElementById(`${input.id}-hint`);
  if (hint && all.length) hint.textContent = `One of ${all.map((each) => each.id).join(", ")}.`;
  const showPreset = () => {
    const preset = all.find((each) => each.id === input.value)?.sequence;
    for (const each of form.fields) {
      const key = /(?:^|\.)sequence\.(\w+)$/.exec(each.path)?.[1];
      const value = key && preset?.[key];
      if (key && each.input instanceof HTMLInputElement) each.input.placeholder = value === undefined || value === null ? "" : `${value} (preset)`;
    }
  };
  input.addEventListener("input", showPreset);
  showPreset();
}

/** The answer of a dry run in words. @param {any} plan */
function planOf(plan) {
  const shot = plan.shot ?? plan.steps?.[0]?.shot ?? {};
  const known = new Set(["shot", "steps", "warnings", "duration_s", "disk_bytes", "settle", "resonator", "variant", "model", "shots"]);
  return h(
    "div",
    { class: "card" },
    facts([
      ["Resonator", [plan.resonator, plan.model].filter(Boolean).join(", model ")],
      ["Shots", plan.shots],
      ["Lasts", duration(plan.duration_s)],
      ["On disk", plan.disk_bytes === undefined ? null : size(plan.disk_bytes)],
      ["Peak field", microtesla(shot.peak_field_t)],
      ["Excitation", shot.f_tx_realised_hz && `${significant(shot.f_tx_realised_hz, 7)} Hz, ${shot.tx_periods} periods, then ${duration(shot.t_rx_s)} of RX`],
      ["Current", shot.peak_current_a && each(shot.peak_current_a, "A")],
      ["Amplifier", shot.peak_amplifier_v && each(shot.peak_amplifier_v, "V")],
      ["Left of the swing before", plan.settle && `${significant(100 * plan.settle.share, 3)} %`],
      .../** @type {[string, any][]} */ (Object.entries(plan).filter(([key, value]) => !known.has(key) && (typeof value !== "object" || value === null)).map(([key, value]) => [words(key), value === null ? null : String(value)])),
    ]),
    plan.warnings?.length ? h("ul", { class: "warn" }, plan.warnings.map((/** @type {string} */ text) => h("li", {}, text))) : h("p", { class: "good" }, "No warnings."),
    Array.isArray(plan.steps) && plan.steps.length > 1 && table("Steps", ["Step", "Values", "Peak field", "Lasts"].filter((name) => name !== "Peak field" || field(plan.steps[0])), plan.steps.map((/** @type {any} */ step, /** @type {number} */ k) => [
      step.step ?? k + 1, (step.values ?? []).map(valueOf).join(", "), ...(field(plan.steps[0]) ? [field(step)] : []), duration(step.duration_s)])),
  );
}

/** @param {any} step */
function field(step) {
  return microtesla(step.shot?.peak_field_t ?? step.field_t);
}

/** @param {Record<string, number>} values @param {string} unit */
function each(values, unit) {
  return Object.entries(values).map(([axis, value]) => `${plain(axis)} ${significant(value, 3)} ${unit}`).join(", ");
}
