// Model over measurement: signal and residual with linked zoom, or force over velocity and position.
import { curves } from './api.js';
import { h, fill, legendItem, number, say, scaleOf, words } from './dom.js';
import { INKS, LinePlot, XyPlot, scaled } from './plot.js';

export class Overlay {
  constructor() {
    this.record = h('select', { 'aria-label': 'record and channel', onchange: () => this.choose(Number(this.record.value)) });
    this.abscissa = h('select', { 'aria-label': 'abscissa', onchange: () => { this.build(); this.onview?.(); } });
    this.legend = h('span', { class: 'legend' });
    this.begin = h('span', { class: 'dim', title: 'Rows at the ends, at gaps and before the first reversal are not compared: there the history of the friction is not known' });
    this.values = [h('span', {}), h('span', {})];
    this.signal = h('div', { class: 'plot' });
    this.residual = h('div', { class: 'plot' });
    this.element = h('div', { class: 'overlay', title: '' },
      h('div', { class: 'plot-head' }, this.record, 'over', this.abscissa, this.begin, this.legend),
      this.signal, this.residual, h('div', { class: 'under-cursor', 'aria-hidden': 'true' }, this.values));
    this.plots = [];
    this.others = [];
    addEventListener('themechange', () => { if (this.one) this.build(); });
    this.range = null;
    this.shifted = null;
    this.hidden = new Set();
  }

  /** Overlays of a job; the same record and channel as before where there is one. */
  show(job, overlays) {
    const before = this.one && `${this.one.record} ${this.one.channel}`;
    this.job = job;
    this.overlays = overlays;
    this.others = [];
    fill(this.record, overlays.map((one, k) => h('option', { value: String(k) }, `${one.record} (${one.role === 'fit' ? 'fit' : 'held out'}): ${words(one.channel)}`)));
    const k = Math.max(overlays.findIndex((one) => `${one.record} ${one.channel}` === before), 0);
    this.record.value = String(k);
    this.choose(k, overlays[k] && before === `${overlays[k].record} ${overlays[k].channel}`);
  }

  choose(k, keep = false) {
    this.one = this.overlays[k];
    this.shifted = null;
    if (!this.one) return;
    if (!keep) this.range = null;
    this.begin.textContent = this.one.begins - this.one.from > 0.01 * (this.one.to - this.one.from) ? `compared from ${number(this.one.begins, 3)} s` : '';
    const chosen = this.abscissa.value;
    fill(this.abscissa, h('option', { value: '' }, 'time'), Object.keys(this.one.motion).map((name) => h('option', { value: name }, name)));
    this.abscissa.value = chosen in this.one.motion ? chosen : '';
    this.build();
    this.onchoose?.();
    this.onview?.();
  }

  /** Record, channel, abscissa and window of time, for the address. */
  get view() {
    if (!this.one) return {};
    const [from, to] = this.range ?? [];
    const first = this.one === this.overlays[0];
    return { record: first ? '' : this.one.record, channel: first ? '' : this.one.channel, over: this.abscissa.value, from: from && number(from, 6), to: to && number(to, 6) };
  }

  set view({ record, channel, over, from, to }) {
    const k = this.overlays?.findIndex((one) => one.record === record && (!channel || one.channel === channel)) ?? -1;
    if (k > 0 && this.overlays[k] !== this.one) { this.record.value = String(k); this.choose(k); }
    const window = [Number.parseFloat(from), Number.parseFloat(to)];
    if (window.every(Number.isFinite) && window[0] < window[1]) this.range = window;
    if (over && this.one && over in this.one.motion) this.abscissa.value = over;
    if (this.one) this.build();
  }

  /** Draw the predictions of other models beside that of the fitted one: `[name, label]`. */
  compareWith(others) {
    this.others = others.filter(([name]) => this.one?.models.includes(name));
    this.build();
  }

  /** Zoom to a window of time, or the whole record (null). */
  zoom(range) {
    this.range = range;
    this.load().catch((error) => say(error.message, 'bad'));
    this.onview?.();
  }

  /** Draw the prediction with other values of the parameters, from a job of its own; null: the fitted model alone. */
  async moved(job, one = null) {
    const known = this.shifted !== null;
    this.shifted = job === null ? null : { job, one };
    if (known && this.shifted && !this.abscissa.value && this.plots.length) await this.load(); else await this.build();
  }

  /** Job and overlay that the curves are read from. */
  get source() { return this.shifted ?? { job: this.job, one: this.one }; }

  get lines() {
    const inks = INKS();
    // One colour for each meaning: the fitted model, other models, and values that are moved by hand.
    const free = ['good', inks[4], inks[1], inks[5], inks[3]];
    const others = this.others.map(([name, label], k) => ({ name, label, ink: free[k % free.length] }));
    return [{ name: 'model', label: 'model', ink: inks[0] }, ...(this.shifted ? [{ name: 'moved', label: 'changed', ink: 'map-forward' }] : others)];
  }

  async build() {
    const turn = this.turn = (this.turn ?? 0) + 1;
    const lines = this.lines;
    fill(this.legend, [{ ink: 'measured', label: 'measured' }, ...lines].map(({ ink, label }) => legendItem(ink, label, this.hidden, () => this.build())));
    try {
      if (this.abscissa.value) await this.overMotion(lines, turn); else await this.overTime(lines);
    } catch (error) { say(error.message, 'bad'); }
  }

