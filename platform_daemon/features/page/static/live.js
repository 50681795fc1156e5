// What happens, as it happens: one event stream for all tabs of a browser, and every one to three seconds the state.
//
// The tab that holds the lock "platform-daemon-leader" reads, and tells the other tabs by a BroadcastChannel.  A tab that
// is hidden gives the lock away: browsers slow its timers down to once a minute.  Web locks exist only on localhost and
// with TLS; without them each tab that is shown reads for itself.
import { address, get, jsonOf, request, withToken } from "./api.js";

const POLL_MS = 1250; // after what was heard last, so that a daemon that is halted is seen; events of a shot a second come before
const LATEST_POLL_MS = 2900; // after the last poll, however many events come: what has no event is no older
const POLL_LIMIT_MS = 2500;
export const OLD_MS = 2500; // with a tick, seen in less than three seconds
const MOST_DRAWS = 4; // in any second, so that an event seldom waits and a burst of events costs little
const TICK_MS = 450; // how often is looked whether what is shown has become old
const AGES_MS = 1300; // ages change though nothing happens; events of a shot a second draw in their place
const KEPT_EVENTS = 200;
const REPLAYED_MS = 600_000; // after a longer gap the views read everything again, and the events between are left out

/** @typedef {{id: number, at: string | null, what: any}} PlatformEvent */

export const live = {
  /** @type {any} */ platform: null,
  /** @type {any} */ job: null,
  /** @type {any} */ outer: null, // the job, as lists have it, that the one that runs is a step of
  /** @type {any[]} */ alarms: [],
  /** @type {PlatformEvent[]} */ events: [],
  /** @type {string} */ problem: "",
  clock_off_s: NaN, // by how much the clock of this device is ahead of the daemon's
  heard_ms: -Infinity, // when the daemon was heard of last, by performance.now
  event_ms: -Infinity, // when the last event came
};

/** @type {Set<() => void>} */
const listeners = new Set();
/** @type {Set<(event: PlatformEvent) => void>} */
const eventListeners = new Set();
const channel = "BroadcastChannel" in window ? new BroadcastChannel("platform-daemon") : null;
let leads = false;
/** @type {AbortController | null} what ends the wait for the lead, or the lead */
let lead = null;
let lastId = "";
let listened_ms = 0; // by Date.now, which goes on while a phone sleeps
/** @type {AbortController | null} */
let stream = null;
let drawing = 0;
/** @type {number[]} */
let drawn_ms = [];
let drawnOld = true;
let pollTimer = 0;
let polled_ms = 0; // when the last poll ended
let polls = 0; // that are not answered yet

/** Calls a function whenever something is new, at most four times a second; returns a function that ends that. @param {() => void} call */
export function onChange(call) {
  listeners.add(call);
  return () => listeners.delete(call);
}

/** Calls a function for each event. @param {(event: PlatformEvent) => void} call */
export function onEvent(call) {
  eventListeners.add(call);
  return () => eventListeners.delete(call);
}

/** Has the daemon not been heard of for too long? */
export function isOld() {
  return performance.now() - live.heard_ms > OLD_MS;
}

/** Begins to follow the daemon. */
export function follow() {
  channel?.addEventListener("message", ({ data }) => hear(data));
  document.addEventListener("visibilitychange", () => (document.hidden ? lead?.abort() : wake()));
  addEventListener("online", wake);
  setInterval(() => {
    if (isOld() !== drawnOld || performance.now() - (drawn_ms.at(-1) ?? -Infinity) >= AGES_MS) draw();
  }, TICK_MS);
  wake();
}

/** Reads everything again at once, as after a change by this page. */
export function refresh() {
  if (leads) poll();
  else channel?.postMessage({ refresh: true });
}

/** Asks for the lead, or, where this tab has it, begins the stream again if it has ended without a word. */
function wake() {
  if (document.hidden) return;
  if (!lead) seekLead();
  else if (!leads) refresh();
  else {
    if (isOld()) stream?.abort();
    poll();
  }
  draw();
}

