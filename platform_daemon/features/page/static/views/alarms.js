// Alarms: what stands, who knows of it, what is over.
import { getList, myName, rememberName, send } from "../api.js";
import { actionButton, fill, h, table } from "../dom.js";
import { when } from "../format.js";
import { mayOperate } from "./job_actions.js";

export const title = "Alarms";
const MOST = 200;

/** @param {HTMLElement} root */
export async function show(root) {
  const by = h("input", { id: "by", type: "text", autocomplete: "name", value: myName() });
  const list = h("div");
  root.replaceChildren(h("div", { class: "filters" }, h("label", { for: "by" }, "My name ", by)), list);

  async function load() {
    const all = await getList(`alarms?limit=${MOST}`, MOST);
    const standing = all.filter((each) => !each.cleared);
    const over = all.filter((each) => each.cleared);
    fill(list, table("Active alarms", ["Since", "Alarm and remedy", "Times", "Acknowledged by"], standing.map((each) => [when(each.since), each.what, each.times, each.acknowledged_by ? `${each.acknowledged_by}` : acknowledge(each)]), "no active alarm"),
      table("Past alarms", ["Since", "Alarm", "Cleared", "Acknowledged by"], over.map((each) => [when(each.since), each.what, when(each.cleared), each.acknowledged_by ?? ""]), "none"));
  }

  /** @param {any} alarm */
  function acknowledge(alarm) {
    return actionButton("I know", async () => {
      rememberName(by.value);
      await send("POST", `alarms/${encodeURIComponent(alarm.name)}/acknowledge`, { by: by.value });
      await load();
    }, { disabled: !mayOperate(), "data-key": alarm.name, "aria-label": `Acknowledge ${alarm.name}` });
  }

  await load();
  return { load, concerns: (/** @type {any} */ what) => what.kind === "alarm" };
}
