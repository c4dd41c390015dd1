// Line plots over a job's curves (uPlot) and plots of one quantity over another (canvas).
import uPlot from './vendor/uplot.min.js';
import { colour, number } from './dom.js';
import { saveButtons } from './save.js';

/** Colours of Okabe and Ito (2008), which readers with deficient colour vision distinguish. */
export const INKS = () => (document.documentElement.dataset.theme === 'dark'
  ? ['#56b4e9', '#e69f00', '#2fbf94', '#f2773a', '#cc79a7', '#f0e442']
  : ['#0072b2', '#d08b00', '#009e73', '#d55e00', '#b05f8c', '#8a7f00']);

const font = () => `${Math.round(parseFloat(getComputedStyle(document.documentElement).fontSize) * 0.9)}px system-ui, "Segoe UI", "DejaVu Sans", sans-serif`;
const rem = () => parseFloat(getComputedStyle(document.documentElement).fontSize);

/** Lines are as thick as the letters are large: the page of a 4K screen has larger ones. */
const thickness = () => rem() / 13;

const decimals = (step) => { let d = 0; while (d < 8 && Math.abs(step * 10 ** d - Math.round(step * 10 ** d)) > 1e-6 * step * 10 ** d) d++; return d; };

/** Dashes tell the lines apart where they cover each other, and for readers without colours. */
export const DASHES = [undefined, [9, 6], [3, 4], [12, 4, 3, 4]];

/** Whether a curve goes up and down so often that dashes would be endless work, and say nothing. */
export function isDense(values) {
  let [travelled, low, high] = [0, Infinity, -Infinity];
  for (let k = 0; k < values.length; k++) {
    const v = values[k];
    if (v === null || Number.isNaN(v)) continue;
    if (k > 0 && values[k - 1] !== null && !Number.isNaN(values[k - 1])) travelled += Math.abs(v - values[k - 1]);
    if (v < low) low = v;
    if (v > high) high = v;
  }
  return travelled > 30 * (high - low);
}

/** What readers of the screen say of a plot. */
function describe(canvas, text) {
  canvas.setAttribute('role', 'img');
  canvas.setAttribute('aria-label', `plot of ${text}`);
}

/** A label where there is room for it; where it is too long, its unit; nothing where that is. */
function fitting(label, room) {
  const pen = document.createElement('canvas').getContext('2d');
  pen.font = font();
  return [label, label.match(/\([^()]*\)$/)?.[0] ?? ''].find((text) => pen.measureText(text).width < room) ?? '';
}

const LINE = uPlot.paths.linear();
const NO_PATH = () => ({ stroke: new Path2D(), fill: null, clip: null, band: null, gaps: null, flags: 1 });

/** A tick with the decimals that it needs beside its neighbours. */
const tick = (value, step) => (value === 0 ? '0' : Math.abs(value) >= 1e5 || step < 1e-5 ? number(value, 3) : value.toFixed(decimals(step)).replace('-', '−'));

function axis(label, size, factor = 1, upright = false) {
  return {
    ...(label ? { label, labelSize: rem() * 1.5 } : {}), size, stroke: () => colour('dim'), font: font(), labelFont: font(), gap: 4,
    grid: { stroke: () => colour('grid'), width: 1 }, space: rem() * (upright ? 1.9 : 4), ticks: { stroke: () => colour('grid'), width: 1, size: 4 },
    values: (_, splits) => splits.map((v) => (v === null ? '' : tick(v * factor, Math.abs(splits[1] - splits[0]) * factor))),
  };
}

/**
 * A line plot that fills its place. Several with the same `sync` share cursor and zoom.
 * @param {HTMLElement} place
 * @param {{x: string, y: string, abscissa?: string, series: {label: string, ink: string, width?: number, dash?: number[]}[], band?: number,
 *   xFactor?: number, yFactor?: number, sync?: string, yRange?: (low: number, high: number) => [number, number],
 *   onzoom?: (range: [number, number]|null) => void, oncursor?: (index: number|null, plot: uPlot) => void}} options
 */
export class LinePlot {
  constructor(place, options) {
    this.place = place;
    this.options = options;
    this.data = [[], ...options.series.map(() => [])];
    this.dense = options.series.map(() => false);
    this.build();
    place.append(saveButtons(() => this.drawn));
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(place);
    this.repaint = () => { this.build(); };
    addEventListener('themechange', this.repaint);
  }

