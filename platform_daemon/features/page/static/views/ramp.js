// Ramp, live: z residual, statistic, threshold, what the next field is and why.
import { get } from "../api.js";
import { facts, fill, h, table } from "../dom.js";
import { digits, duration, microtesla, significant, stateOf } from "../format.js";
import { live, pathOfJob } from "../live.js";
import { Plot } from "../plot.js";
import { jobActions } from "./job_actions.js";

export const title = "Ramp";
/** @type {Record<string, string>} */
const WHY = {
  step: "a whole step up is allowed", smaller_step: "a whole step up is too likely to pass the threshold, so much of it is allowed",
  bound: "the highest field that it may go to", doubt: "this field once more, for the threshold may lie at or below it",
  more_shots: "this field once more, for no step up is allowed yet, and more shots may allow one",
};

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  const id = parts[0] ?? (await newestRamp());
  if (!id) {
    fill(root, h("p", {}, "No ramp yet. ", h("a", { href: "#/start/ramp" }, "Start one")));
    return;
  }
  const head = h("div");
  const places = [h("div"), h("div"), h("div")];
  const steps = h("div");
  const pictures = h("div", { class: "plots", hidden: true }, places);
  root.replaceChildren(head, pictures, steps);
  const plots = places.map((place) => new Plot(place));
  let job = await get(pathOfJob(id));

  async function load() {
    job = await get(pathOfJob(id));
    draw();
  }

  function draw() {
    const outcome = job.result.outcome;
    const found = outcome?.threshold_t;
    const next = outcome?.next_field;
    const soFar = job.finished ? "" : ", so far";
    fill(head, facts([
      ["Ramp", h("a", { href: `#/jobs/${id}` }, id)], ["State", stateOf(job)], ["Time left", job.state === "running" ? duration(job.progress.time_left_s) : null],
      ["Side modes count as visible from", outcome && `${significant(outcome.visible_am2_per_s, 3)} A m²/s`],
      [`Threshold${soFar}`, found ? threshold(found) : outcome ? (job.finished ? "not reached" : "not reached yet") : "no step yet"],
      [`Operating field${soFar}`, outcome && microtesla(outcome.operating_field_t)], [`Highest field allowed later${soFar}`, outcome && microtesla(outcome.max_field_t)],
      ["Chance to pass the threshold by a step", outcome && `${significant(100 * outcome.overdose_rate, 3)} % at most`],
      ["Overshoot", outcome?.overshoot_t ? microtesla(outcome.overshoot_t) : null],
      ["Next field", next ? `${microtesla(next.field_t)}: ${WHY[next.why]}; the threshold lies at or below it with a chance of ${significant(100 * next.chance, 2)} %` : null],
      ["Why it ended", job.result.stopped], ["Why it failed", job.error?.detail],
    ]), h("p", { class: "buttons" }, jobActions(job, load)));
    pictures.hidden = !outcome;
    if (!outcome) return;
    const list = outcome.steps;
    const x = list.map((/** @type {any} */ step) => step.field_t * 1e6);
    const shared = { x, xLabel: "field / µT", xText: (/** @type {number} */ v) => `${significant(v, 4)} µT` };
    const verticals = found ? [found.low, found.value, found.high].map((t) => t * 1e6) : [];
    plots[0].draw({ ...shared, verticals, title: "z residual by field", yLabel: "z residual / A m² s⁻¹", limits: [outcome.visible_am2_per_s], lines: [{ label: "z residual", values: list.map((/** @type {any} */ s) => s.z_residual_am2_per_s), points: true }] });
    plots[1].draw({ ...shared, verticals, title: "Statistic of the sequential test", yLabel: "log₁₀ e-value", lines: [
      { label: "statistic", values: list.map((/** @type {any} */ s) => s.statistic), points: true },
      { label: "visible from", values: list.map((/** @type {any} */ _, /** @type {number} */ k) => Math.log10(((k + 1) * (k + 2)) / outcome.false_stop_rate)) }] });
    const curve = outcome.threshold_chances;
    if (curve)
      plots[2].draw({
        title: "Posterior of the threshold", xLabel: "field / µT", xText: shared.xText, yLabel: "chance to lie at or below / %", x: curve.map((/** @type {any} */ c) => c.field_t * 1e6),
        limits: [100 * outcome.overdose_rate], verticals: next ? [next.field_t * 1e6] : [], lines: [{ label: "chance", values: curve.map((/** @type {any} */ c) => 100 * c.chance) }],
      });
    fill(steps, h("p", { class: "hint" }, `Dashed: z residual from which side modes count as visible; threshold and its interval; in the posterior the chance of ${significant(100 * outcome.overdose_rate, 3)} % that no step may pass, and the next field.`), table("Field by field", ["Field", "Shots", "Deflection / °", "z residual / A m² s⁻¹", "Statistic / log₁₀ e-value", "Verdict"], list.map((/** @type {any} */ s) => [
      microtesla(s.field_t), s.shots, s.phi_max_rad === null ? "–" : digits((s.phi_max_rad * 180) / Math.PI, 4), s.z_residual_am2_per_s.toFixed(3), s.statistic.toFixed(2), s.verdict])));
  }

  draw();
  return {
    load,
    concerns: (/** @type {any} */ what) => what.job === id || what.within === id,
    close: () => plots.forEach((plot) => plot.close()),
  };
}

/** @param {{value: number, low: number, high: number}} found */
function threshold({ value, low, high }) {
  return `${microtesla(value)}, with a probability of 95 % between ${microtesla(low)} and ${microtesla(high)} (dashed in the pictures)`;
}

async function newestRamp() {
  if (live.job?.request?.kind === "ramp") return live.job.id;
  const { items: jobs } = await get("jobs?kind=procedure&limit=100");
  return jobs.find((/** @type {any} */ job) => job.procedure === "ramp" || job.procedure === "characterise")?.id ?? null;
}
