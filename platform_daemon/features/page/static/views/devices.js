// Devices: read-backs, faults, reset, self-test.
import { get, getList, myName, rememberName, send } from "../api.js";
import { actionButton, errorBox, facts, fill, h, table } from "../dom.js";
import { degrees, plain, significant, unitOf, when, words } from "../format.js";
import { refresh } from "../live.js";
import { mayOperate } from "./job_actions.js";

export const title = "Devices";
/** @type {Record<string, string>} */
const NAMES = { io_card: "I/O card", tx_rx_switch: "Tx/Rx switch", lna: "Receive amplifier (LNA)" };

/** @param {HTMLElement} root */
export async function show(root) {
  const cards = h("div", { class: "cards" });
  const faults = h("div");
  const tests = h("div");
  root.replaceChildren(cards, faults, h("h2", {}, "Self-tests"), tests);
  const disabled = !mayOperate();
  const by = h("input", { id: "by", type: "text", autocomplete: "name", value: myName() });
  const reason = h("input", { id: "reason", type: "text" });
  faults.append(h("div", { class: "card" }, h("h2", {}, "Clear a fault"),
    h("p", {}, "Find the cause first. No power goes out: the outputs are off afterwards, and the next series begins with its self-test."),
    h("p", { class: "buttons" }, actionButton("Reset the power amplifier", () => send("POST", "devices/power_amplifier/reset"), { disabled })),
    h("div", { class: "filters" }, h("label", { for: "by" }, "My name ", by), h("label", { for: "reason" }, "What I found ", reason),
      actionButton("Clear the fault of a dead owner", async () => {
        rememberName(by.value);
        await send("POST", "platform/fault/reset", { by: by.value, reason: reason.value });
        refresh();
      }, { disabled }))));

  async function load() {
    const { items: devices } = await get("devices");
    fill(cards, devices.map(card));
  }

  async function loadTests() {
    const { items: jobs } = await get("jobs?kind=self_test&limit=5");
    const newest = jobs[0] && (await get(jobs[0].path));
    fill(tests, h("p", { class: "buttons" }, h("a", { href: "#/start/self-test" }, "Start a self-test")),
      table("Newest self-tests", ["When", "State", "Why it failed"], jobs.map((/** @type {any} */ job) => [when(job.created), h("a", { href: `#/jobs/${job.id}` }, job.state), job.error ?? ""]), "none yet"),
      newest?.state === "done" && h("details", {}, h("summary", {}, "What the newest one found"), h("pre", { class: "scroll", tabindex: 0 }, JSON.stringify(newest.result, null, 2))));
    const calibrations = await getList("calibrations?limit=200", 200);
    tests.append(table("Calibrations", ["When", "Kind", "State", "File"], calibrations.reverse().slice(0, 10).map((job) => [when(job.created), job.request.kind, h("a", { href: `#/jobs/${job.id}` }, job.state), job.result?.file ?? ""]), "none was made here"));
  }

  await Promise.all([load(), loadTests().catch((error) => fill(tests, errorBox(error)))]);
  return { load, concerns: (/** @type {any} */ what) => what.kind === "device", every_ms: 2000 };
}

/** @param {any} device */
function card(device) {
  const { identity } = device;
  return h("div", { class: "card" }, h("h2", { class: "words" }, NAMES[device.device] ?? plain(device.device)),
    device.error && h("p", { class: "error" }, device.error),
    facts([
      ["Is", identity && [identity.manufacturer, identity.model, identity.serial, identity.firmware].filter(Boolean).join(", ")],
      ...Object.entries(device.state).map(([key, value]) => /** @type {[string, any]} */ ([words(key), state(key, value)])),
      ["Read back", when(device.read_at)],
      ["Last error", device.last_error && [device.last_error.error, " (", when(device.last_error.at), ")"]],
    ]));
}

/** @param {string} key @param {any} value */
function state(key, value) {
  if (typeof value === "boolean") return value ? "yes" : "no";
  if (typeof value === "number") return key === "temperature_c" ? degrees(value) : `${significant(value, 7)} ${unitOf(key)}`.trim();
  return value ?? "none";
}
