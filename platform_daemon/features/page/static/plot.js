// Pictures: uPlot with a name, a table of the last values, a cursor that arrow keys move, and zoom.
import { fill, h, say, table } from "./dom.js";
import { significant, uncertain } from "./format.js";

const HEIGHT = 240;
const TABLE_ROWS = 20;
const CROSS_PX = 4;
const NEAR = "200px"; // what is nearer to the screen than this is drawn, so that scrolling seldom meets an old picture
/** Colours that the colour-blind can distinguish, on light and dark ground (Okabe and Ito), and by their dashes. */
export const COLOURS = matchMedia("(prefers-color-scheme: dark)").matches ? ["#56b4e9", "#e8833a", "#2cc29a", "#d894c0"] : ["#0072b2", "#d55e00", "#009e73", "#b0529b"];
const DASHES = [[], [6, 3], [2, 3], [8, 3, 2, 3]];

/** @typedef {{label: string, values: (number | null)[], low?: (number | null)[], high?: (number | null)[], points?: boolean, plainLine?: boolean, colour?: string}} Line */
/**
 * @typedef {{title: string, xLabel: string, yLabel: string, x: number[], lines: Line[], log?: boolean,
 *   limits?: number[], verticals?: number[], marks?: number[], onZoom?: (from: number, to: number) => void, onPick?: (index: number) => void,
 *   xText?: (x: number) => string, height?: number, whole?: boolean}} Picture
 * limits, verticals: dashed lines at these y and x; marks: crosses at these x, at the lower edge.
 */

/** @type {Promise<any> | null} */
let library = null;

/** uPlot, which is loaded when the first picture is drawn. */
function loadLibrary() {
  library ??= new Promise((resolve, reject) => {
    const style = h("link", { rel: "stylesheet", href: "vendor/uPlot.min.css" });
    const script = h("script", { src: "vendor/uPlot.iife.min.js" });
    script.onload = () => resolve(/** @type {any} */ (window).uPlot);
    script.onerror = () => reject(new Error("Pictures need uPlot, which is not installed. Remedy: run `make install`, then reload."));
    document.head.append(style, script);
  });
  return library;
}

/** A picture that can be drawn again with other data. */
export class Plot {
  /** @param {HTMLElement} place */
  constructor(place) {
    this.place = place;
    this.box = h("div", { class: "plot", tabindex: 0, role: "img", "aria-label": "Picture that is being loaded" });
    this.name = h("p", { class: "title", "aria-hidden": "true" });
    this.legend = h("p", { class: "legend", "aria-hidden": "true" });
    this.readout = h("p", { class: "readout", role: "status" });
    this.summary = h("summary", {}, "Table");
    this.values = h("div");
    this.behind = h("details", { ontoggle: () => this.fillTable() }, this.summary, this.values);
    place.replaceChildren(this.name, this.box, this.legend, this.readout, this.behind);
    /** @type {any} */ this.chart = null;
    /** @type {Picture | null} */ this.picture = null;
    this.shape = "";
    this.cursor = -1;
    this.closed = false;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(this.box);
    this.seen = true;
    /** @type {any} */ this.late = null; // numbers that came while the picture was not to be seen
    this.watcher = new IntersectionObserver((entries) => {
      this.seen = entries.at(-1)?.isIntersecting ?? true;
      if (this.seen) this.show(this.late);
    }, { rootMargin: NEAR });
    this.watcher.observe(this.box);
    this.box.addEventListener("keydown", (/** @type {KeyboardEvent} */ event) => this.key(event));
  }

  close() {
    this.observer.disconnect();
    this.watcher.disconnect();
    this.chart?.destroy();
    this.chart = null;
    this.closed = true;
  }

  /** Draws a picture.  Where only its numbers are new, the chart stays, and is drawn when it is seen. @param {Picture} picture */
  async draw(picture) {
    this.picture = picture;
    this.fillTable();
    let uPlot;
    try {
      uPlot = await loadLibrary();
    } catch (error) {
      this.name.textContent = picture.title;
      this.box.textContent = /** @type {Error} */ (error).message;
      return;
    }
    if (this.closed || this.picture !== picture) return;
    const { data, series, bands } = columns(picture);
    const shape = JSON.stringify([picture.title, picture.yLabel, picture.log, series.map((each) => each.label)]);
    if (this.chart && shape === this.shape) {
      this.late = data;
      if (this.seen) this.show(data);
      return;
    }
    this.shape = shape;
    this.late = null;
    this.name.textContent = picture.title;
    this.box.setAttribute("aria-label", `${picture.title}. ${picture.yLabel} over ${picture.xLabel}. Arrow keys move the cursor; a table follows.`);
    this.fillLegend(picture);
    this.chart?.destroy();
    this.box.replaceChildren();
    this.chart = new uPlot(this.options(picture, series, bands), data, this.box);
    this.resize();
  }

  /** Gives the chart new numbers. @param {any} data null: there are none */
  show(data) {
    this.late = null;
    if (data) this.chart?.setData(data);
  }

