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
    if (name.startsWith("on")) /** @type {any} */ (element)[name] = value;
    else if (name === "value" && tag !== "input") /** @type {any} */ (element).value = value;
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

/** Buttons whose action runs. @type {WeakSet<Element>} */
const busy = new WeakSet();

const CONTROLS = ["BUTTON", "INPUT", "SELECT", "TEXTAREA"];
/** @type {("onclick" | "onchange" | "oninput" | "onsubmit" | "ontoggle")[]} */
const LISTENERS = ["onclick", "onchange", "oninput", "onsubmit", "ontoggle"];

/** What is to stand in elements that are pressed just now, each with its content. @type {Map<Element, Element>} */
const held = new Map();
/** @type {Element | null} */ let pressed = null;

const LONGEST_PRESS_MS = 5000;
/** @type {number} */ let given_up;

/** Only what a press and a release make a click of; a scroll bar or a menu may never tell of the release. @param {Event} event */
function press(event) {
  if (event instanceof KeyboardEvent ? event.key !== " " : event instanceof PointerEvent && event.button !== 0) return;
  pressed = event.target instanceof Element ? event.target.closest("button, a, summary, input, label") : null;
  clearTimeout(given_up);
  if (pressed) given_up = window.setTimeout(release, LONGEST_PRESS_MS);
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
 * Gives an element other content.  What can be the same stays: what is typed, the focus, what is opened, scrolled to or
 * selected, and what need not be drawn anew.  A control stays where its "data-key" is the same, and follows its row; what
 * is in an element with "data-own" belongs to whoever wrote it.  While something in it is pressed all stays as it is,
 * since what is replaced or moves between the press and the release gets no click.
 * @param {Element} element @param {...(Child | Child[])} children
 */
export function fill(element, ...children) {
  const made = document.createElement("div");
  append(made, children);
  if (pressed && element.contains(pressed)) held.set(element, made);
  else {
    held.delete(element);
    replace(element, made);
  }
}

/** Replaces the children of an element; what has the focus keeps it where it stays. @param {Element} element @param {Element} made */
function replace(element, made) {
  const focused = /** @type {HTMLElement | null} */ (document.activeElement);
  become(element, made);
  if (focused?.isConnected && focused !== document.activeElement && element.contains(focused)) focused.focus({ preventScroll: true });
}

/** Makes the children of an element those of another one, which is used up. @param {Element} element @param {Element} other */
function become(element, other) {
  const after = [...other.childNodes];
  const keys = new Set(after.map(keyIn));
  for (const old of [...element.childNodes]) if (!keys.has(keyIn(old))) old.remove();
  /** @type {ChildNode | null} */ let place = element.firstChild; // of the next one
  for (const node of after) {
    let old = place;
    while (old && !mayStay(old, node)) old = old.nextSibling;
    if (!old) element.insertBefore(node, place);
    else {
      if (old === place) place = old.nextSibling;
      else element.insertBefore(old, place);
      if (!(old instanceof Element && node instanceof Element)) old.nodeValue !== node.nodeValue && (old.nodeValue = node.nodeValue);
      else if (!old.hasAttribute("data-own")) {
        copyAttributes(old, node);
        become(old, node);
      }
    }
  }
  while (place) {
    const next = place.nextSibling;
    place.remove();
    place = next;
  }
}

/** May a node stay where this one is to be? @param {Node} old @param {Node} node */
function mayStay(old, node) {
  if (old.nodeName !== node.nodeName) return false;
  return keyIn(old) === keyIn(node) && (keyIn(node) !== null || !CONTROLS.includes(node.nodeName));
}

/** The key of a node among its siblings. @param {Node} node */
function keyIn(node) {
  return node instanceof Element ? node.getAttribute("data-key") : null;
}

/** Attributes and listeners of an element to one that stays; a detail stays open, and what is being typed stays. @param {any} old @param {any} node */
function copyAttributes(old, node) {
  const other = old.getAttribute("value") !== node.getAttribute("value");
  // A value that is not taken over now is told apart once more after the focus has gone; a button that is busy stays off.
  const kept = [...(document.activeElement === old ? ["value"] : []), ...(busy.has(old) ? ["disabled"] : [])];
  for (const name of old.getAttributeNames()) if (!node.hasAttribute(name) && ![...kept, "open"].includes(name)) old.removeAttribute(name);
  for (const name of node.getAttributeNames()) {
    if (old.getAttribute(name) !== node.getAttribute(name) && !kept.includes(name)) old.setAttribute(name, node.getAttribute(name));
  }
  if (![...CONTROLS, "DETAILS", "FORM"].includes(node.nodeName)) return;
  for (const name of LISTENERS) old[name] = node[name];
  if (node.type === "checkbox") old.checked = node.checked;
  else if (other && node.nodeName === "INPUT" && document.activeElement !== old) old.value = node.value;
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
          h("tr", { "data-key": keyOf(row[0]) }, row.map((cell, k) => (k ? h("td", { "data-heading": stacks && headings[k] }, cell) : h("th", { scope: "row" }, cell)))),
        ),
      ),
    ),
  );
}

/** What tells a row from others: where its heading leads to. @param {any} heading */
function keyOf(heading) {
  return heading instanceof HTMLAnchorElement ? heading.getAttribute("href") : null;
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
  const onclick = async (/** @type {MouseEvent} */ event) => {
    const button = /** @type {HTMLButtonElement} */ (event.currentTarget);
    if (busy.has(button) || event.detail > 1) return; // the second click of two may hit what has come in its place
    const message = /** @type {HTMLElement} */ (button.nextElementSibling);
    busy.add(button);
    button.disabled = true;
    message.textContent = "";
    try {
      await action();
    } catch (error) {
      message.textContent = errorText(error);
    } finally {
      busy.delete(button);
      button.disabled = Boolean(attributes.disabled);
    }
  };
  const key = attributes["data-key"] ?? text;
  return h("span", { class: "action", "data-key": key }, h("button", { type: "button", onclick, ...attributes, "data-key": key }, text), h("span", { class: "inline-error", role: "alert", "data-own": true }));
}