  build() {
    const { x, y, series, band, xFactor = 1, yFactor = 1, sync, yRange, onzoom, oncursor } = this.options;
    this.plot?.destroy();
    this.letters = rem();
    const { width, height } = this.size();
    this.labelled = this.fittingLabel;
    this.plot = new uPlot({
      width, height, legend: { show: false }, pxAlign: 0,
      padding: [rem() * 0.6, rem() * 0.9, 0, 0],
      scales: { x: { time: false }, y: { range: (_, low, high) => (yRange ? yRange(low, high) : padded(low, high)) } },
      axes: [axis(x, rem() * 1.9, xFactor), axis(this.labelled, rem() * (this.labelled ? 4.2 : 5.7), yFactor, true)],
      series: [{}, ...series.map((s) => ({
        label: s.label, stroke: () => (s.ink.startsWith('#') ? s.ink : colour(s.ink)), width: (s.width ?? 1.3) * thickness(), dash: s.dash, points: { show: false }, spanGaps: false, show: s.show ?? true,
        paths: (u, i, first, last) => (this.dense[i - 1] ? NO_PATH() : LINE(u, i, first, last)),
      }))],
      cursor: { sync: sync ? { key: sync, setSeries: false } : undefined, drag: { x: true, y: false, setScale: false }, points: { size: 6 }, focus: { prox: -1 } },
      hooks: {
        drawClear: [(u) => this.drawBand(u, band)],
        drawSeries: [(u, i) => { if (this.dense[i - 1] && u.series[i].show) this.drawColumns(u, i); }],
        setSelect: [(u) => {
          if (u.select.width < 4) return;
          const range = [u.posToVal(u.select.left, 'x'), u.posToVal(u.select.left + u.select.width, 'x')];
          u.setSelect({ left: 0, width: 0, top: 0, height: 0 }, false);
          onzoom?.(range);
        }],
        setCursor: [(u) => oncursor?.(u.cursor.idx ?? null, u)],
        ready: [(u) => u.over.addEventListener('dblclick', (event) => { event.stopImmediatePropagation(); onzoom?.(null); }, true)],
      },
    }, this.data, this.place);
    describe(this.plot.ctx.canvas, `${series.map((s) => s.label).join(', ')}: ${y}`);
    this.plot.over.addEventListener('wheel', (event) => this.wheel(event), { passive: false });
    if (this.range) this.plot.setScale('x', { min: this.range[0], max: this.range[1] });
  }

  wheel(event) {
    if (!event.ctrlKey && !event.shiftKey && Math.abs(event.deltaX) < Math.abs(event.deltaY) && !this.options.onzoom) return;
    if (!this.options.onzoom) return;
    event.preventDefault();
    const { min, max } = this.plot.scales.x;
    const at = this.plot.posToVal(event.offsetX, 'x');
    const f = Math.exp(event.deltaY * 0.0015);
    const whole = this.options.whole?.() ?? [min, max];
    const range = [Math.max(at - (at - min) * f, whole[0]), Math.min(at + (max - at) * f, whole[1])];
    if (range[1] - range[0] >= (whole[1] - whole[0]) * 0.9999) this.options.onzoom(null); else this.options.onzoom(range);
  }

  drawBand(u, band) {
    if (!band) return;
    const top = u.valToPos(band, 'y', true);
    const bottom = u.valToPos(-band, 'y', true);
    u.ctx.save();
    u.ctx.fillStyle = colour('raised');
    u.ctx.fillRect(u.bbox.left, Math.max(top, u.bbox.top), u.bbox.width, Math.min(bottom, u.bbox.top + u.bbox.height) - Math.max(top, u.bbox.top));
    u.ctx.restore();
  }

  /** A curve that goes up and down in every pixel column: its extremes as bars. As one line it takes seconds to paint. */
  drawColumns(u, i) {
    const [x, y] = [u.data[0], u.data[i]];
    const { left, top, width, height } = u.bbox;
    const half = ((this.options.series[i - 1].width ?? 1.3) * thickness() * devicePixelRatio) / 2;
    u.ctx.save();
    u.ctx.beginPath();
    u.ctx.rect(left, top, width, height);
    u.ctx.clip();
    u.ctx.fillStyle = u.series[i].stroke(u, i);
    for (let k = 0; k + 1 < x.length; k += 2) {
      const ends = [y[k], y[k + 1], y[k + 2] ?? y[k + 1]].filter((v) => v !== null && v !== undefined);
      if (!ends.length) continue;
      // Whole pixels: their edges need no smoothing.
      const from = Math.floor(u.valToPos(x[k], 'x', true));
      const to = Math.floor(u.valToPos(x[k + 2] ?? x[k + 1], 'x', true));
      const high = Math.round(u.valToPos(Math.max(...ends), 'y', true) - half);
      const low = Math.round(u.valToPos(Math.min(...ends), 'y', true) + half);
      u.ctx.fillRect(from, high, Math.max(to - from, 1), Math.max(low - high, 1));
    }
    u.ctx.restore();
  }

  get fittingLabel() { return fitting(this.options.y, this.size().height - 2.5 * rem()); }

  size() { return { width: Math.max(this.place.clientWidth, 80), height: Math.max(this.place.clientHeight, 60) }; }

