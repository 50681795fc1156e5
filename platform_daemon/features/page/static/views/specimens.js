// Specimens: facts, field limits, presets, models, and the trend with control limits and named changes.
import { get, getList, myName, rememberName, send } from "../api.js";
import { actionButton, errorBox, facts, fill, h, table } from "../dom.js";
import { definitionOf, degrees, heading, microtesla, reading, significant, when, whenText } from "../format.js";
import { Plot } from "../plot.js";
import { mayOperate } from "./job_actions.js";

export const title = "Specimens";
const NEWEST = 1000; // points, for which the daemon has a trend ready

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  if (parts[0]) return showOne(root, parts[0]);
  const names = await getList("specimens?limit=1000", 5000);
  fill(root, table("Specimens", ["Specimen"], names.map((/** @type {string} */ name) => [h("a", { href: `#/specimens/${encodeURIComponent(name)}` }, name)]), "none: measure with a name of the sample"));
}

/** @param {HTMLElement} root @param {string} name */
async function showOne(root, name) {
  const path = `specimens/${encodeURIComponent(name)}`;
  const about = h("div");
  const changes = h("div");
  const pictures = h("div", { class: "plots" });
  root.replaceChildren(h("h2", {}, name), about, changes, pictures);
  const asked = get(`${path}/trend?newest=${NEWEST}`, { slow: true });
  asked.catch(() => {}); // it is said below
  const found = await get(path, { slow: true });
  fill(about, facts([
    ["Recordings", h("a", { href: `#/recordings/of/${encodeURIComponent(name)}` }, found.recordings)], ["Shots", found.shots], ["First", when(found.first)], ["Last", when(found.last)],
    ["Calibrations", Object.entries(found.calibrations).map(([each, count]) => `${each} (${count})`).join(", ")], ["Tags", found.tags.join(", ")],
    ["Models adopted", found.models.map((/** @type {any} */ each) => each.label ?? each.name ?? each).join(", ")],
  ]), table("Resonators", ["Resonator", "Model", "Recordings", "Highest field", "Operating field", "Preset"], found.resonators.map((/** @type {any} */ each) => [
    each.key ?? each.name, each.variant, each.recordings, microtesla(each.max_field_t) ?? "not found by a ramp", microtesla(each.operating_field_t) ?? "–", preset(each.sequence)])));
  let trend;
  try {
    trend = await asked;
  } catch (error) {
    fill(changes, errorBox(error));
    return;
  }
  fill(changes, table("What changed, by name", ["Since", "What, and what to do", "By", "Noticed"], trend.changes.map((/** @type {any} */ each) => [
    when(each.since), each.what, `${significant(100 * each.relative, 3)} %`, [when(each.noticed), each.stands ? "" : " (over)"]]), "nothing but chance"),
  trend.notes.length > 0 && h("ul", {}, trend.notes.map((/** @type {string} */ note) => h("li", {}, note))));
  changes.append(table("What the temperature does, as far as the points tell", ["Quantity", "Coefficient / 10⁻⁶ K⁻¹"], trend.charts.filter((/** @type {any} */ chart) => chart.relative_per_k !== null).map((/** @type {any} */ chart) => [
    h("abbr", { title: definitionOf(chart.quantity).description }, definitionOf(chart.quantity).symbol), `${significant(1e6 * chart.relative_per_k, 3)} ± ${significant(1e6 * chart.relative_per_k_std, 2)}${chart.quantity.startsWith("rodrigues") ? " (of rad)" : ""}`]), "not known yet"));
  if (trend.measurand) changes.append(newestReading(trend));
  if (trend.changes.some((/** @type {any} */ each) => each.stands)) changes.append(accept(path));
  const times = trend.points.map((/** @type {any} */ point) => Date.parse(point.at));
  const span_ms = Math.max(...times) - times[0];
  const [unit, unit_ms] = span_ms > 3 * 86_400_000 ? ["days", 86_400_000] : span_ms > 3 * 3_600_000 ? ["hours", 3_600_000] : ["minutes", 60_000];
  const since = times.map((/** @type {number} */ at) => (at - times[0]) / unit_ms);
  if (since.length < 2) {
    fill(pictures, h("p", {}, "Trends are drawn from the second recording on."));
    return;
  }
  const axis = { x: since, xLabel: `${unit} since the first point` };
  const plots = [...drawReadings(pictures, trend.measurand, axis), ...trend.charts.flatMap((/** @type {any} */ chart) => draw(pictures, chart, axis, trend.points))];
  return { close: () => plots.forEach((/** @type {Plot} */ plot) => plot.close()) };
}

