// STOP: all outputs off, by the port that does nothing else, and by the main port where that one cannot be reached.
import { address, withToken } from "./api.js";
import { say } from "./dom.js";
import { clockNow } from "./format.js";
import { onEvent, refresh } from "./live.js";

const ANSWER_MS = 20_000; // the daemon answers after 15 s at the latest
const SECOND_WAY_MS = 1500;
const WAKING_MS = 400; // the tap that wakes a phone
const TWICE_MS = 1000;

const { port, stopPort } = /** @type {Record<string, string>} */ (document.documentElement.dataset);
let shown_ms = -Infinity;
let escaped_ms = -Infinity;

/** The address of the stop port; null: below a proxy, or it is not known. */
function stopPortAddress() {
  const own = location.port || (location.protocol === "https:" ? "443" : "80");
  if (!stopPort || stopPort === "0" || own !== port) return null;
  return `${location.protocol}//${location.hostname}:${stopPort}/stop`;
}

/** @param {string} url */
async function stopBy(url) {
  const headers = withToken();
  const answer = await fetch(url, { method: "POST", headers, signal: AbortSignal.timeout(ANSWER_MS), keepalive: true });
  const body = await answer.json().catch(() => ({}));
  if (!answer.ok) throw new Error(body.detail ?? `status ${answer.status}`);
  return body;
}

/**
 * Stops by the stop port; after SECOND_WAY_MS, or if it fails, by the main port as well.  Resolves with the report that
 * comes first, or rejects with the reasons of both.
 */
export async function stopNow() {
  const first = stopPortAddress();
  if (first === null) return stopBy(address("stop"));
  const way = stopBy(first);
  const second = new Promise((resolve, reject) => {
    const timer = setTimeout(() => stopBy(address("stop")).then(resolve, reject), SECOND_WAY_MS);
    way.then(() => clearTimeout(timer), () => {
      clearTimeout(timer);
      stopBy(address("stop")).then(resolve, reject);
    });
  });
  second.catch(() => {});
  return Promise.any([way, second]).catch((all) => {
    throw new Error(all.errors.map((/** @type {Error} */ each) => each.message).join("; "));
  });
}

/** Makes the button and the keys work. */
export function installStop() {
  const button = /** @type {HTMLButtonElement} */ (document.getElementById("stop"));
  const message = /** @type {HTMLElement} */ (document.getElementById("stopped"));

  async function stop() {
    show("Stopping …", "");
    const began = performance.now();
    try {
      const report = await stopNow();
      const took = Math.round(performance.now() - began);
      show(`Outputs are off, proved at ${clockNow()} (${took} ms): ${report.status}`, "good");
    } catch (error) {
      show(`STOP is not confirmed: ${/** @type {Error} */ (error).message}. Use the emergency switch of the platform.`, "bad");
    }
    refresh();
  }

  /** @param {string} text @param {string} kind */
  function show(text, kind) {
    message.hidden = false;
    message.className = `stopped ${kind}`;
    message.textContent = text;
    say(text);
  }

  onEvent(({ what }) => {
    if (what.kind === "job" && what.state === "running" && message.classList.contains("good")) message.hidden = true;
  });
  document.addEventListener("visibilitychange", () => {
    if (!document.hidden) shown_ms = performance.now();
  });
  button.addEventListener("click", () => {
    if (performance.now() - shown_ms > WAKING_MS) stop();
  });
  addEventListener(
    "keydown",
    (event) => {
      if (event.key !== "Escape" || event.repeat) return;
      const now = performance.now();
      if (now - escaped_ms < TWICE_MS) stop();
      escaped_ms = now;
    },
    true,
  );
}
