// Series so far: parameters by shot with error bars and verdicts; a click opens the shot.
import { get } from "../api.js";
import { facts, fill, h, table } from "../dom.js";
import { definitionOf, heading, parameter, plain, significant, uncertain, valueOf } from "../format.js";
import { live, pathOfJob } from "../live.js";
import { Plot } from "../plot.js";

export const title = "Series";
const FIRST = ["f_nat_hz", "m_r_am2"];
const MOST_SHOTS = 3000;
const ROWS = 50;
const FITS_BEHIND = 100; // shots, of which the on-line fits may still come
/** @type {Point} */
const NO_POINT = { at: 0, label: "", href: null, verdict: "good", reason: null, parameters: {}, chi2: null };
const FEW = 8; // shots: below, their scatter says little

/** @typedef {{at: number, label: string, href: string | null, verdict: string, reason: string | null, blank?: boolean, parameters: Record<string, {value: number, std: number | null}>, chi2: number | null}} Point */

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  const whole = live.outer?.kind === "procedure" ? live.outer : live.job; // not one step of it
  const id = parts[0] ?? whole?.id ?? (await newestSeries());
  const head = h("div");
  const choose = h("div", { class: "filters" });
  const pictures = h("div", { class: "plots" });
  const list = h("div");
  root.replaceChildren(head, choose, pictures, list);
  if (!id) {
    fill(head, h("p", {}, "No series yet. ", h("a", { href: "#/start" }, "Start one")));
    return;
  }
  /** @type {Map<string, Plot>} */
  const plots = new Map();
  /** @type {Point[]} */
  let points = [];
  let chosen = [...FIRST, "chi2_per_dof", "temperature_c"];
  const what = id.startsWith("procedure-") ? "step" : "shot";

  async function load() {
    points = await readPoints(id, points);
    draw();
  }

  function draw() {
    const names = [...new Set(points.flatMap((point) => Object.keys(point.parameters)))];
    const refused = points.filter((point) => point.verdict !== "good");
    fill(head, facts([
      ["Series", id],
      [what === "step" ? "Steps" : "Shots", `${points.length}${points.length >= MOST_SHOTS ? ` (the last ${MOST_SHOTS})` : ""}, ${refused.length} refused`],
      ...FIRST.filter((name) => names.includes(name)).map((name) => /** @type {[string, any]} */ ([heading(name), mean(points, name)])),
    ]));
    if (!choose.childElementCount && names.length) choose.append(h("p", { class: "hint" }, `Bars: standard deviation of each fit. Dashed, from ${FEW} shots on: mean, and three standard deviations of the shots. Crosses: refused shots.`), chooser([...names, "chi2_per_dof"], chosen, (next) => { chosen = next; draw(); }));
    const drawn = chosen.filter((name) => names.includes(name) || points.some((point) => name === "chi2_per_dof" && point.chi2 !== null));
    for (const name of [...plots.keys()]) if (!drawn.includes(name)) { plots.get(name)?.close(); plots.get(name)?.place.remove(); plots.delete(name); }
    for (const name of drawn) {
      if (!plots.has(name)) {
        const place = h("div");
        const after = drawn.slice(drawn.indexOf(name) + 1).map((each) => plots.get(each)?.place).find(Boolean);
        pictures.insertBefore(place, after ?? null);
        plots.set(name, new Plot(place));
      }
      plots.get(name)?.draw(picture(name, points, what));
    }
    fill(list, table(`Newest ${what}s, ${Math.min(ROWS, points.length)} of ${points.length}`, [what === "step" ? "Step" : "Shot", "Verdict", ...FIRST.map(heading), "χ²/dof", "Why refused"],
      points.slice(-ROWS).reverse().map((point) => [
        point.href ? h("a", { href: point.href }, point.label) : point.label,
        h("span", { class: point.verdict === "good" ? "good" : "bad" }, point.blank ? "blank" : point.verdict),
        ...FIRST.map((name) => (point.parameters[name] ? parameter(name, point.parameters[name]) : "–")),
        point.chi2?.toFixed(3) ?? "–", point.reason ?? "",
      ])));
  }

  await load();
  return {
    load,
    concerns: (/** @type {any} */ what) => ["shot", "fit", "job"].includes(what.kind),
    close: () => plots.forEach((plot) => plot.close()),
  };
}

async function newestSeries() {
  const { items: jobs } = await get("jobs?kind=acquisition&kind=procedure&limit=10");
  return jobs.find((/** @type {any} */ each) => !each.within)?.id ?? null;
}

/** The shots of a series so far; from `before` those are kept whose fits are complete, the others are read again. @param {string} id @param {Point[]} before @returns {Promise<Point[]>} */
async function readPoints(id, before) {
  if (id.startsWith("procedure-")) return stepPoints(await get(`procedures/${id}`));
  if (!id.startsWith("acquisition-")) return recordedPoints(`recordings/${encodeURIComponent(id)}`);
  const pending = before.findIndex((point, k) => k >= before.length - FITS_BEHIND && point.verdict === "good" && !point.blank && !point.parameters.f_nat_hz);
  const points = before.slice(0, pending < 0 ? before.length : pending);
  if (!points.length) {
    const shots = await countShots(id);
    if (shots > MOST_SHOTS) points.push({ ...NO_POINT, at: shots - MOST_SHOTS });
  }
  for (let next = `acquisitions/${id}/shots?limit=500&after=${points.at(-1)?.at ?? 0}`; next; ) {
    const page = await get(next);
    points.push(...page.items.map((/** @type {any} */ shot) => shotPoint(id, shot)));
    next = page.next;
  }
  return points.filter((point) => point.label).slice(-MOST_SHOTS);
}

