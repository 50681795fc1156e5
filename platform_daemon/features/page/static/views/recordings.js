// Recordings: search, open, fit again, compare two, download.
import { download, get, send } from "../api.js";
import { actionButton, errorBox, facts, fill, h, table } from "../dom.js";
import { definitionOf, degrees, digits, duration, heading, microtesla, parameter, plain, significant, size, when } from "../format.js";
import { budget } from "./budget.js";
import { mayOperate } from "./job_actions.js";

export const title = "Recordings";
const PAGE = 50;
const MOST_FRAMES = 500;
const COMPARED_FROM = 100; // frames, among which one must be good
const LISTED = ["f_nat_hz", "m_r_am2"];
const NONE = "none matches. A series leaves one when it has ended.";
const COMPARED = ["f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "phi_max_rad"];

/** The search that was left, to which one comes back from a recording, with the pages that were turned and what was chosen. */
const left = { at: "", pages: [""], chosen: /** @type {string[]} */ ([]) };

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  if (parts[0] === "compare") return compare(root, parts[1], parts[2]);
  if (parts[0] && parts[0] !== "of") return showOne(root, parts[0]);
  const list = h("div");
  const field = (/** @type {string} */ name, /** @type {string} */ text, /** @type {Record<string, any>} */ more = {}) => h("label", {}, text, " ", h("input", { name, type: "text", ...more }));
  const verdict = h("select", { name: "refused" }, h("option", { value: "" }, "any"), h("option", { value: "false" }, "without refused shots"), h("option", { value: "true" }, "with refused shots"));
  const form = h("form", { class: "filters", onsubmit: (/** @type {Event} */ event) => { event.preventDefault(); pages = [firstPage()]; load(); } },
    field("specimen", "Specimen", { value: parts[1] ?? "" }), field("since", "Since", { type: "date" }), field("until", "Until", { type: "date" }), field("tag", "Tag"), field("operator", "Operator"), h("label", {}, "Shots ", verdict), h("button", {}, "Search"));
  const comparison = h("p", { class: "buttons" });
  root.replaceChildren(form, comparison, list);
  const drawComparison = () => fill(comparison, chosen.length === 2 ? h("a", { href: `#/recordings/compare/${chosen[0]}/${chosen[1]}` }, "Compare the two") : "Choose two to compare them.");
  const firstPage = () => {
    const query = new URLSearchParams([.../** @type {any} */ (new FormData(form))].filter(([, value]) => value));
    query.set("newest", "true");
    query.set("limit", String(PAGE));
    return `recordings?${query}`;
  };
  const back = left.at === location.hash;
  if (back) for (const [name, value] of new URLSearchParams(left.pages[0].split("?")[1])) if (form.elements.namedItem(name)) form.elements.namedItem(name).value = value;
  let pages = back ? left.pages : [firstPage()];
  let chosen = back ? left.chosen : [];

  async function load() {
    Object.assign(left, { at: location.hash, pages, chosen });
    const found = await get(/** @type {string} */ (pages.at(-1)));
    drawComparison();
    fill(list, table("Recordings", ["Recording", "Date", "Sample", "Frames", ...LISTED.map(heading), "Size", "Compare"], found.items.map((/** @type {any} */ each) => [
      h("a", { href: `#/recordings/${encodeURIComponent(each.id)}` }, each.id), [when(each.date), each.clock === "simulated" && " (simulated time)"], each.sample ?? each.resonator ?? each.variant ?? "", [each.frames, each.refused ? h("span", { class: "warn" }, `, ${each.refused} refused`) : null],
      ...LISTED.map((name) => digits(each[name] === null ? null : each[name] * definitionOf(name).display_factor, 7)), size(each.size_bytes),
      [each.incomplete && h("span", { class: "warn" }, each.incomplete, " "), h("label", {}, h("input", { type: "checkbox", "data-key": "compare", value: each.id, checked: chosen.includes(each.id), "aria-label": `Compare ${each.id}`, onchange: (/** @type {any} */ event) => {
        chosen = event.target.checked ? [...chosen, each.id].slice(-2) : chosen.filter((id) => id !== each.id);
        left.chosen = chosen;
        drawComparison();
        for (const box of list.querySelectorAll("[data-key=compare]")) box.checked = chosen.includes(box.value); // of three the first is left out
      } }), " compare")],
    ]), NONE), found.broken.length > 0 && table("What cannot be read", ["File", "Why"], found.broken.map((/** @type {any} */ each) => [each.path, each.error.detail])),
    found.broken.length > 0 && h("p", {}, actionButton("Put kept shots together", async () => { await send("POST", "recordings/recover"); await load(); }, { disabled: !mayOperate() })),
    h("p", { class: "buttons" }, pages.length > 1 && h("button", { type: "button", onclick: () => { pages.pop(); load(); } }, "Back"), found.next && h("button", { type: "button", onclick: () => { pages.push(found.next); load(); } }, "More")));
  }
  await load();
  return { load, concerns: (/** @type {any} */ what) => what.kind === "job" && Boolean(what.recording) && pages.length === 1 };
}

