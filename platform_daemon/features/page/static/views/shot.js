// Last shot: three channels with the fit, the residual in standard deviations, the spectrum, the parameters.
import { get, request } from "../api.js";
import { errorBox, facts, fill, h, oneAtATime, table } from "../dom.js";
import { definitionOf, duration, parameter, plain, readingInWords, significant } from "../format.js";
import { COLOURS, Plot } from "../plot.js";

export const title = "Last shot";
const POINTS = 600;
const SAMPLES = 2000; // of a stretch that is short enough to show each
const SHORT_S = 0.03;
const CHI2_ODD = 1.2; // as a rule of thumb: what is above is pointed out, the verdict is the daemon's

/** @param {HTMLElement} root @param {string[]} parts */
export async function show(root, parts) {
  const [recording, frame] = parts;
  const place = { recording: recording ?? "", frame: Number(frame ?? NaN) };
  const follows = !recording;
  const heading = h("p", { class: "large" });
  const walk = h("p", { class: "buttons" });
  const why = h("div");
  const zoomed = h("p", { class: "buttons" });
  const signal = h("div");
  const residual = h("div");
  const spectrum = h("div");
  const numbers = h("div", { class: "card" });
  root.replaceChildren(heading, walk, why, zoomed, h("div", { class: "plots" }, signal, numbers, residual, spectrum));
  const plots = [new Plot(signal), new Plot(residual), new Plot(spectrum)];
  let [from, to] = [0, Infinity];
  const left = new AbortController(); // what is still asked for keeps the elements of the view, and the daemon busy

  /** One shot at a time: where shots come faster than they can be drawn, some are passed over. */
  const load = oneAtATime(loadShot);

  async function loadShot() {
    if (!place.recording) {
      fill(heading, "No shot yet");
      fill(why, h("p", {}, "A shot appears here as soon as one is on disk. ", h("a", { href: "#/start" }, "Start a series")));
      return;
    }
    /** @type {any} */
    let reads = null;
    const base = `recordings/${encodeURIComponent(place.recording)}/frames/${place.frame}`;
    fill(heading, `Frame ${place.frame}`);
    fill(walk, h("a", { href: `#/series/${place.recording}` }, place.recording), neighbours(place, follows));
    const stretch = `start_s=${from}${Number.isFinite(to) ? `&stop_s=${to}` : ""}`;
    const points = to - from <= SHORT_S ? SAMPLES : POINTS;
    fill(zoomed, h("span", {}, Number.isFinite(to) || from > 0 ? `From ${significant(from, 4)} s to ${significant(to, 4)} s ` : "Drag in the picture of the signal to zoom: finer data are loaded. "), zoomButtons());
    try {
      reads = await showOnlineFit(place, numbers, why, left.signal);
      drawExtremes(plots[0], await request(`${base}/dmdt.f32?points=${points}&${stretch}`, { headers: { Accept: "*/*" }, signal: left.signal }), zoom);
      const found = await get(`${base}/plot?points=${points}&${stretch}`, { slow: true, signal: left.signal });
      drawFit(plots, found, zoom);
      drawNumbers(numbers, found.fit, reads);
      if (why.querySelector(".hint")) fill(why, found.fit.verdict === "good" ? null : h("p", { class: "error" }, `No fit: ${found.fit.reason}`));
    } catch (error) {
      if (left.signal.aborted) return;
      fill(why, errorBox(error), gone(error));
    }
  }

  /** @param {number} start @param {number} stop */
  function zoom(start, stop) {
    [from, to] = [Math.max(0, start), stop];
    load();
  }

  function zoomButtons() {
    /** @type {[string, number, number][]} */
    const stretches = [["First 25 ms", 0, 0.025], ["First 0.24 s", 0, 0.24], ["Everything", 0, Infinity]];
    return stretches.map(([text, start, stop]) => h("button", { type: "button", "data-key": text, onclick: () => zoom(start, stop) }, text));
  }

  if (follows) Object.assign(place, await newestShot());
  load();
  return {
    load,
    concerns(/** @type {any} */ what) {
      if (!follows || what.kind !== "shot") return false;
      Object.assign(place, { recording: what.recording, frame: what.frame });
      return true;
    },
    close: () => {
      left.abort();
      plots.forEach((plot) => plot.close());
    },
  };
}

/** @param {any} error */
function gone(error) {
  return error.status === 404 ? h("p", {}, "It may have been deleted. ", h("a", { href: "#/recordings" }, "See what is there")) : null;
}

/** Links to the shots before and after; after the newest there is none. @param {{recording: string, frame: number}} place @param {boolean} newest */
function neighbours({ recording, frame }, newest) {
  return [
    frame > 0 && h("a", { href: `#/shot/${recording}/${frame - 1}` }, "← earlier"),
    !newest && h("a", { href: `#/shot/${recording}/${frame + 1}` }, "later →"),
  ];
}

/** The fit that was made when the shot came, which is there at once; with what a sensor reads. @param {{recording: string, frame: number}} place @param {HTMLElement} numbers @param {HTMLElement} why @param {AbortSignal} signal */
async function showOnlineFit({ recording, frame }, numbers, why, signal) {
  fill(why, h("p", { class: "hint" }, "Loading …"));
  if (!recording.startsWith("acquisition-")) return null;
  const page = await get(`acquisitions/${recording}/shots?after=${frame}&limit=1`, { signal }).catch(() => null);
  const shot = page?.items.find((/** @type {any} */ each) => each.frame === frame);
  if (!shot) return null;
  if (shot.fit) drawNumbers(numbers, shot.fit, shot.measurand);
  if (shot.verdict !== "good") fill(why, h("p", { class: "error" }, `This shot was refused: ${shot.reason}`));
  return shot.measurand;
}

