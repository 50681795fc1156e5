// Diagnosis: the report, parameters before and after, adoption.
import { get, myName, rememberName, send } from "../api.js";
import { actionButton, errorBox, facts, fill, h, table } from "../dom.js";
import { definitionOf, heading, parameter, plain, significant, stateOf, uncertain, when } from "../format.js";
import { pathOfJob } from "../live.js";
import { jobActions, mayGovern, reportButton } from "./job_actions.js";

export const title = "Diagnosis";

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  if (parts[0]) return showOne(root, parts[0]);
  const { items: jobs } = await get("jobs?kind=diagnosis&limit=100");
  fill(root, h("p", {}, h("a", { href: "#/start/diagnose" }, "Diagnose recordings")), table("Diagnoses", ["When", "State", "Why it failed"], jobs.map((/** @type {any} */ job) => [
    h("a", { href: `#/diagnosis/${job.id}` }, when(job.created)), job.state, job.error ?? ""]), "none yet"));
}

/** @param {HTMLElement} root @param {string} id */
async function showOne(root, id) {
  const about = h("div");
  const adopts = h("div", { hidden: true }, adoption(id)); // it stays as it is while the report is read again
  root.replaceChildren(about, adopts);

  async function load() {
    const job = await get(pathOfJob(id));
    const r = job.result;
    const head = facts([["Diagnosis", id], ["State", stateOf(job)], ["Recordings", job.request.recordings.map((/** @type {any} */ each) => each.recording ?? each).join(", ")], ["Why it failed", job.error && h("span", { class: "bad" }, job.error.detail)]]);
    const buttons = h("p", { class: "buttons" }, jobActions(job, load), h("a", { href: `#/start/again/${id}` }, "Again"));
    if (!r?.verdict) {
      fill(about, head, buttons);
      return;
    }
    const names = Object.keys(r.parameters_before);
    adopts.hidden = r.effects.length === 0;
    fill(about, head,
      h("p", { class: "large" }, plain(r.verdict)),
      facts([["Model", r.model], ["χ²/dof on data that were not used", `${significant(r.held_out.chi2_per_dof_before, 5)} before, ${significant(r.held_out.chi2_per_dof_after, 5)} after`], ["Left over", r.left_over && `gain ${significant(r.left_over.gain, 3)}, p ${significant(r.left_over.p_value, 2)}`], ["Notes", r.notes.join("; ")]]),
      table("Effects that are missing in the model", ["Effect", "Strength", "Gain on held-out data", "Source"], r.effects.map((/** @type {any} */ e) => [plain(e.id), e.strength ? `${uncertain(e.strength.value, e.strength.std)} ${e.strength.unit}` : "", significant(e.held_out_gain, 3), e.source]), "none"),
      table("Parameters", ["Parameter", "Before", "After", "Change / σ"], names.map((name) => {
        const [before, after] = [r.parameters_before[name], r.parameters_after[name]];
        return [h("abbr", { title: definitionOf(name).description }, heading(name)), parameter(name, before), after ? parameter(name, after) : "–", after && before.std ? significant((after.value - before.value) / before.std, 3) : "–"];
      })),
      table("What to measure next", ["What", "Expected / σ"], r.next_measurements.map((/** @type {any} */ each) => [each.what, significant(each.expected_sigma, 3)]), "nothing"),
      r.integrity.length > 0 && table("What is wrong with the data", ["What"], r.integrity.map((/** @type {any} */ each) => [each.what ?? each.id ?? JSON.stringify(each)])),
      buttons, h("p", { class: "buttons" }, reportButton(`diagnoses/${id}`)));
  }
  await load();
  return { load, concerns: (/** @type {any} */ what) => what.job === id };
}

/** @param {string} id */
function adoption(id) {
  const name = h("input", { id: "model", type: "text" });
  const by = h("input", { id: "by", type: "text", autocomplete: "name", value: myName() });
  const force = h("input", { id: "force", type: "text" });
  const made = h("p", { class: "good", role: "status" });
  return h("div", { class: "card" }, h("h2", {}, "Adopt as a model for later fits"),
    h("div", { class: "filters" }, h("label", { for: "model" }, "Name of the model ", name), h("label", { for: "by" }, "My name ", by), h("label", { for: "force" }, "Why, if the data are not explained ", force),
      actionButton("Adopt", async () => {
        rememberName(by.value);
        const found = await send("POST", `diagnoses/${id}/adopt`, { name: name.value, by: by.value, ...(force.value ? { force: force.value } : {}) });
        made.textContent = `Adopted as ${found.label ?? found.name}.`;
      }, { disabled: !mayGovern(), title: mayGovern() ? null : "Needs a token of an administrator" })), made);
}