  /** @param {Picture} picture @param {any[]} series @param {any[]} bands */
  options(picture, series, bands) {
    const css = getComputedStyle(document.documentElement);
    const ink = css.getPropertyValue("--ink").trim();
    const grid = { stroke: css.getPropertyValue("--line").trim(), width: 1 };
    return {
      width: Math.max(200, this.box.clientWidth),
      height: picture.height ?? HEIGHT,
      series,
      bands,
      legend: { show: false },
      cursor: { drag: { x: true, y: false, setScale: !picture.onZoom }, points: { size: 5 } },
      scales: { x: { time: false }, y: picture.log ? { distr: 3 } : { range: (/** @type {any} */ _, /** @type {number} */ low, /** @type {number} */ high) => this.rangeOf(low, high) } },
      axes: [
        { stroke: ink, grid, ticks: grid, label: picture.xLabel, labelSize: 20, size: 34, ...(picture.whole ? { incrs: [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000, 2000, 5000] } : {}) },
        { stroke: ink, grid: picture.log ? { ...grid, filter: decades } : grid, ticks: grid, label: picture.yLabel, labelSize: 20, size: 76, values: axisValues(picture.log) },
      ],
      hooks: {
        setSelect: [(/** @type {any} */ u) => {
          const from = u.posToVal(u.select.left, "x");
          const to = u.posToVal(u.select.left + u.select.width, "x");
          if (u.select.width > 4) this.picture?.onZoom?.(from, to);
        }],
        draw: [(/** @type {any} */ u) => this.picture && drawBars(u, this.picture)],
        ready: [(/** @type {any} */ u) => u.over.addEventListener("click", () => {
          if (u.cursor.idx !== null) this.picture?.onPick?.(u.cursor.idx);
        })],
      },
    };
  }

  /** The range of y: the values, and the limits that they are held against. @param {number | null} low @param {number | null} high */
  rangeOf(low, high) {
    const all = [low, high, ...(this.picture?.limits ?? [])].filter((v) => typeof v === "number" && Number.isFinite(v)).map(Number);
    return all.length ? /** @type {any} */ (window).uPlot.rangeNum(Math.min(...all), Math.max(...all), 0.1, true) : [0, 1];
  }

  resize() {
    const width = this.box.clientWidth;
    if (this.chart && width > 0 && width !== this.chart.width) this.chart.setSize({ width, height: this.picture?.height ?? HEIGHT });
  }

  /** @param {KeyboardEvent} event */
  key(event) {
    const p = this.picture;
    if (!p || p.x.length === 0) return;
    const last = p.x.length - 1;
    const step = event.shiftKey ? 10 : 1;
    const to = { ArrowRight: this.cursor + step, ArrowLeft: this.cursor - step, Home: 0, End: last }[event.key];
    if (to !== undefined) {
      event.preventDefault();
      this.cursor = Math.min(last, Math.max(0, to));
      const values = p.lines.map((line) => `${line.label} ${significant(line.values[this.cursor])}`);
      this.readout.textContent = `${p.xText?.(p.x[this.cursor]) ?? significant(p.x[this.cursor])}: ${values.join(", ")}`;
      this.chart?.setCursor({ left: this.chart.valToPos(p.x[this.cursor], "x"), top: 10 });
    } else if (event.key === "Enter" && this.cursor >= 0) p.onPick?.(this.cursor);
    else if (p.onZoom && ["+", "-", "0"].includes(event.key)) {
      const middle = p.x[Math.max(0, this.cursor)];
      const half = (p.x[last] - p.x[0]) / (event.key === "+" ? 4 : 1);
      p.onZoom(event.key === "0" ? 0 : Math.max(0, middle - half), event.key === "0" ? Infinity : middle + half);
      say(event.key === "0" ? "Everything" : "Zoomed");
    }
  }

  /** Names of the lines, where there are several. @param {Picture} picture */
  fillLegend(picture) {
    const { lines } = picture;
    this.legend.replaceChildren(...(lines.length < 2 ? [] : lines.map((line, k) => {
      const swatch = document.createElementNS("http://www.w3.org/2000/svg", "svg");
      const bar = document.createElementNS("http://www.w3.org/2000/svg", "line");
      const dash = isDashed(line) ? DASHES[k % 4].join(" ") : "";
      for (const [name, value] of Object.entries({ x1: 0, x2: 24, y1: 6, y2: 6, stroke: line.colour ?? COLOURS[k % COLOURS.length], "stroke-width": 4, "stroke-dasharray": dash })) bar.setAttribute(name, String(value));
      swatch.append(bar);
      swatch.setAttribute("width", "24");
      swatch.setAttribute("height", "12");
      return h("span", {}, swatch, ` ${line.label}`);
    })));
  }