/** The newest shot that is on disk. @returns {Promise<{recording: string, frame: number}>} */
async function newestShot() {
  const { items: jobs } = await get("jobs?kind=acquisition&kind=procedure&limit=10");
  const newest = jobs.find((/** @type {any} */ each) => each.recording);
  if (!newest) return { recording: "", frame: NaN };
  try {
    const shots = Math.floor(newest.progress.done);
    if (newest.kind === "acquisition" && shots) {
      const page = await get(`acquisitions/${newest.id}/shots?after=${shots - 1}&limit=1000`);
      if (page.items.length) return { recording: newest.recording, frame: page.items.at(-1).frame };
    }
    const { frames } = await get(`recordings/${encodeURIComponent(newest.recording)}?limit=0`);
    return { recording: newest.recording, frame: frames - 1 };
  } catch (error) {
    if (/** @type {any} */ (error).status === 404) return { recording: "", frame: NaN };
    throw error;
  }
}

/** @param {Plot} plot @param {Response} answer @param {(from: number, to: number) => void} zoom */
async function drawExtremes(plot, answer, zoom) {
  const pairs = new Float32Array(await answer.arrayBuffer());
  const header = (/** @type {string} */ name) => answer.headers.get(name) ?? "";
  const channels = header("Channels").split(",");
  const points = pairs.length / 2 / channels.length;
  const [start, step] = [Number(header("Start-S")), Number(header("Step-S"))];
  const x = Array.from({ length: points }, (_, k) => start + k * step);
  const lines = channels.map((label, c) => {
    const low = Array.from({ length: points }, (_, k) => pairs[2 * (c * points + k)]);
    const high = Array.from({ length: points }, (_, k) => pairs[2 * (c * points + k) + 1]);
    return { label, values: high, low, high };
  });
  plot.draw({ title: "Signal", xLabel: "t / s", yLabel: label(header("Unit")), x, lines, onZoom: zoom });
}

/** @param {string} unit */
function label(unit) {
  return unit === "V" ? "input / V" : "dm/dt / A m² s⁻¹";
}

/** @param {Plot[]} plots @param {any} found @param {(from: number, to: number) => void} zoom */
function drawFit([signal, residual, spectrum], found, zoom) {
  const channels = /** @type {string[]} */ (found.channels);
  if (found.model.length)
    signal.draw({
      title: "Samples and fit", xLabel: "t / s", yLabel: label(found.unit), x: found.t_s, onZoom: zoom,
      lines: [
        ...channels.map((name, c) => ({ label: name, values: found.maximum[c], points: true, colour: COLOURS[c] })),
        ...channels.map((name, c) => ({ label: `fit ${name}`, values: found.model[c], colour: COLOURS[c], plainLine: true })),
      ],
    });
  if (found.residual_maximum.length)
    residual.draw({
      title: "Residual", xLabel: "t / s", yLabel: "residual / σ", x: found.t_s, limits: [-5, 5], onZoom: zoom,
      lines: channels.map((name, c) => ({ label: name, values: found.residual_maximum[c], low: found.residual_minimum[c], high: found.residual_maximum[c] })),
    });
  spectrum.draw({
    title: "Spectrum", xLabel: "f / Hz", yLabel: label(found.unit), x: found.frequency_hz, log: true,
    lines: [
      ...channels.map((name, c) => ({ label: name, values: found.spectrum[c] })),
      ...channels.map((name, c) => ({ label: `residual ${name}`, values: found.residual_spectrum[c] ?? [], colour: `${COLOURS[c]}88`, plainLine: true })).filter((each) => each.values.length),
    ],
  });
}

/** @param {HTMLElement} place @param {any} fit @param {any} reads what a sensor reads, if it is one */
function drawNumbers(place, fit, reads) {
  const rows = Object.entries(fit.parameters).map(([name, estimate]) => {
    const { symbol, display_unit: unit, description } = definitionOf(name);
    return [h("abbr", { title: description }, symbol), parameter(name, /** @type {any} */ (estimate)), unit || "1"];
  });
  const chi2 = fit.chi2_per_dof;
  fill(
    place,
    reads && h("p", { class: "large" }, readingInWords(reads)),
    h("h2", {}, "Parameters"),
    table("Standard deviation in brackets, at the last digits", ["Parameter", "Value", "Unit"], rows, `none: ${fit.reason ?? "no fit"}`),
    facts([
      ["χ² per degree of freedom", chi2 === null ? null : h("span", { class: chi2 > CHI2_ODD ? "warn" : "" }, `${chi2.toFixed(3)}${chi2 > CHI2_ODD ? ", more than noise is left over" : ""}`)],
      ["By channel", fit.chi2_per_dof_by_channel?.map((/** @type {number} */ each) => each.toFixed(3)).join(", ")],
      ["Whiteness of the residual", fit.whiteness_by_channel?.map((/** @type {number} */ each) => each.toFixed(2)).join(", ")],
      ["Window", duration(fit.window_s)],
      ["Warnings", fit.warnings.map(plain).join("; ")],
      ["Notes", fit.notes.join("; ")],
    ]),
  );
}