  resize() {
    const { width, height } = this.size();
    if (width === this.plot.width && height === this.plot.height) return;
    // Another size of letters, or room for the label: axes and labels are made anew.
    if (this.letters !== rem() || this.labelled !== this.fittingLabel) { this.build(); this.options.onresize?.(); return; }
    this.plot.setSize({ width, height });
    this.options.onresize?.();
  }

  /** Columns worth asking for: one for each pixel of the plot. */
  get columns() { return Math.max(200, Math.round(this.plot.bbox.width)); }

  set(data, range = null) {
    this.data = data;
    this.range = range;
    // Extremes of pixel columns come in pairs; fewer values are the samples themselves, and a line.
    this.dense = data.slice(1).map((y) => y.length > 1.9 * this.columns && isDense(y));
    this.plot.setData(data, false);
    this.plot.setScale('x', { min: range?.[0] ?? data[0][0], max: range?.[1] ?? data[0].at(-1) });
  }

  /** The label of the ordinate, which stays when the plot is made anew for another size of letters. */
  label(text) { this.options.y = text; if (this.labelled) this.plot.axes[1].label = this.labelled = this.fittingLabel; }

  /** What a file of this plot has: the curves that are shown, with their unit. */
  get drawn() {
    const { x, y, abscissa = x, series } = this.options;
    const shown = series.map((one, k) => ({ ...one, values: this.data[k + 1] ?? [] })).filter((one) => one.show ?? true);
    const unit = y.match(/\(.*\)$/)?.[0] ?? '';
    return { title: y.replace(unit, '').trim(), canvas: this.plot.ctx.canvas, legend: shown, columns: [[abscissa, this.data[0] ?? []], ...shown.map(({ label, values }) => [`${label} ${unit}`.trim(), values])] };
  }

  dash(index, dash) { this.options.series[index].dash = dash; this.plot.series[index + 1].dash = dash; }

  show(index, on) { this.options.series[index].show = on; this.plot.setSeries(index + 1, { show: on }); }

  destroy() { this.observer.disconnect(); removeEventListener('themechange', this.repaint); this.plot.destroy(); }
}

function padded(low, high) {
  if (!Number.isFinite(low) || !Number.isFinite(high)) return [0, 1];
  const room = (high - low || Math.abs(high) || 1) * 0.06;
  return [low - room, high + room];
}

/** Values for a line plot, in another unit: a plain array with null where there is no number. */
export function scaled(values, factor = 1) {
  const out = new Array(values.length);
  for (let k = 0; k < values.length; k++) out[k] = Number.isNaN(values[k]) || values[k] === null ? null : values[k] * factor;
  return out;
}

/** One quantity over another on a canvas: sets of points or lines. */
export class XyPlot {
  constructor(place, { x, y, title = `${y} over ${x}`, xFactor = 1, yFactor = 1, equal = false, tick: text = tick, ticks: places = ticks, room = 5 }) {
    Object.assign(this, { place, x, y, title, xFactor, yFactor, equal, text, places, room, sets: [], marks: [] });
    this.canvas = document.createElement('canvas');
    this.canvas.className = 'xy';
    describe(this.canvas, title);
    place.append(this.canvas, saveButtons(() => this.drawn));
    this.observer = new ResizeObserver(() => this.draw());
    this.observer.observe(place);
    this.repaint = () => this.draw();
    addEventListener('themechange', this.repaint);
  }

  /** @param {{x: ArrayLike<number>, y: ArrayLike<number>, ink: string, label?: string, points?: boolean, width?: number, closed?: boolean}[]} sets */
  set(sets, limits = null) { this.sets = sets; this.limits = limits; this.draw(); }

  destroy() { this.observer.disconnect(); removeEventListener('themechange', this.repaint); }

  /** What a file of this plot has: two columns for each set that has a name, unless `columns` says otherwise. */
  get drawn() {
    const legend = [...new Map(this.sets.filter((set) => set.label).map((set) => [set.label, set])).values()];
    const columns = legend.flatMap(({ label, x, y }) => [[this.x, scaled(x, this.xFactor)], [`${label} ${this.y}`.trim(), scaled(y, this.yFactor)]]);
    return { title: this.title, canvas: this.canvas, legend, columns: this.columns ?? columns };
  }