async function seekLead() {
  const mine = (lead = new AbortController());
  try {
    if (navigator.locks) await navigator.locks.request("platform-daemon-leader", { signal: mine.signal }, () => readWhileShown(mine.signal));
    else await readWhileShown(mine.signal);
  } catch {
    // hidden before the lead was given
  }
  lead = null;
  if (!document.hidden) seekLead();
}

/** @param {AbortSignal} signal */
async function readWhileShown(signal) {
  leads = true;
  poll();
  await readEvents(signal);
  leads = false;
  clearTimeout(pollTimer);
}

async function poll() {
  polls += 1;
  clearTimeout(pollTimer);
  try {
    const signal = AbortSignal.timeout(POLL_LIMIT_MS);
    const answer = await request("platform", { signal });
    const platform = await jsonOf(answer);
    const clock_off_s = (Date.now() - Date.parse(answer.headers.get("Date") ?? "")) / 1000;
    const running = platform.running ? await get(pathOfJob(platform.running), { signal }) : null;
    const job = running && shorten(running);
    const outer = job && (await outerOf(job.id, signal).catch(() => null)); // else the step is shown alone
    tell({ state: { platform, job, outer, clock_off_s, problem: "" } });
  } catch (error) {
    const status = /** @type {any} */ (error).status;
    tell({ state: { problem: /** @type {Error} */ (error).message }, silent: !status });
  }
  polled_ms = performance.now();
  polls -= 1;
  planPoll();
}

/** The next poll: events say that the daemon lives, too, so that it waits while they come, though not for long. */
function planPoll() {
  clearTimeout(pollTimer);
  if (leads && !polls) pollTimer = window.setTimeout(poll, Math.min(POLL_MS, polled_ms + LATEST_POLL_MS - performance.now()));
}

/** @type {{id: string, within: string | null}} */
let step = { id: "", within: null }; // which job is a step of another one does not change

/** The job that this one is a step of, or null. @param {string} id @param {AbortSignal} signal */
async function outerOf(id, signal) {
  if (id === step.id && !step.within) return null;
  const { items } = await get("jobs?state=running&limit=50", { signal });
  const found = (/** @type {string | null} */ each) => items.find((/** @type {any} */ job) => job.id === each) ?? null;
  if (id !== step.id && found(id)) step = { id, within: found(id).within };
  return id === step.id ? found(step.within) : null;
}

/** Only what is shown of a job that runs. @param {any} job */
function shorten(job) {
  const { result, ...rest } = job;
  return { ...rest, recording: result?.recording ?? null, shots: result?.shots ?? null };
}

/** The path of a job by its id, whose first part is its kind. @param {string} id */
export function pathOfJob(id) {
  const kind = id.replace(/-\d{8}T\d{6}-.*$/, "").replaceAll("_", "-");
  const plurals = /** @type {Record<string, string>} */ ({ diagnosis: "diagnoses" });
  return `${plurals[kind] ?? `${kind}s`}/${id}`;
}

/** @param {AbortSignal} [signal] */
async function loadAlarms(signal) {
  try {
    tell({ state: { alarms: (await get("alarms?limit=200", { signal })).items } });
  } catch {
    // the poll says what is wrong
  }
}

