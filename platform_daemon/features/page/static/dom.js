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

/** What is to stand in elements that are pressed just now, each with its content. @type {Map<Element, Element>} */
const held = new Map();
/** @type {Element | null} */ let pressed = null;

/** @param {Event} event */
function press(event) {
  if (!(event instanceof KeyboardEvent) || event.key === " ") pressed = /** @type {Element} */ (event.target);
}

/** Lets go of what was pressed, after the click that follows. */
function release() {
  setTimeout(() => {
    pressed = null;
    for (const [element, made] of held) replace(element, made);
    held.clear();
  });
}

for (const name of ["pointerdown", "keydown"]) addEventListener(name, press, true);
for (const name of ["pointerup", "pointercancel", "keyup", "blur"]) addEventListener(name, release);

/**
 * Gives an element other content.  What can be the same stays: the focus, an opened detail, and what need not be drawn
 * anew.  While something in it is pressed it stays as it is, since a button that is replaced between the press and the
 * release gets no click.
 * @param {Element} element @param {...(Child | Child[])} children
 */
export function fill(element, ...children) {
  const made = document.createElement("div");
  append(made, children);
  if (!hasListeners(made) && !hasListeners(element)) become(element, made);
  else if (pressed && element.contains(pressed)) held.set(element, made);
  else replace(element, made);
}

/** Replaces the children of an element; the focus goes to what has come in its place. @param {Element} element @param {Element} made */
function replace(element, made) {
  const focused = document.activeElement;
  const key = focused && element.contains(focused) ? focused.getAttribute("data-key") : null;
  element.replaceChildren(...made.childNodes);
  if (key) /** @type {HTMLElement | null} */ (element.querySelector(`[data-key="${CSS.escape(key)}"]`))?.focus();
}

/** Makes the children of an element those of another one, which is used up. @param {Element} element @param {Element} other */
function become(element, other) {
  const before = [...element.childNodes];
  const after = [...other.childNodes];
  after.forEach((node, k) => {
    const old = before[k];
    if (!old) element.append(node);
    else if (!alike(old, node)) old.replaceWith(node);
    else if (old instanceof Element && node instanceof Element) become(old, node);
    else if (old.nodeValue !== node.nodeValue) old.nodeValue = node.nodeValue;
  });
  for (const old of before.slice(after.length)) old.remove();
}

/** May a node stay where this one is to be?  Its attributes are made the same. @param {Node} old @param {Node} node */
function alike(old, node) {
  if (old.nodeName !== node.nodeName) return false;
  if (!(old instanceof Element && node instanceof Element)) return true;
  for (const name of node.getAttributeNames()) {
    const value = node.getAttribute(name) ?? "";
    if (old.getAttribute(name) !== value) old.setAttribute(name, value);
  }
  return old.getAttributeNames().every((name) => node.hasAttribute(name) || (name === "open" && old.nodeName === "DETAILS"));
}

/** @param {Element} element */
function hasListeners(element) {
  return element.querySelector("button, input, select, textarea") !== null;
}

/**
 * A table; a caption says what it holds.  Rows are lists of cells, the first cell of each is its heading.  One with
 * actions becomes a card for each row on a phone, where they would be off the screen.
 * @param {string} caption @param {string[]} headings @param {(Child | Child[])[][]} rows @param {string} [empty]
 */
export function table(caption, headings, rows, empty = "Nothing here.") {
  if (rows.length === 0) return h("p", { class: "empty" }, `${caption}: ${empty}`);
  const stacks = headings.includes("Actions");
  return h(
    "div",
    { class: stacks ? "scroll stacks" : "scroll", tabindex: 0, role: "region", "aria-label": caption },
    h(
      "table",
      {},
      h("caption", {}, caption),
      h("thead", {}, h("tr", {}, headings.map((text) => h("th", { scope: "col" }, text)))),
      h(
        "tbody",
        {},
        rows.map((row) =>
          h("tr", {}, row.map((cell, k) => (k ? h("td", { "data-heading": stacks && headings[k] }, cell) : h("th", { scope: "row" }, cell)))),
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
  button.addEventListener("click", async (/** @type {MouseEvent} */ event) => {
    if (button.disabled || event.detail > 1) return; // the second click of two may hit what has come in its place
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
