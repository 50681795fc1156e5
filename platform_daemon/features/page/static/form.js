// Forms from JSON schemas: fields with unit, limits and default; refusals appear at the field that they name.
import { h } from "./dom.js";
import { microtesla, significant, unitOf, words } from "./format.js";

/** @typedef {Record<string, any>} JsonSchema */
/** @typedef {{element: HTMLElement, read: () => any, write: (value: any) => void, path: string, input?: HTMLElement, note?: HTMLElement, parts?: Field[], setHints?: (hints: any) => void}} Field */

const MISSING = undefined;

/** A form of a schema of the components of an OpenAPI document. */
export class SchemaForm {
  /** @param {JsonSchema} components @param {string} name @param {string[]} primary names of the keys that are shown at once */
  constructor(components, name, primary) {
    this.components = components;
    this.primary = new Set(primary);
    /** @type {Field[]} */ this.fields = [];
    this.root = this.object(this.resolve({ $ref: `#/components/schemas/${name}` }), "", true);
    this.element = this.root.element;
  }

  /** What is filled in, as the body of a request. */
  read() {
    return this.root.read() ?? {};
  }

  /** @param {any} value */
  write(value) {
    this.root.write(value);
  }

  /** The field of a path, also where the path begins further outside. @param {string} path */
  field(path) {
    const matching = this.fields.filter((field) => path === field.path || path.endsWith(`.${field.path}`) || path.startsWith(`${field.path}.`));
    return matching.sort((a, b) => b.path.length - a.path.length)[0];
  }

  clearProblems() {
    for (const field of this.fields) {
      field.input?.removeAttribute("aria-invalid");
      if (field.note) field.note.textContent = "";
    }
  }

  /** Shows a problem at its field.  False: no field has that name. @param {{where: string, detail: string}} problem */
  showProblem(problem) {
    const field = problem.where ? this.field(problem.where) : undefined;
    if (!field?.input || !field.note) return false;
    field.input.setAttribute("aria-invalid", "true");
    field.note.textContent = problem.detail;
    for (let outer = field.input.parentElement; outer; outer = outer.parentElement) if (outer instanceof HTMLDetailsElement) outer.open = true;
    field.input.focus();
    return true;
  }

  /** @param {JsonSchema} schema @returns {JsonSchema} */
  resolve(schema) {
    if (schema.$ref) {
      const { $ref, ...others } = schema;
      return { ...this.resolve(this.components[$ref.split("/").pop()]), ...others };
    }
    const choices = (schema.anyOf ?? []).filter((/** @type {JsonSchema} */ each) => each.type !== "null").map((/** @type {JsonSchema} */ each) => this.resolve(each));
    if (choices.length === 1) return { ...choices[0], ...schema, anyOf: undefined, nullable: true };
    if (choices.length > 1) return { ...schema, anyOf: choices, nullable: choices.length < schema.anyOf.length };
    return schema;
  }

  /** @param {JsonSchema} schema @param {string} path @param {boolean} outermost @returns {Field} */
  object(schema, path, outermost) {
    const required = new Set(schema.required ?? []);
    const parts = Object.entries(schema.properties ?? {}).map(([key, inner]) => ({
      key,
      shown: required.has(key) || this.primary.has(key),
      field: this.make(key, this.resolve(/** @type {JsonSchema} */ (inner)), path ? `${path}.${key}` : key, required.has(key)),
    }));
    const first = outermost || path === "acquisition" ? parts.filter((each) => each.shown) : [];
    const more = parts.filter((each) => !first.includes(each));
    const rest = more.length && h("details", {}, h("summary", {}, outermost ? "More settings" : `${words(path.split(".").pop() ?? "")}: settings`), outermost || path === "acquisition" ? null : hint(schema), more.map((each) => each.field.element));
    const element = outermost ? h("div", {}, first.map((each) => each.field.element), rest) : h("fieldset", {}, h("legend", {}, words(path.split(".").pop() ?? "")), first.map((each) => each.field.element), rest);
    return {
      element, path, parts: parts.map((each) => each.field),
      read: () => {
        const found = Object.fromEntries(parts.map((each) => [each.key, each.field.read()]).filter(([, value]) => value !== MISSING));
        return Object.keys(found).length || outermost || required.size ? found : MISSING;
      },
      write: (value) => parts.forEach((each) => value && each.key in value && each.field.write(value[each.key])),
    };
  }