/** Shots of a series so far.  A job that has ended holds the fits of all its shots, so that the list in short is asked first. @param {string} id */
async function countShots(id) {
  const { items } = await get("jobs?kind=acquisition&limit=200");
  const job = items.find((/** @type {any} */ each) => each.id === id) ?? (await get(pathOfJob(id)));
  return Math.floor(job.progress.done);
}

/** @param {string} id @param {any} shot @returns {Point} */
function shotPoint(id, shot) {
  const refused = shot.verdict !== "good" || (!shot.blank && shot.fit && shot.fit.verdict !== "good");
  return {
    at: shot.shot, label: `shot ${shot.shot}`, href: `#/shot/${id}/${shot.frame}`, blank: shot.blank,
    verdict: refused ? "refused" : "good", reason: shot.reason ?? (shot.blank ? null : (shot.fit?.reason ?? null)),
    parameters: { ...shot.fit?.parameters, ...temperature(shot) }, chi2: shot.fit?.chi2_per_dof ?? null,
  };
}

/** What else a metrologist asks for, where it was measured. @param {any} shot @returns {Record<string, {value: number, std: null}>} */
function temperature({ temperature_c: value }) {
  return value === null || value === undefined ? {} : { temperature_c: { value, std: null } };
}

/** Steps of a procedure: medians of their shots. @param {any} job @returns {Point[]} */
function stepPoints(job) {
  return job.result.steps.map((/** @type {any} */ step) => {
    const { chi2_per_dof: chi2, r2: _, nrmse: __, ...results } = step.results ?? {};
    const parameters = Object.fromEntries(Object.entries(results).map(([name, /** @type {any} */ found]) => [name, { value: found.median, std: found.std }]));
    const values = step.values.map(valueOf).join(", ");
    return {
      at: step.step, label: `step ${step.step}${values ? `: ${values}` : ""}`, verdict: step.verdict, reason: step.reason, parameters, chi2: chi2?.median ?? null,
      href: job.result.recording && step.frames.length && job.state === "done" ? `#/shot/${job.result.recording}/${step.frames[0]}` : null,
    };
  });
}

/** @param {string} path @returns {Promise<Point[]>} */
async function recordedPoints(path) {
  const { frames } = await get(`${path}?limit=0`);
  const recording = await get(`${path}?first=${Math.max(0, frames - MOST_SHOTS)}`);
  return recording.shots.map((/** @type {any} */ shot) => ({
    at: shot.frame + 1, label: `frame ${shot.frame}`, href: `#/shot/${recording.id}/${shot.frame}`, verdict: shot.verdict,
    reason: shot.reason || null, blank: shot.blank, parameters: temperature(shot), chi2: null,
  }));
}

/** @param {string} name @param {Point[]} points @param {string} what they are */
function picture(name, points, what) {
  const isChi2 = name === "chi2_per_dof";
  const factor = isChi2 ? 1 : definitionOf(name).display_factor;
  const value = (/** @type {Point} */ p) => (isChi2 ? p.chi2 : (p.parameters[name]?.value ?? null));
  const std = (/** @type {Point} */ p) => (isChi2 ? 0 : (p.parameters[name]?.std ?? 0));
  const shift = (/** @type {number} */ sign) => points.map((p) => { const v = value(p); return v === null ? null : factor * (v + sign * std(p)); });
  const label = isChi2 ? "χ²/dof" : heading(name);
  const [middle, scatter] = spread(points, name).map((each) => factor * each);
  const usual = points.length < FEW || name === "temperature_c" ? [] : [middle - 3 * scatter, middle, middle + 3 * scatter];
  return {
    title: `${label} by ${what}`, xLabel: what, whole: true, yLabel: label, x: points.map((p) => p.at), limits: isChi2 ? [1] : usual,
    marks: points.filter((p) => p.verdict !== "good").map((p) => p.at),
    lines: [{ label: isChi2 ? label : definitionOf(name).symbol, values: shift(0), low: shift(-1), high: shift(1), points: true }],
    onPick: (/** @type {number} */ k) => { const href = points[k]?.href; if (href) location.hash = href; },
  };
}

/** Mean of the shots with its standard error. @param {Point[]} points @param {string} name */
function mean(points, name) {
  const [middle, scatter, count] = spread(points, name);
  const factor = definitionOf(name).display_factor;
  if (count < 2) return count ? significant(middle * factor, 8) : null;
  return `mean ${uncertain(middle, scatter / Math.sqrt(count), factor)}, scatter ${significant(scatter * factor, 2)}`;
}

/** Mean and standard deviation of the shots, and how many there are. @param {Point[]} points @param {string} name */
function spread(points, name) {
  const values = points.flatMap((p) => (p.parameters[name] ? [p.parameters[name].value] : []));
  const middle = values.reduce((a, b) => a + b, 0) / values.length;
  return [middle, Math.sqrt(values.reduce((a, b) => a + (b - middle) ** 2, 0) / (values.length - 1)), values.length];
}

/** @param {string[]} names @param {string[]} chosen @param {(next: string[]) => void} change */
function chooser(names, chosen, change) {
  return h("details", {}, h("summary", {}, "Parameters to show"), names.map((name) => {
    const box = h("input", { type: "checkbox", checked: chosen.includes(name), onchange: () => {
      chosen = box.checked ? [...chosen, name] : chosen.filter((each) => each !== name);
      change(chosen);
    } });
    return h("label", { class: "row" }, box, ` ${name === "chi2_per_dof" ? "χ²/dof" : plain(definitionOf(name).symbol)} `);
  }));
}
