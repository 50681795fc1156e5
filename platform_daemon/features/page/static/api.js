// Requests to the REST interface.  All paths are relative to the page, so that it works below a path of a proxy.

const BASE = new URL("../", document.baseURI);
const TOKEN = "platform-daemon-token";
const ANSWER_MS = 20_000;
const COMPUTED_MS = 180_000;

/** An error answer: problem details of RFC 9457, or no answer (status 0). */
export class Problem extends Error {
  /** @param {number} status @param {Record<string, any>} details */
  constructor(status, details) {
    super(details.detail ?? details.title ?? `status ${status}`);
    this.status = status;
    this.detail = this.message;
    /** @type {string} */
    this.where = details.where ?? "";
    /** @type {string} */
    this.remedy = details.remedy ?? "";
  }
}

/** What the browser keeps; where it refuses that (cookies blocked), it is kept until the page is left. @param {"localStorage" | "sessionStorage"} name */
function storage(name) {
  try {
    return window[name];
  } catch {
    const kept = new Map();
    return { getItem: (/** @type {string} */ key) => kept.get(key) ?? null, setItem: kept.set.bind(kept), removeItem: kept.delete.bind(kept) };
  }
}

const session = storage("sessionStorage");
const local = storage("localStorage");

/** The name of the person at this browser. */
export function myName() {
  return local.getItem("by") ?? "";
}

/** @param {string} name */
export function rememberName(name) {
  local.setItem("by", name);
}

let refusal = () => {};

/** Sets what is called when the daemon asks for a token, or does not accept it any more. @param {() => void} call */
export function onRefusedToken(call) {
  refusal = call;
}

/** The token of this tab, or "". */
export function token() {
  return session.getItem(TOKEN) ?? "";
}

/** @param {string} value */
export function setToken(value) {
  if (value) session.setItem(TOKEN, value);
  else session.removeItem(TOKEN);
}

/** Headers with the token, if there is one. @param {Record<string, string>} [others] @returns {Record<string, string>} */
export function withToken(others = {}) {
  return token() ? { ...others, Authorization: `Bearer ${token()}` } : others;
}

/** The address of a path of the REST interface. @param {string} path */
export function address(path) {
  return new URL(path.replace(/^\//, ""), BASE).href;
}

/**
 * The answer to a request, whatever its content.  Raises Problem.
 * @param {string} path @param {RequestInit} [options] @param {number} [limit_ms]
 */
export async function request(path, options = {}, limit_ms = ANSWER_MS) {
  const signal = AbortSignal.any([AbortSignal.timeout(limit_ms), ...(options.signal ? [options.signal] : [])]);
  let answer;
  try {
    const headers = withToken({ Accept: "application/json", .../** @type {any} */ (options.headers) });
    answer = await fetch(address(path), { cache: "no-store", ...options, signal, headers });
  } catch (error) {
    const why = /** @type {any} */ (error)?.name === "TimeoutError" ? `no answer for ${limit_ms / 1000} s` : "no connection";
    throw new Problem(0, { detail: `The daemon does not answer (${why}). Remedy: see that it runs, and this page's network.` });
  }
  if (answer.ok) return answer;
  if (answer.status === 401) refusal();
  let details = {};
  try {
    details = await answer.json();
  } catch {
    details = { detail: `The answer has status ${answer.status} and no explanation.` };
  }
  throw new Problem(answer.status, details);
}

/** JSON of a path.  Raises Problem. @param {string} path @param {{slow?: boolean, signal?: AbortSignal}} [how] @returns {Promise<any>} */
export async function get(path, { slow = false, signal } = {}) {
  return jsonOf(await request(path, signal ? { signal } : {}, slow ? COMPUTED_MS : ANSWER_MS));
}

/** @param {Response} answer @returns {Promise<any>} */
export async function jsonOf(answer) {
  try {
    return await answer.json();
  } catch (error) {
    if (!(error instanceof SyntaxError)) throw error;
    throw new Problem(0, { detail: "Something else than the daemon answers at its address (no JSON). Remedy: sign in to this network or proxy, then reload the page." });
  }
}

/**
 * Sends JSON, and returns what is answered.  Raises Problem.  It is never repeated by itself.
 * @param {"POST" | "PUT" | "DELETE"} method @param {string} path @param {any} [body] @param {Record<string, string>} [more] headers
 * @returns {Promise<any>}
 */
export async function send(method, path, body = {}, more = {}) {
  const options = method === "DELETE" ? { method } : { method, body: JSON.stringify(body) };
  const headers = { "Content-Type": "application/json", ...more };
  const answer = await request(path, { ...options, headers }, COMPUTED_MS);
  const text = await answer.text();
  return text ? JSON.parse(text) : null;
}

/** A file of the page as JSON. @param {string} name @returns {Promise<any>} */
export async function getPageFile(name) {
  return jsonOf(await request(new URL(name, document.baseURI).href, { cache: "default" }));
}

/** Downloads a path as a file, with the token that a link could not send. @param {string} path @param {string} name @param {string} [type] */
export async function download(path, name, type = "*/*") {
  const blob = await (await request(path, { headers: { Accept: type } }, COMPUTED_MS)).blob();
  const link = document.createElement("a");
  link.href = URL.createObjectURL(blob);
  link.download = name;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 60_000);
}

/** The entries of all pages of a list, up to a number of them. @param {string} path @param {number} most @returns {Promise<any[]>} */
export async function getList(path, most = 1000) {
  /** @type {any[]} */
  const found = [];
  for (let next = path; next && found.length < most; ) {
    const page = await get(next);
    found.push(...page.items);
    next = page.next;
  }
  return found;
}
