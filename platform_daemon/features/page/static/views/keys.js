// The list of keys.
import { fill, h, table } from "../dom.js";

export const title = "Keys";

/** @param {HTMLElement} root */
export function show(root) {
  const links = [.../** @type {NodeListOf<HTMLAnchorElement>} */ (document.querySelectorAll("#nav a"))];
  /** @type {any[][]} */
  const rows = links.map((link) => [h("kbd", {}, link.getAttribute("aria-keyshortcuts") ?? ""), link.textContent]);
  fill(
    root,
    table("Keys", ["Key", "What it does"], [
      [[h("kbd", {}, "Esc"), " ", h("kbd", {}, "Esc")], "STOP: all outputs off, at once, from every view"],
      ...rows,
      [[h("kbd", {}, "←"), " ", h("kbd", {}, "→")], "In a picture: the cursor, point by point; with Shift by tens"],
      [[h("kbd", {}, "+"), " ", h("kbd", {}, "−"), " ", h("kbd", {}, "0")], "In a picture: zoom in at the cursor, out, and everything"],
    ]),
    h("p", {}, "The page reads only the keys above, and none while you type into a field."),
  );
}