  draw() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (width < 40 || height < 40) return;
    const ratio = Math.min(devicePixelRatio, 2);
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    const c = this.canvas.getContext('2d');
    c.setTransform(ratio, 0, 0, ratio, 0, 0);
    c.clearRect(0, 0, width, height);
    const size = rem();
    const frame = { left: size * (this.y ? this.room : 3.4), right: width - size * 0.9, top: size * 0.7, bottom: height - size * 3.1 };
    let [x0, x1, y0, y1] = this.limits ?? this.bounds();
    if (this.equal) {
      const scale = Math.max((x1 - x0) / (frame.right - frame.left), (y1 - y0) / (frame.bottom - frame.top));
      const [mx, my] = [(x0 + x1) / 2, (y0 + y1) / 2];
      [x0, x1] = [mx - scale * (frame.right - frame.left) / 2, mx + scale * (frame.right - frame.left) / 2];
      [y0, y1] = [my - scale * (frame.bottom - frame.top) / 2, my + scale * (frame.bottom - frame.top) / 2];
    }
    const px = (v) => frame.left + ((v - x0) / (x1 - x0)) * (frame.right - frame.left);
    const py = (v) => frame.bottom - ((v - y0) / (y1 - y0)) * (frame.bottom - frame.top);
    this.toPixel = (x, y) => [px(x), py(y)];
    this.axes(c, frame, [x0, x1], [y0, y1], px, py);
    c.save();
    c.beginPath();
    c.rect(frame.left, frame.top, frame.right - frame.left, frame.bottom - frame.top);
    c.clip();
    for (const set of this.sets) this.drawSet(c, set, px, py);
    for (const mark of this.marks) {
      c.fillStyle = mark.ink.startsWith('#') ? mark.ink : colour(mark.ink);
      c.beginPath();
      c.arc(px(mark.x), py(mark.y), size * 0.36, 0, 7);
      c.fill();
    }
    c.restore();
  }

  drawSet(c, { x, y, ink, points, width: thin = 1.4, closed, dash }, px, py) {
    const width = thin * thickness();
    const paint = ink.startsWith('#') ? ink : colour(ink);
    if (points) {
      c.fillStyle = paint;
      for (let k = 0; k < x.length; k++) if (!Number.isNaN(y[k])) c.fillRect(px(x[k]) - width / 2, py(y[k]) - width / 2, width, width);
      return;
    }
    c.strokeStyle = paint;
    c.lineWidth = width;
    c.setLineDash(dash && !isDense(x) && !isDense(y) ? dash : []);
    c.beginPath();
    let pen = false;
    for (let k = 0; k < x.length; k++) {
      if (Number.isNaN(y[k]) || y[k] === null) { pen = false; continue; }
      if (pen) c.lineTo(px(x[k]), py(y[k])); else c.moveTo(px(x[k]), py(y[k]));
      pen = true;
    }
    if (closed) c.closePath();
    c.stroke();
    c.setLineDash([]);
  }

  axes(c, frame, [x0, x1], [y0, y1], px, py) {
    c.font = font();
    c.strokeStyle = colour('grid');
    c.fillStyle = colour('dim');
    c.lineWidth = 1;
    const xs = this.places(x0 * this.xFactor, x1 * this.xFactor, (frame.right - frame.left) / (rem() * 4.5));
    const ys = this.places(y0 * this.yFactor, y1 * this.yFactor, (frame.bottom - frame.top) / (rem() * 2.4));
    c.textAlign = 'center';
    c.textBaseline = 'top';
    for (const v of xs.values) {
      const at = Math.round(px(v / this.xFactor)) + 0.5;
      c.beginPath(); c.moveTo(at, frame.top); c.lineTo(at, frame.bottom); c.stroke();
      c.fillText(this.text(v, xs.step), at, frame.bottom + 5);
    }
    c.fillText(this.x, (frame.left + frame.right) / 2, frame.bottom + rem() * 1.6);
    c.textAlign = 'right';
    c.textBaseline = 'middle';
    for (const v of ys.values) {
      const at = Math.round(py(v / this.yFactor)) + 0.5;
      c.beginPath(); c.moveTo(frame.left, at); c.lineTo(frame.right, at); c.stroke();
      c.fillText(this.text(v, ys.step), frame.left - 6, at);
    }
    c.save();
    c.translate(rem() * 0.9, (frame.top + frame.bottom) / 2);
    c.rotate(-Math.PI / 2);
    c.textAlign = 'center';
    c.fillText(fitting(this.y, frame.top + frame.bottom), 0, 0);
    c.restore();
  }

  bounds() {
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const { x, y } of this.sets) {
      for (let k = 0; k < x.length; k++) {
        if (y[k] === null || Number.isNaN(y[k])) continue;
        if (x[k] < x0) x0 = x[k]; if (x[k] > x1) x1 = x[k];
        if (y[k] < y0) y0 = y[k]; if (y[k] > y1) y1 = y[k];
      }
    }
    return [...padded(x0, x1), ...padded(y0, y1)];
  }
}

function ticks(low, high, count) {
  const raw = (high - low) / Math.max(count, 4.2);
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * decade).find((s) => s >= raw) ?? raw;
  const values = [];
  for (let v = Math.ceil(low / step - 1e-9) * step; v <= high + 1e-9 * step; v += step) values.push(Math.abs(v) < 1e-9 * step ? 0 : v);
  return { values, step };
}