/** @param {HTMLElement} root @param {string} id */
async function showOne(root, id) {
  const path = `recordings/${encodeURIComponent(id)}`;
  let found;
  try {
    found = await get(`${path}?limit=${MOST_FRAMES}`);
  } catch (error) {
    fill(root, errorBox(error), h("p", {}, h("a", { href: "#/recordings" }, "See what is there")));
    return;
  }
  const fits = h("div");
  fill(root, h("h2", {}, found.title || id),
    facts([
      ["Id", id], ["Date", [when(found.start_time), found.clock === "simulated" && " (simulated time)"]], ["Sample", found.sample], ["Operator", found.operator], ["Comment", found.comment],
      ["Frames", `${found.frames}, ${found.frames - found.good} refused`], ["Model", found.variant], ["RX window", duration(found.windows?.rx?.seconds)],
      ["Sampling rate", `${significant(found.rate_hz, 7)} Hz`], ["Calibration", found.calibration?.id ?? "none"], ["Size", size(found.size_bytes)],
      ["Incomplete", found.incomplete],
    ]),
    h("p", { class: "buttons" }, actionButton("Download", () => download(`${path}/file`, found.file)), h("a", { href: `#/start/fit/${id}` }, "Fit again"), h("a", { href: `#/start/diagnose/${id}` }, "Diagnose"), id.startsWith("acquisition-") && h("a", { href: `#/series/${id}` }, "Parameters by shot")),
    found.good > 0 && budget(path),
    fits,
    table("Frames", ["Frame", "Time", "Verdict", "Field", "Temperature", "Why refused"], found.shots.map((/** @type {any} */ shot) => [
      h("a", { href: `#/shot/${id}/${shot.frame}` }, `frame ${shot.frame}`), when(shot.time_stamp), shot.blank ? "blank" : shot.verdict,
      microtesla(shot.excitation?.field_t), degrees(shot.temperature_c), shot.reason])),
    found.frames > found.shots.length && h("p", {}, `The first ${found.shots.length} of ${found.frames} frames. `, id.startsWith("acquisition-") && h("a", { href: `#/series/${id}` }, "See the last ones")));
  const { items: jobs } = await get("jobs?kind=fit&limit=50");
  const own = (await Promise.all(jobs.map((/** @type {any} */ job) => get(job.path)))).filter((job) => job.request.recording === id);
  fill(fits, table("Fits made again", ["When", "Model", "Window", "State", ...COMPARED.slice(0, 2).map(heading)], own.map((job) => [
    when(job.created), job.request.variant ?? found.variant, String(job.request.window), h("a", { href: `#/jobs/${job.id}` }, job.state),
    ...COMPARED.slice(0, 2).map((name) => firstGood(job.result?.frames, name))]), "none"));
}

/** @param {any[] | undefined} frames @param {string} name */
function firstGood(frames, name) {
  const good = frames?.find((frame) => frame.parameters?.[name]);
  return good ? parameter(name, good.parameters[name]) : "–";
}

/** Two recordings side by side: their first good shots. @param {HTMLElement} root @param {string} one @param {string} other */
async function compare(root, one, other) {
  root.textContent = "Fitting a shot of each …";
  const found = await Promise.all([one, other].map(async (id) => {
    const info = await get(`recordings/${encodeURIComponent(id)}?limit=${COMPARED_FROM}`);
    const shot = info.shots.find((/** @type {any} */ each) => each.verdict === "good" && !each.blank);
    const fit = shot ? (await get(`recordings/${encodeURIComponent(id)}/frames/${shot.frame}/plot?points=2`, { slow: true })).fit : null;
    return { info, shot, fit };
  }));
  const [a, b] = found;
  const names = COMPARED.filter((name) => a.fit?.parameters[name] && b.fit?.parameters[name]);
  fill(root, table("First good shot of each", ["Quantity", one, other, "Difference / σ"], [
    ["Date", ...found.map(({ info }) => when(info.start_time)), ""],
    ["Sample", ...found.map(({ info }) => info.sample), ""],
    ["Calibration", ...found.map(({ info }) => info.calibration?.id ?? "none"), ""],
    ["Temperature", ...found.map(({ shot }) => degrees(shot?.temperature_c) ?? "–"), ""],
    ["Field", ...found.map(({ shot }) => microtesla(shot?.excitation?.field_t) ?? "–"), ""],
    ["χ²/dof", ...found.map(({ fit }) => significant(fit?.chi2_per_dof, 4)), ""],
    ...names.map((name) => {
      const [p, q] = [a.fit.parameters[name], b.fit.parameters[name]];
      return [heading(name), parameter(name, p), parameter(name, q), significant((q.value - p.value) / Math.hypot(p.std ?? 0, q.std ?? 0), 3)];
    }),
  ]), h("p", { class: "hint" }, "Standard deviations are those of single fits: what differs from shot to shot, as the temperature, is not in them.", a.info.sample && a.info.sample === b.info.sample && [" ", h("a", { href: `#/specimens/${encodeURIComponent(a.info.sample)}` }, `See ${a.info.sample} at one temperature`), "."]), found.some(({ fit }) => fit?.verdict !== "good") && h("p", { class: "warn" }, found.map(({ fit }) => plain(fit?.reason ?? "")).join(" ")));
}
