// The uncertainty budget of a recording: what each influence contributes, with a bar, and what nobody has declared.
import { get } from "../api.js";
import { actionButton, fill, h, table } from "../dom.js";
import { definitionOf, heading, significant } from "../format.js";

const QUANTITIES = ["f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2"];
const SHOWN = 0.01; // of the combined standard uncertainty, as the command line has it

/** It takes the daemon a second, and is asked for when somebody wants it. @param {string} path of the recording */
export function budget(path) {
  const quantity = /** @type {HTMLSelectElement} */ (h("select", { name: "budget" }, QUANTITIES.map((name) => h("option", { value: name }, definitionOf(name).symbol))));
  const found = h("div");
  const ask = async () => fill(found, shown(await get(`${path}/budget?quantity=${quantity.value}`, { slow: true })));
  return h("div", {}, h("p", { class: "buttons" }, h("label", {}, "Uncertainty of ", quantity), actionButton("Show the budget", ask)), found);
}

/** @param {any} told */
function shown(told) {
  const { display_factor: factor, display_unit: unit } = definitionOf(told.quantity);
  const size = (/** @type {number} */ value, /** @type {number} */ digits) => `${significant(value * factor, digits)} ${unit}`;
  const large = told.inputs.filter((/** @type {any} */ line) => line.contribution >= SHOWN * told.u);
  return [
    h("p", {}, `${definitionOf(told.quantity).symbol} = ${size(told.value, 9)}, U = ${size(told.U, 2)} (k = ${significant(told.k, 3)}, ${significant(100 * told.coverage)} %)`),
    table(`What contributes to u = ${size(told.u, 2)}`, ["Input", "Type", heading(told.quantity), "Share of u", "Source"], large.map((/** @type {any} */ line) => [
      line.name, line.type, significant(line.contribution * factor, 3), h("meter", { max: told.u, value: line.contribution, "aria-label": `${line.name}: ${significant((100 * line.contribution) / told.u, 2)} % of u` }), line.source])),
    told.not_declared.length > 0 && table("Not declared, and not contained", ["Influence", `Would add / ${unit}`], told.not_declared.map((/** @type {any} */ each) => [each.name, each.would_add_per_unit === null ? "not known" : significant(each.would_add_per_unit * factor, 3)])),
    told.temperature && h("p", {}, `Temperature: ${told.temperature}.`),
  ];
}
