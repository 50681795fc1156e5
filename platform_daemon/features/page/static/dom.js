// Makes elements of the document.

/** @typedef {Node | string | number | null | undefined | false} Child */

/**
 * An element.  Attributes whose name begins with "on" are listeners; true writes an attribute without a value, false,
 * null and undefined leave it out.
 * @param {string} tag
 * @param {Record<string, any>} [attributes]
 * @param {...(Child | Child[])} children
 * @returns {any}
 */
export function h(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (name === "value") /** @type {any} */ (element).value = value;
    else if (value === true) element.setAttribute(name, "");
    else if (value !== false && value !== null && value !== undefined) element.setAttribute(name, String(value));
  }
  append(element, children);
  return element;
}

/** @param {Element} element @param {(Child | Child[])[]} children */
function append(element, children) {
  for (const child of children.flat(3)) {
    if (child === null || child === undefined || child === false) continue;
    element.append(child instanceof Node ? child : String(child));
  }
}

/**
 * Replaces the content of an element, unless it would be the same: what has the focus keeps it then.
 * @param {Element} element @param {...(Child | Child[])} children
 */
export function fill(element, ...children) {
  const made = document.createElement("div");
  append(made, children);
  if (made.childNodes.length === element.childNodes.length && made.innerHTML === element.innerHTML && !hasListeners(made))
    return;
  const focused = document.activeElement;
  const key = focused && element.contains(focused) ? focused.getAttribute("data-key") : null;
  element.replaceChildren(...made.childNodes);
  if (key) /** @type {HTMLElement | null} */ (element.querySelector(`[data-key="${CSS.escape(key)}"]`))?.focus();
}

/** @param {Element} element */
function hasListeners(element) {
  return element.querySelector("button, input, select, textarea") !== null;
}

/**
 * A table; a caption says what it holds.  Rows are lists of cells, the first cell of each is its heading.
 * @param {string} caption @param {string[]} headings @param {(Child | Child[])[][]} rows @param {string} [empty]
 */
export function table(caption, headings, rows, empty = "Nothing here.") {
  if (rows.length === 0) return h("p", { class: "empty" }, `${caption}: ${empty}`);
  return h(
    "div",
    { class: "scroll", tabindex: 0, role: "region", "aria-label": caption },
    h(
      "table",
      {},
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, headings.map((text) => h("th", { scope: "col" }, text)))),
      h(
        "tbody",
        {},
        rows.map((row) =>
          h("tr", {}, row.map((cell, k) => (k ? h("td", {}, cell) : h("th", { scope: "row" }, cell)))),
        ),
      ),
    ),
  );
}

/** A list of terms with their values; pairs whose value is null are left out. @param {[string, any][]} pairs */
export function facts(pairs) {
  return h(
    "dl",
    { class: "facts" },
    pairs
      .filter(([, value]) => value !== null && value !== undefined && value !== "")
      .map(([term, value]) => h("div", {}, h("dt", {}, term), h("dd", {}, value))),
  );
}

/**
 * Runs `work` one call at a time; calls during a run cause exactly one further run (coalescing).
 * @param {() => Promise<void>} work
 */
export function oneAtATime(work) {
  /** @type {Promise<void> | null} */ let running = null;
  let again = false;
  return () => {
    again = true;
    running ??= (async () => {
      try {
        while (again) {
          again = false;
          await work();
        }
      } finally {
        running = null;
      }
    })();
    return running;
  };
}

/** Reads text to screen readers. @param {string} text */
export function say(text) {
  const place = document.getElementById("spoken");
  if (place) place.textContent = text;
}

/** The message of an error, with where, why and the remedy where it has them. @param {any} error */
export function errorText(error) {
  return error?.detail ?? error?.message ?? String(error);
}

/** @param {any} error */
export function errorBox(error) {
  return h("p", { class: "error", role: "alert" }, errorText(error));
}

/**
 * A button whose action runs once at a time: a double click sends nothing twice.  Errors appear next to it.
 * @param {string} text @param {() => Promise<any>} action @param {Record<string, any>} [attributes]
 */
export function actionButton(text, action, attributes = {}) {
  const button = h("button", { type: "button", "data-key": text, ...attributes }, text);
  const message = h("span", { class: "inline-error", role: "alert" });
  button.addEventListener("click", async () => {
    if (button.disabled) return;
    button.disabled = true;
    message.textContent = "";
    try {
      await action();
    } catch (error) {
      message.textContent = errorText(error);
    } finally {
      button.disabled = Boolean(attributes.disabled);
    }
  });
  return h("span", { class: "action" }, button, message);
}