  /** The table behind the picture, which is made when it is opened. */
  fillTable() {
    const p = this.picture;
    if (!p) return;
    if (this.summary.textContent !== `Table: ${p.title}`) this.summary.textContent = `Table: ${p.title}`;
    if (!this.behind.open) return;
    const first = Math.max(0, p.x.length - TABLE_ROWS);
    const rows = p.x.slice(first).map((x, k) => [
      p.xText?.(x) ?? significant(x),
      ...p.lines.map((line) => cell(line, first + k)),
    ]);
    fill(this.values, table(`${p.title}, last ${rows.length} values`, [p.xLabel, ...p.lines.map((line) => line.label)], rows));
  }
}

/** What a table says of one point: the value with its bar in brackets, or the smallest and the largest of a stretch. @param {Line} line @param {number} k */
function cell({ values, low, high, points }, k) {
  const [value, top] = [values[k], high?.[k]];
  if (!low || value === null || typeof top !== "number") return significant(value, 8);
  return points ? uncertain(value, top - value) : `${significant(low[k], 4)} to ${significant(top, 4)}`;
}

/** @param {boolean | undefined} log */
function axisValues(log) {
  return (/** @type {any} */ _, /** @type {(number | null)[]} */ splits) =>
    splits.map((v) => (v === null ? "" : log || (v !== 0 && (Math.abs(v) < 1e-3 || Math.abs(v) >= 1e6)) ? v.toExponential(log ? 0 : 1) : significant(v, 9)));
}

/** Of the places of a logarithmic axis the powers of ten. @param {any} _ @param {(number | null)[]} splits */
function decades(_, splits) {
  return splits.map((v) => (v !== null && Number.isInteger(Math.log10(Number(v.toPrecision(6)))) ? v : null));
}

/** Is it distinguished by its dashes, too? @param {Line} line */
function isDashed(line) {
  return !line.plainLine && !line.points && !line.low;
}

/** Columns of numbers, and how each is drawn.  A band is two columns. @param {Picture} picture */
function columns(picture) {
  /** @type {any[]} */ const data = [picture.x];
  /** @type {any[]} */ const series = [{ label: picture.xLabel }];
  /** @type {any[]} */ const bands = [];
  picture.lines.forEach((line, k) => {
    const colour = line.colour ?? COLOURS[k % COLOURS.length];
    if (line.low && line.high && !line.points) {
      data.push(line.high, line.low);
      const one = { stroke: colour, width: 1, points: { show: false } };
      series.push({ ...one, label: line.label }, { ...one, label: `${line.label} ` });
      bands.push({ series: [data.length - 2, data.length - 1], fill: `${colour}66` });
      return;
    }
    data.push(line.values);
    const points = { show: Boolean(line.points), size: 6, fill: colour, stroke: colour };
    series.push({ label: line.label, stroke: colour, width: line.points ? 0.5 : 1.4, dash: isDashed(line) ? DASHES[k % 4] : [], points });
  });
  return { data, series, bands };
}

/** Error bars of points, limits, and crosses at the lower edge. @param {any} u @param {Picture} picture */
function drawBars(u, picture) {
  const { ctx } = u;
  ctx.save();
  ctx.beginPath();
  ctx.rect(u.bbox.left, u.bbox.top, u.bbox.width, u.bbox.height);
  ctx.clip();
  picture.lines.forEach((line, k) => {
    if (!line.points || !line.low || !line.high) return;
    ctx.strokeStyle = line.colour ?? COLOURS[k % COLOURS.length];
    ctx.beginPath();
    picture.x.forEach((x, i) => {
      const low = line.low?.[i];
      const high = line.high?.[i];
      if (low === null || low === undefined || high === null || high === undefined) return;
      const at = u.valToPos(x, "x", true);
      ctx.moveTo(at, u.valToPos(low, "y", true));
      ctx.lineTo(at, u.valToPos(high, "y", true));
    });
    ctx.stroke();
  });
  const css = getComputedStyle(document.documentElement);
  const { left, top, width, height } = u.bbox;
  /** @param {number} x0 @param {number} y0 @param {number} x1 @param {number} y1 */
  const line = (x0, y0, x1, y1) => {
    ctx.beginPath();
    ctx.moveTo(x0, y0);
    ctx.lineTo(x1, y1);
    ctx.stroke();
  };
  ctx.strokeStyle = css.getPropertyValue("--bad").trim();
  const half = CROSS_PX * devicePixelRatio;
  for (const mark of picture.marks ?? []) {
    const [x, y] = [u.valToPos(mark, "x", true), top + height - 2 * half];
    line(x - half, y - half, x + half, y + half);
    line(x - half, y + half, x + half, y - half);
  }
  ctx.strokeStyle = css.getPropertyValue("--warn").trim();
  ctx.setLineDash([6, 4]);
  for (const limit of picture.limits ?? []) {
    const y = u.valToPos(limit, "y", true);
    line(left, y, left + width, y);
  }
  for (const vertical of picture.verticals ?? []) {
    const x = u.valToPos(vertical, "x", true);
    line(x, top, x, top + height);
  }
  ctx.restore();
}
