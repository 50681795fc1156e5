// Numbers with units and the digits that their uncertainty allows, times in the zone of the browser.
import { getPageFile } from "./api.js";

/** @typedef {{symbol: string, display_unit: string, display_factor: number, description: string}} Definition */

/** @type {Record<string, Definition>} */
let definitions = {};
/** What is no parameter of a fit. @type {Record<string, Definition>} */
const OTHERS = {
  temperature_c: { symbol: "temperature", display_unit: "°C", display_factor: 1, description: "Temperature of the platform" },
  nrmse: { symbol: "residual", display_unit: "%", display_factor: 100, description: "Root mean square of the residual over that of the signal" },
  ...Object.fromEntries(["x", "y", "z"].map((axis) => [`noise_${axis}_v`, { symbol: `noise ${axis}`, display_unit: "mV", display_factor: 1000, description: `Standard deviation of the noise of channel ${axis}` }])),
};

/** Loads symbols and units of the parameters, which the daemon defines. */
export async function loadDefinitions() {
  definitions = { ...(await getPageFile("parameters.json")), ...OTHERS };
}

/** @param {string} name @returns {Definition} */
export function definitionOf(name) {
  return definitions[name] ?? { symbol: name, display_unit: "", display_factor: 1, description: "" };
}

/** Symbol and unit, as for the heading of a column. @param {string} name */
export function heading(name) {
  const { symbol, display_unit: unit } = definitionOf(name);
  return unit ? `${symbol} / ${unit}` : symbol;
}

/**
 * A value with its standard deviation in brackets at the last digits, 215.6903(12), as the command line prints it.
 * @param {number | null | undefined} value @param {number | null | undefined} std @param {number} [factor]
 */
export function uncertain(value, std, factor = 1) {
  if (value === null || value === undefined) return "–";
  if (!std || !(std > 0)) return significant(value * factor);
  const digits = Math.max(0, 1 - Math.floor(Math.log10(std * factor)));
  if (digits > 15) return significant(value * factor);
  return `${(value * factor).toFixed(digits)}(${Math.round(std * factor * 10 ** digits)})`;
}

/** A parameter of a fit in the unit that people read. @param {string} name @param {{value: number, std: number | null}} estimate */
export function parameter(name, estimate) {
  return uncertain(estimate.value, estimate.std, definitionOf(name).display_factor);
}

/** @param {number | null | undefined} value @param {number} [digits] */
export function significant(value, digits = 6) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  return String(Number(value.toPrecision(digits)));
}

/** A value with its expanded uncertainty, to two digits of it. @param {number} value @param {number} expanded @param {string} unit */
export function reading(value, expanded, unit) {
  const places = Math.min(100, Math.max(0, 1 - Math.floor(Math.log10(expanded))));
  return `(${value.toFixed(places)} ± ${expanded.toFixed(places)})\u00a0${unit}`;
}

/** What a sensor reads, or why it does not. @param {any} reads */
export function readingInWords(reads) {
  return reads.value === null ? `${reads.name} cannot be read: ${reads.reason}` : `${reads.name} ${reading(reads.value, reads.U, reads.unit)}`;
}

/** So many significant digits, also where the last are zeros: for what stands in a column. @param {number | null | undefined} value @param {number} digits */
export function digits(value, digits) {
  return value === null || value === undefined || !Number.isFinite(value) ? "–" : value.toPrecision(digits);
}

/** @param {number | null | undefined} tesla */
export function microtesla(tesla) {
  return tesla === null || tesla === undefined ? null : `${significant(tesla * 1e6, 4)}\u00a0µT`;
}

/** @param {number | null | undefined} celsius */
export function degrees(celsius) {
  return celsius === null || celsius === undefined ? null : `${celsius.toFixed(2)}\u00a0°C`;
}

/** State and phase of a job, said once where they are the same. @param {any} job */
export function stateOf(job) {
  return job.progress.phase === job.state ? job.state : `${job.state}, ${job.progress.phase}`;
}

/** A duration in words. @param {number | null | undefined} seconds */
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  const s = Math.max(0, seconds);
  if (s < 10) return `${s.toFixed(1)}\u00a0s`;
  if (s < 120) return `${Math.round(s)}\u00a0s`;
  if (s < 7200) return `${Math.floor(s / 60)} min ${Math.round(s % 60)} s`;
  if (s < 172800) return `${Math.floor(s / 3600)} h ${Math.round((s % 3600) / 60)} min`;
  return `${Math.round(s / 86400)} days`;
}

/** @param {number | null | undefined} bytes */
export function size(bytes) {
  if (bytes === null || bytes === undefined) return "–";
  return bytes >= 1e9 ? `${(bytes / 1e9).toFixed(1)}\u00a0GB` : `${(bytes / 1e6).toFixed(bytes < 1e7 ? 1 : 0)}\u00a0MB`;
}

const DATE = new Intl.DateTimeFormat(undefined, { dateStyle: "medium", timeStyle: "medium" });
const CLOCK = new Intl.DateTimeFormat(undefined, { timeStyle: "medium" });

/** Date and time of an ISO 8601 string. @param {string | null | undefined} iso */
export function when(iso) {
  if (!iso || Number.isNaN(Date.parse(iso))) return iso || "–";
  const element = document.createElement("time");
  element.dateTime = iso;
  element.textContent = whenText(iso);
  return element;
}

/** The same as text. @param {string} iso */
export function whenText(iso) {
  const date = new Date(iso);
  const today = date.toDateString() === new Date().toDateString();
  return (today ? CLOCK : DATE).format(date);
}

/** Now, to the second. */
export function clockNow() {
  return CLOCK.format(new Date());
}

/** The zone of all times of the page. */
export function zone() {
  return Intl.DateTimeFormat().resolvedOptions().timeZone;
}

/** Words for a name of a key: "max_field_t" becomes "max field", and its unit is given by unitOf. @param {string} key */
export function words(key) {
  return key.replace(UNIT, "").replaceAll("_", " ");
}

const UNIT = /_(hz|s|t|ut|rad|deg|v|a|am2|am2_per_s|per_s|c|am2_per_s2|rad_per_s2|db|samples)$/;
/** @type {Record<string, string>} */
const UNITS = {
  hz: "Hz", s: "s", t: "T", ut: "µT", rad: "rad", deg: "°", v: "V", a: "A", am2: "A m²", am2_per_s: "A m²/s",
  per_s: "1/s", c: "°C", am2_per_s2: "A m²/s²", rad_per_s2: "rad/s²", db: "dB", samples: "samples",
};

/** The unit at the end of the name of a key, or "". @param {string} key */
export function unitOf(key) {
  return UNITS[UNIT.exec(key)?.[1] ?? ""] ?? "";
}

/** What a job does, in words. @param {any} job */
export function nameOf({ request, kind }) {
  return [plain(request?.kind ?? kind), request?.resonator ?? request?.acquisition?.resonator].filter(Boolean).join(" of ");
}

/** A value that a step sets, with its unit: "field 110 µT". @param {{key: string, value: any}} set */
export function valueOf({ key, value }) {
  return `${words(key)} ${typeof value === "number" ? significant(value, 5) : value} ${unitOf(key)}`.trim();
}

/** Words for a kind of job or a state. @param {string} text */
export function plain(text) {
  return text.replaceAll("_", " ");
}
