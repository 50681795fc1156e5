// Now: the state of each device, the job that runs, the age of what is shown, and who did what.
import { get } from "../api.js";
import { facts, fill, h, table } from "../dom.js";
import { degrees, duration, nameOf, plain, significant, when } from "../format.js";
import { live } from "../live.js";
import { jobActions } from "./job_actions.js";

export const title = "Now";
const CHANGES = 8;

/** @param {HTMLElement} root */
export function show(root) {
  const job = h("div", { class: "card" });
  const devices = h("div", { class: "card" });
  const events = h("div", { class: "card events" });
  const buttons = h("p", { class: "buttons" });
  const changes = h("div", { class: "card" });
  root.classList.add("cards");
  const about = h("div");
  const queue = h("div");
  job.append(about, buttons, queue);
  root.replaceChildren(job, devices, events, changes);
  /** @type {any} */ let read = null; // what the devices are drawn by; it changes with a poll, more seldom than events come

  async function load() {
    const { items } = await get(`changes?limit=${CHANGES}`);
    fill(changes, h("h2", {}, "Who did what"), table("Newest first", ["Time", "Who", "What"], items.map((/** @type {any} */ each) => [
      when(each.when), `${each.who} at ${each.address}`, [plain(each.what), each.outcome === "done" ? null : h("span", { class: "bad" }, `: ${each.outcome}`)]]), "nothing was started, changed or stopped yet"));
  }

  function update() {
    if (!live.platform) return;
    drawJob(about);
    fill(buttons, live.job && jobActions(live.outer ?? live.job));
    const waiting = live.platform.queued.length;
    fill(queue, h("p", {}, waiting ? h("a", { href: "#/jobs" }, `${waiting} waiting`) : "Nothing waits."));
    if (read !== live.platform) fill(devices, h("h2", {}, "Devices"), deviceFacts(live.platform));
    read = live.platform;
    fill(events, h("h2", {}, "Events"), eventTable());
  }
  load().catch(() => {}); // it is read again with the next tick
  return { update, load, concerns: (/** @type {any} */ what) => what.kind === "job", every_ms: 10_000 };
}

/** @param {HTMLElement} place */
function drawJob(place) {
  const { job, outer } = live;
  if (!job) {
    fill(place, h("h2", {}, "Idle"), h("p", {}, "No job runs. ", h("a", { href: "#/start" }, "Start one")));
    return;
  }
  const { progress } = job;
  const done = progress.unit === "shots" ? `shot ${Math.min(progress.total, Math.floor(progress.done) + 1)} of ${progress.total}` : `${Math.round(100 * progress.fraction)} %`;
  fill(
    place,
    h("h2", { class: "words" }, outer ? [plain(outer.procedure ?? outer.kind), outer.resonator].filter(Boolean).join(" of ") : nameOf(job)),
    h("p", { class: "large" }, (outer ?? job).paused ? `paused, ${done}` : done),
    h("progress", { max: 1, value: (outer ?? job).progress.fraction, "aria-label": "Progress" }),
    facts([
      ["Step", outer && h("a", { href: `#/${outer.procedure === "ramp" ? "ramp" : "jobs"}/${outer.id}` }, outer.progress.phase)],
      ["Does", progress.phase.replace(/^shot \d+: /, "")], // its number is older than the events
      ["Time left", duration((outer ?? job).progress.time_left_s)],
      ["Began", when(job.started)],
      ["Shots", outer?.kind === "procedure" ? h("a", { href: `#/series/${outer.id}` }, "steps so far") : job.recording && h("a", { href: `#/series/${job.recording}` }, "series so far")],
      ["Warnings", job.warnings?.join("; ")],
    ]),
  );
}

/** @param {any} p */
function deviceFacts(p) {
  const amplifier = p.power_amplifier;
  return facts([
    ["Interlock", p.interlock ? `closed: ${p.interlock}` : "open: power may go out"],
    ["Power amplifier", amplifier.fault ? `FAULT: ${amplifier.fault}` : `${amplifier.enabled ? "ENABLED" : "off"}${amplifier.muted ? ", muted" : ""}${amplifier.clipped ? ", has clipped" : ""}`],
    ["Heat sink", degrees(amplifier.temperature_c)],
    ["Tx/Rx switch", p.tx_rx_switch.position],
    ["I/O card", p.io_card.state],
    ["Receive amplifier", `gain ${p.lna.gain}${p.lna.overloaded ? ", OVERLOADED" : ""}`],
    ["Temperature", degrees(p.temperature_c) ?? "not measured"],
    ["Calibration", calibration(p.calibration)],
    ["Transmit calibration", p.transmit_calibration ? calibration(p.transmit_calibration) : "as the platform file declares"],
    ["Read back", [when(p.read_at), live.job?.clock === "simulated" && " (simulated time)"]],
  ]);
}

/** @param {{id: string, date: string | null}} used */
function calibration(used) {
  const now = Date.now() - (Number.isFinite(live.clock_off_s) ? 1000 * live.clock_off_s : 0); // by the clock of the daemon
  const age_days = used.date ? (now - Date.parse(used.date)) / 86_400_000 : NaN;
  return Number.isFinite(age_days) ? `${used.id}, ${Math.max(0, Math.floor(age_days))} days old` : used.id;
}

function eventTable() {
  const newest = [...live.events].reverse().slice(0, 12);
  const age_s = (performance.now() - live.event_ms) / 1000;
  return [
    h("p", {}, age_s < 5 ? "Last event just now." : Number.isFinite(age_s) ? `Last event ${duration(Math.floor(age_s / 5) * 5)} ago.` : "No event since the page was opened."),
    table("Newest events", ["Time", "What"], newest.map((each) => [when(each.at), describe(each.what)]), "none yet"),
  ];
}

/** What an event says, in words. @param {any} what */
export function describe(what) {
  switch (what.kind) {
    case "job":
      return `${plain(what.job_kind)} ${what.state}${what.error ? `: ${what.error}` : ""}`;
    case "shot":
      return h("a", { href: `#/shot/${what.recording}/${what.frame}` }, `shot ${what.shot} of ${what.of}: ${what.verdict}${what.reason ? `, ${what.reason}` : ""}`);
    case "fit":
      return what.f_nat_hz === null ? `fit of shot ${what.shot} refused: ${what.reason}` : `fit of shot ${what.shot}: f_nat ${significant(what.f_nat_hz, 7)} Hz`;
    case "measurand":
      return what.value === null ? `shot ${what.shot}: ${what.name} cannot be read: ${what.reason}` : `shot ${what.shot}: ${what.name} ${significant(what.value, 6)} ${what.unit}, U ${significant(what.U, 2)} ${what.unit}`;
    case "device":
      return what.error ? `${plain(what.device)}: ${what.error}` : `${plain(what.device)} answers again`;
    case "interlock":
      return what.why ? `interlock closed: ${what.why}` : "interlock open";
    case "alarm":
      return `alarm ${what.state}${what.by ? ` by ${what.by}` : ""}: ${what.what}`;
    case "schedule":
      return `schedule: ${what.state}${what.reason ? `, ${what.reason}` : ""}`;
    default:
      return what.count === null ? "events were lost" : `${what.count} events were skipped`;
  }
}