/** Follows the events until the signal.  What came while nobody listened is replayed. @param {AbortSignal} signal */
async function readEvents(signal) {
  for (let wait_ms = 200; !signal.aborted; wait_ms = Math.min(3000, 2 * wait_ms)) {
    stream = new AbortController();
    const either = AbortSignal.any([signal, stream.signal]);
    try {
      await loadAlarms(AbortSignal.any([either, AbortSignal.timeout(POLL_LIMIT_MS)]));
      if (lastId && Date.now() - listened_ms > REPLAYED_MS) {
        tell({ events: [{ id: lastId, at: null, what: { kind: "dropped", count: null } }] });
        lastId = "";
      }
      const headers = withToken({ Accept: "text/event-stream", ...(lastId ? { "Last-Event-ID": lastId } : {}) });
      const answer = await fetch(address("events"), { headers, signal: either, cache: "no-store" });
      if (!answer.ok || !answer.body) throw new Error(`status ${answer.status}`);
      wait_ms = 100;
      await readStream(answer.body);
    } catch {
      // the connection has ended; the poll says so, if the daemon is gone
    }
    stream = null;
    if (!signal.aborted) await pause(wait_ms, signal);
  }
}

/** @param {number} wait_ms @param {AbortSignal} signal that ends it early */
function pause(wait_ms, signal) {
  return new Promise((resolve) => {
    const end = () => {
      signal.removeEventListener("abort", end);
      resolve(null);
    };
    setTimeout(end, wait_ms);
    signal.addEventListener("abort", end);
  });
}

/** @param {ReadableStream<Uint8Array>} body */
async function readStream(body) {
  const reader = body.getReader();
  const decoder = new TextDecoder();
  let text = "";
  for (;;) {
    const { done, value } = await reader.read();
    if (done) return;
    listened_ms = Date.now();
    text += decoder.decode(value, { stream: true }).replaceAll("\r", "");
    const parts = text.split("\n\n");
    text = parts.pop() ?? "";
    const events = parts.map(dataOf).filter(Boolean).map((data) => JSON.parse(data));
    if (events.length) tell({ events });
  }
}

/** The data of one server-sent event. @param {string} part */
function dataOf(part) {
  return part.split("\n").filter((line) => line.startsWith("data:")).map((line) => line.slice(5)).join("\n");
}

/** Shows something here and in the other tabs. @param {any} news */
function tell(news) {
  hear(news);
  channel?.postMessage(news);
}

/** @param {any} news */
function hear(news) {
  if (news.refresh) {
    if (leads) poll();
    return;
  }
  const waited = isOld() || (news.state?.platform && news.state.platform.running !== live.platform?.running);
  if (!news.silent) live.heard_ms = performance.now();
  if (news.state) {
    Object.assign(live, news.state);
    countShots();
  }
  /** @type {PlatformEvent[]} */
  const events = news.events ?? [];
  if (events.length) {
    live.event_ms = performance.now();
    lastId = String(events[events.length - 1].id);
    listened_ms = Date.now();
    live.events = [...live.events, ...events].slice(-KEPT_EVENTS);
    countShots();
    for (const event of events) for (const call of eventListeners) call(event);
    const kinds = new Set(events.map((event) => event.what.kind));
    if (leads && kinds.has("alarm")) loadAlarms();
    if (leads && kinds.has("job")) poll();
    else planPoll();
  }
  if (events.length || waited) draw(); // what is polled is drawn with the next tick, so that an event need not wait for it
}

/** How far the shots of the job that runs are, by their events, which come before the next poll says so. */
function countShots() {
  const progress = live.job?.progress;
  if (progress?.unit !== "shots") return;
  const shot = live.events.findLast(({ what }) => what.kind === "shot" && what.job === live.job.id)?.what.shot ?? 0;
  if (shot > progress.done) live.job = { ...live.job, progress: { ...progress, done: shot, fraction: shot / progress.total } };
}

function draw() {
  if (drawing || document.hidden) return;
  const earliest_ms = drawn_ms.length < MOST_DRAWS ? -Infinity : drawn_ms[0] + 1000;
  const wait_ms = earliest_ms - performance.now();
  if (wait_ms <= 0) drawNow();
  else drawing = window.setTimeout(drawNow, wait_ms);
}

function drawNow() {
  drawing = 0;
  drawn_ms = [...drawn_ms, performance.now()].slice(-MOST_DRAWS);
  drawnOld = isOld();
  for (const call of listeners) call();
}