  /** @param {string} key @param {JsonSchema} schema @param {string} path @param {boolean} required @returns {Field} */
  make(key, schema, path, required) {
    if (schema.const !== undefined) return { element: h("span", { hidden: true }), path, read: () => schema.const, write: () => {} };
    if (schema.type === "object" && schema.properties) return this.object(schema, path, false);
    const id = `field-${path.replaceAll(".", "-")}`;
    const { input, read, write } = inputFor(schema, { id, required });
    const unit = unitOf(key);
    const note = h("span", { class: "inline-error", id: `${id}-note`, role: "alert" });
    const about = h("span", { class: "hint", id: `${id}-hint` }, describe(schema));
    input.setAttribute("aria-describedby", `${id}-hint ${id}-note`);
    const small = unit === "T" && h("span", { class: "hint" });
    const showSmall = () => { if (small) small.textContent = inMicrotesla(input.value || input.placeholder); };
    input.addEventListener("input", showSmall);
    showSmall();
    const element = h("div", { class: "field" }, h("label", { for: id }, words(key), unit ? ` / ${unit}` : "", required ? " (needed)" : ""), h("div", { class: "row" }, input, small), about, note);
    /** @type {Field} */
    const field = { element, path, read, write, input, note };
    this.fields.push(field);
    return field;
  }
}

/** A field as people name it, beside the one in T. @param {string} text */
function inMicrotesla(text) {
  const tesla = Number.parseFloat(text);
  return Number.isFinite(tesla) ? `= ${microtesla(tesla)}` : "";
}

/** @param {JsonSchema} schema */
function hint(schema) {
  return schema.description ? h("p", { class: "hint" }, schema.description) : null;
}

/** What a field means, with its limits and default. @param {JsonSchema} schema */
function describe(schema) {
  const texts = [schema.description ?? ""];
  const number = (schema.anyOf ?? [schema]).find((/** @type {JsonSchema} */ each) => each.type === "number" || each.type === "integer");
  const low = number?.minimum ?? number?.exclusiveMinimum;
  const high = number?.maximum ?? number?.exclusiveMaximum;
  if (low !== undefined && high !== undefined) texts.push(`${number.exclusiveMinimum === undefined ? "From" : "Above"} ${significant(low)} to ${significant(high)}.`);
  else if (low !== undefined) texts.push(`${number.exclusiveMinimum === undefined ? "At least" : "More than"} ${significant(low)}.`);
  const preset = schema.default;
  if (preset !== undefined && preset !== null && preset !== "" && !(typeof preset === "object" && !Object.keys(preset).length)) texts.push(`Default ${show(preset)}.`);
  return texts.filter(Boolean).join(" ");
}

/** @param {any} value @returns {string} */
function show(value) {
  return Array.isArray(value) ? value.map(show).join(", ") : typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** @param {JsonSchema} schema @param {{id: string, required: boolean}} how @returns {{input: any, read: () => any, write: (value: any) => void}} */
function inputFor(schema, { id, required }) {
  if (schema.type === "boolean") {
    const input = h("input", { type: "checkbox", id, checked: schema.default === true });
    return { input, read: () => (input.checked === (schema.default === true) ? MISSING : input.checked), write: (value) => { input.checked = Boolean(value); } };
  }
  if (schema.enum) {
    const input = h("select", { id }, !required && h("option", { value: "" }, schema.default ? `default: ${schema.default}` : "not set"), schema.enum.map((/** @type {string} */ each) => h("option", { value: each }, words(each))));
    return { input, read: () => input.value || MISSING, write: (value) => { input.value = value ?? ""; } };
  }
  const numeric = schema.type === "number" || schema.type === "integer";
  const placeholder = schema.default === undefined || schema.default === null ? "" : show(schema.default);
  const simple = numeric || schema.type === "string" || schema.anyOf?.every((/** @type {JsonSchema} */ each) => ["string", "number", "integer"].includes(each.type));
  const list = schema.type === "array" && ["number", "integer", "string"].includes(itemType(schema));
  if (simple || list) {
    const input = h("input", { id, type: "text", inputmode: numeric ? "decimal" : null, placeholder, autocomplete: "off", spellcheck: "false" });
    const one = (/** @type {string} */ text) => (schema.nullable && text === "null" ? null : schema.type === "string" || text === "" || Number.isNaN(Number(text)) ? text : Number(text));
    const read = () => {
      const text = input.value.trim();
      if (text === "") return MISSING;
      return list ? text.split(",").map((/** @type {string} */ each) => one(each.trim())) : one(text);
    };
    return { input, read, write: (value) => { input.value = value === null || value === undefined ? "" : show(value); } };
  }
  const example = schema.default && Object.keys(schema.default).length ? JSON.stringify(schema.default) : "";
  const input = h("textarea", { id, rows: 3, placeholder: example, spellcheck: "false", cols: 50 });
  return { input, read: () => json(input.value), write: (value) => { input.value = value && Object.keys(value).length ? JSON.stringify(value) : ""; } };
}

/** @param {JsonSchema} schema */
function itemType(schema) {
  return schema.items?.type ?? schema.items?.anyOf?.find((/** @type {JsonSchema} */ each) => each.type === "string")?.type ?? "";
}

/** What is no JSON is sent as text: the daemon says what is wrong with it. @param {string} text */
function json(text) {
  if (!text.trim()) return MISSING;
  try {
    return JSON.parse(text);
  } catch {
    return text;
  }
}