  /** Values under the cursor, beside the label of the time axis: both plots share the cursor. */
  readOut(plot, k, index) {
    this.values[k].textContent = index === null || !plot ? '' : this.texts[k](plot.data.map((values) => values[index]));
  }

  /** Remove what is drawn, once the values of the next plots are there. */
  clear() {
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    for (const one of this.values) one.textContent = '';
    fill(this.signal, ''); fill(this.residual, '');
  }

  row(name) { return this.source.one.series.indexOf(name); }

  async overTime(lines) {
    const { one, job } = this.source;
    const whole = [one.from, one.to];
    const read = (plot, k) => (index) => this.readOut(plot(), k, index);
    const common = { sync: 'overlay', whole: () => whole, onzoom: (range) => this.zoom(range), onresize: () => this.load().catch((error) => say(error.message, 'bad')) };
    const shown = (label) => !this.hidden.has(label);
    const measured = { label: 'measured', ink: 'measured', width: 2.4, show: shown('measured') };
    const { factor, unit } = scaleOf(one.largest, one.unit);
    const usual = one.usual || one.noise;
    const small = scaleOf(Math.max(usual, 2 * one.noise), one.unit);
    this.clear();
    this.texts = [
      ([time, first, ...others]) => `${number(time, 5)} s: ${[first, ...others].map((v) => number(v, 4)).join(' / ')} ${unit}`,
      ([, ...residuals]) => `residual ${residuals.map((v) => number(v, 3)).join(' / ')} ${small.unit}`,
    ];
    this.scales = [factor, small.factor];
    const reach = Math.max(2.2 * usual, 4 * one.noise) * small.factor;
    this.plots = [
      new LinePlot(this.signal, { ...common, oncursor: read(() => this.plots[0], 0), x: '', abscissa: 'time (s)', y: `${words(one.channel)} (${unit})`, series: [measured, ...lines.map(({ label, ink }) => ({ label, ink, width: 1.2, show: shown(label) }))] }),
      new LinePlot(this.residual, { ...common, oncursor: read(() => this.plots[1], 1), x: 'time (s)', y: `residual (${small.unit})`, band: 2 * one.noise * small.factor, series: lines.map(({ label, ink }) => ({ label, ink, width: 1, show: shown(label) })),
        yRange: (low, high) => { const top = Math.min(Math.max(Math.abs(low), Math.abs(high)) * 1.1 || reach, reach); return [-Math.max(top, 3 * one.noise * small.factor), Math.max(top, 3 * one.noise * small.factor)]; } }),
    ];
    await this.load();
  }

  async load() {
    this.aborter?.abort();
    const aborter = this.aborter = new AbortController();
    const [start, stop] = this.range ?? [null, null];
    const lines = this.lines;
    const rows = [['measured', ...lines.map(({ name }) => name)], lines.map(({ name }) => `residual:${name}`)];
    const { plots, source } = this;
    try {
      await Promise.all(plots.map(async (plot, k) => {
        const data = await curves(source.job, source.one.curves, rows[k].map((name) => this.row(name)), { start, stop, columns: plot.columns }, aborter.signal);
        if (plots === this.plots) plot.set([data[0], ...data.slice(1).map((y) => scaled(y, this.scales[k]))], this.range);
      }));
    } catch (error) { if (error.name !== 'AbortError') throw error; }
  }

  async overMotion(lines, turn) {
    const { one, job } = this.source;
    const motion = this.abscissa.value;
    const names = [`motion:${motion}`, 'measured', ...lines.flatMap(({ name }) => [name, `residual:${name}`])];
    const [start, stop] = this.range ?? [null, null];
    const [, x, measured, ...rest] = await curves(job, one.curves, names.map((name) => this.row(name)), { start, stop, columns: 8000, pairs: true });
    if (turn !== this.turn) return;
    const sx = scaleOf(largest(x), one.motion[motion]);
    const sy = scaleOf(one.largest, one.unit);
    const residuals = lines.map((_, k) => rest[2 * k + 1]);
    const small = scaleOf(one.usual, one.unit);
    const label = `${motion} (${sx.unit})`;
    this.clear();
    const top = new XyPlot(this.signal, { x: label, y: `${words(one.channel)} (${sy.unit})`, xFactor: sx.factor, yFactor: sy.factor });
    const bottom = new XyPlot(this.residual, { x: label, y: `residual (${small.unit})`, xFactor: sx.factor, yFactor: small.factor });
    this.plots = [top, bottom];
    const shown = ({ label }) => !this.hidden.has(label);
    top.set([{ x, y: measured, ink: 'measured', label: 'measured', points: true, width: 2.6 }, ...lines.map(({ ink, label }, k) => ({ x, y: rest[2 * k], ink, label, points: true, width: 1.6 }))].filter(shown));
    // A few samples next to reversals would set the scale and hide all others.
    const reach = Math.max(2.2 * one.usual, 4 * one.noise);
    const ends = x.reduce(([a, b], v) => [Math.min(a, v), Math.max(b, v)], [Infinity, -Infinity]);
    bottom.set(residuals.map((y, k) => ({ x, y, ink: lines[k].ink, label: lines[k].label, points: true, width: 1.6 })).filter(shown), [...ends, -reach, reach]);
  }
}

const largest = (values) => values.reduce((a, v) => (Math.abs(v) > a ? Math.abs(v) : a), 0);