/** What a sensor has read last. @param {any} trend */
function newestReading({ measurand, points }) {
  const k = measurand.value.findLastIndex((/** @type {number | null} */ each) => each !== null);
  return h("p", { class: "large" }, k < 0 ? `${measurand.name} cannot be read at any point.` : `${measurand.name} ${reading(measurand.value[k], measurand.U[k], measurand.unit)}, ${when(points[k].at)}, by ${measurand.calibration}`);
}

/** Readings with their expanded uncertainty. @param {HTMLElement} pictures @param {any} measurand @param {{x: number[], xLabel: string}} axis */
function drawReadings(pictures, measurand, axis) {
  if (!measurand) return [];
  const end = (/** @type {number} */ sign) => measurand.value.map((/** @type {number | null} */ each, /** @type {number} */ k) => (each === null ? null : each + sign * measurand.U[k]));
  const place = h("div");
  pictures.append(place);
  const plot = new Plot(place);
  plot.draw({ ...axis, title: `${measurand.name} by ${measurand.calibration}, with U (95 %)`, yLabel: `${measurand.name} / ${measurand.unit}`, lines: [
    { label: measurand.name, values: measurand.value, points: true }, { label: "+ U", values: end(1), colour: "#d55e00" }, { label: "− U", values: end(-1), colour: "#d55e00" }] });
  if (measurand.low.every((/** @type {number | null} */ each) => each === null)) return [plot];
  const limits = h("div");
  pictures.append(limits);
  const chart = new Plot(limits);
  chart.draw({ ...axis, title: `${measurand.name}: weighted mean with control limits`, yLabel: `${measurand.name} / ${measurand.unit}`, lines: [
    { label: "EWMA", values: measurand.smoothed }, { label: "upper limit", values: measurand.high, colour: "#d55e00" }, { label: "lower limit", values: measurand.low, colour: "#d55e00" }] });
  return [plot, chart];
}

/** @param {HTMLElement} pictures @param {any} chart @param {{x: number[], xLabel: string}} axis @param {any[]} points */
function draw(pictures, chart, axis, points) {
  const factor = definitionOf(chart.quantity).display_factor;
  const scaled = (/** @type {(number | null)[]} */ values) => values.map((v) => (v === null ? null : v * factor));
  const xText = (/** @type {number} */ x) => whenText(points[axis.x.indexOf(x)].at);
  const onPick = (/** @type {number} */ k) => { location.hash = `#/recordings/${points[k].recording}`; };
  const shared = { ...axis, xText, onPick };
  const isKnown = chart.ewma.some((/** @type {number | null} */ v) => v !== null);
  const places = [h("div"), ...(isKnown ? [h("div")] : [])];
  pictures.append(...places);
  const [value, score] = places.map((place) => new Plot(place));
  value.draw({ ...shared, title: `${heading(chart.quantity)} at ${degrees(chart.reference_c) ?? "no known temperature"}`, yLabel: heading(chart.quantity), lines: [
    { label: "at that temperature", values: scaled(chart.corrected), points: true }, { label: "as measured", values: scaled(chart.value), points: true }] });
  const negative = chart.limit.map((/** @type {number | null} */ v) => (v === null ? null : -v));
  score?.draw({ ...shared, title: `${definitionOf(chart.quantity).symbol}: weighted mean with control limits`, yLabel: "deviation / σ", lines: [
    { label: "EWMA", values: chart.ewma }, { label: "upper limit", values: chart.limit, colour: "#d55e00" }, { label: "lower limit", values: negative, colour: "#d55e00" }] });
  return score ? [value, score] : [value];
}

/** A tuned preset in short. @param {any} sequence */
function preset(sequence) {
  if (!sequence) return "that of its variant";
  return [`${significant(sequence.f_tx_hz, 7)} Hz`, `${sequence.tx_periods} periods`, microtesla(sequence.field_t), `${sequence.rx_s} s of RX`].join(", ");
}

/** @param {string} path */
function accept(path) {
  const by = h("input", { id: "by", type: "text", autocomplete: "name", value: myName() });
  const why = h("input", { id: "why", type: "text" });
  return h("div", { class: "filters" }, h("label", { for: "by" }, "My name ", by), h("label", { for: "why" }, "Reason ", why), actionButton("Accept what changed as the new normal", async () => {
    rememberName(by.value);
    await send("POST", `${path}/baseline`, { by: by.value, reason: why.value });
    location.reload();
  }, { disabled: !mayOperate() }));
}
