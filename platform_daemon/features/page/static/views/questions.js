// Questions: what a job waits for, answered by whoever stands at the coils; and what is in the clamping unit.
import { get, getList, myName, rememberName, send } from "../api.js";
import { actionButton, errorBox, facts, fill, h } from "../dom.js";
import { plain, when } from "../format.js";
import { refresh } from "../live.js";
import { jobActions, mayOperate } from "./job_actions.js";

export const title = "Questions";

/** @param {HTMLElement} root */
export async function show(root) {
  const asked = h("div", { class: "cards" });
  const mounted = h("div", { class: "card" });
  root.replaceChildren(asked, mounted);

  async function load() {
    const { items: jobs } = await get("jobs?state=running&state=queued&limit=200");
    const waiting = jobs.filter((/** @type {any} */ job) => job.question);
    fill(asked, waiting.length === 0 && h("p", {}, "No job waits for a person."), waiting.map((/** @type {any} */ job) => h("div", { class: "card", "data-key": job.id }, h("h2", { class: "words" }, plain(job.kind)), h("p", { class: "large" }, job.question), h("p", { class: "buttons" }, jobActions(job, load)))));
  }

  async function loadMounted() {
    const [now, resonators] = await Promise.all([get("platform/resonator"), getList("resonators")]);
    const name = h("select", { id: "mounted" }, resonators.map(({ id }) => h("option", { value: id, selected: id === now.resonator }, id)));
    const by = h("input", { id: "by", type: "text", autocomplete: "name", value: myName() });
    const tell = async () => {
      rememberName(by.value);
      await send("POST", "platform/resonator", { resonator: name.value, by: by.value });
      refresh();
      await loadMounted();
    };
    fill(mounted, h("h2", {}, "In the clamping unit"), facts([["Resonator", now.resonator ?? "not reported"], ["Reported by", now.by], ["Since", when(now.at)]]),
      now.changed_by_platform ? h("p", {}, "The platform mounts what is asked for.") : h("div", { class: "filters" }, h("label", { for: "mounted" }, "I have mounted ", name), h("label", { for: "by" }, "My name ", by), actionButton("It is there", tell, { disabled: !mayOperate() })));
  }

  await Promise.all([load(), loadMounted().catch((error) => fill(mounted, errorBox(error)))]);
  return { load, concerns: (/** @type {any} */ what) => what.kind === "job", every_ms: 3000 }; // a question is no event
}
