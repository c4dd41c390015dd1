// The simulations: the path of the tip at once, the experiments on one body with friction as jobs.
import { curves, get, jobs, post, result } from './api.js';
import { movablePanels } from './borders.js';
import { eachFrame, fill, h, legendItem, newest, number, quantity, say, scaleOf, setAddress, unitText, words } from './dom.js';
import { sliderRange, valueText } from './parameters.js';
import { DASHES, INKS, LinePlot, XyPlot, isDense, scaled } from './plot.js';

const TURN = 2400;

/** Quantities shown first: over the abscissa, and one over another. */
const USUAL = {
  'stick-slip': [['position [m]', 'spring_force [N]'], ['velocity [m/s]', 'spring_force [N]']],
  presliding: [['position [m]', 'drive_force [N]'], ['position [m]', 'drive_force [N]']],
  hysteresis: [['friction_force [N]', 'velocity [m/s]'], ['velocity [m/s]', 'friction_force [N]']],
  passivity: [['core_work [J]', 'velocity [m/s]'], ['velocity [m/s]', 'friction_force [N]']],
  'stage-steps': [['x [m]', 'tip_force_z [N]'], ['tip_x [m]', 'tip_z [m]']],
  'stage-coupling': [['x [m]', 'y [m]'], ['tip_x [m]', 'tip_z [m]']],
  'stage-positioning': [['x [m]', 'error [m]'], ['x [m]', 'error [m]']],
  'stage-hunting': [['x [m]', 'error [m]'], ['x [m]', 'error [m]']],
};

class Simulation {
  constructor(section) {
    this.section = section;
    this.changes = {};
    this.turn = newest();
    this.asked = newest();
    this.left = h('div', { class: 'panel' });
    this.middle = h('div', { class: 'panel' });
    this.right = h('div', { class: 'panel' });
    fill(section, this.left, this.middle, this.right);
    addEventListener('themechange', () => { if (this.found && this.name !== 'tip') this.draw(this.job, this.found); });
  }

  async start() {
    this.info = await get('/api/simulation');
    this.models = new Set(['lugre', 'lugre_causal']);
    this.choice = h('select', { 'aria-label': 'experiment', onchange: () => this.choose(this.choice.value) },
      h('option', { value: 'tip' }, 'tip'), Object.keys(this.info.experiments).map((name) => h('option', { value: name }, name)));
    this.body = h('div', { class: 'scroll' });
    this.heading = h('h2');
    this.features = h('div', { class: 'scroll' });
    fill(this.left, h('div', { class: 'head' }, h('h2', {}, 'Experiment'), h('span', { class: 'space' }), this.choice), this.body);
    fill(this.right, h('div', { class: 'head' }, this.heading), this.features);
    movablePanels('simulation', this.left, this.right);
  }

  /** `#simulation/EXPERIMENT`. The design may have changed since: its values are those of the sliders. */
  async shown([wanted]) {
    const known = (name) => name === 'tip' || name in this.info.experiments;
    if (wanted && !known(wanted)) say(`${wanted}: no such experiment`, 'bad');
    const last = [...jobs.values()].filter((job) => job.task === 'simulate' && job.state === 'done').at(-1);
    const name = known(wanted) ? wanted : this.name ?? last?.subject ?? 'stick-slip';
    if (name !== this.name) { this.choose(name, last?.subject === name ? last : null); return; }
    setAddress(this.section, [name]);
    const current = this.asked();
    const info = await get('/api/simulation');
    if (!current() || JSON.stringify(info) === JSON.stringify(this.info)) return;
    this.info = info;
    this.choose(this.name);
  }

  choose(name, job = null) {
    this.name = this.choice.value = name;
    setAddress(this.section, [name]);
    this.turn();
    cancelAnimationFrame(this.animation);
    for (const plot of this.plots ?? []) plot.destroy();
    this.plots = [];
    this.hidden = new Set();
    if (name === 'tip') this.openTip(); else this.openExperiment(job);
  }

  slider(p, onchange, live = false, text = p.text) {
    const range = p.range ?? sliderRange({ ...p, kind: 'number', low: p.low ?? 0, high: null });
    // A computed value may have more digits than the field has room for.
    const shown = text.length > 11 ? `${Number(p.number.toPrecision(4))} ${p.unit}` : text;
    const field = h('input', { type: 'text', value: shown, title: `design: ${p.text}`, 'aria-label': p.key, spellcheck: 'false' });
    const slider = h('input', { type: 'range', 'aria-label': `${p.key}, slider` });
    Object.assign(slider, { min: range.low, max: range.high, step: range.step, value: text === p.text ? p.number : Number.parseFloat(text) });
    let last = [field.value, slider.value];
    // What is refused leaves the value before.
    const change = (given, value) => {
      const before = last;
      last = [field.value, slider.value];
      onchange(given, value, () => { last = before; [field.value, slider.value] = before; });
    };
    slider.addEventListener('input', () => { field.value = valueText(p, slider.valueAsNumber, range.step); if (live) change(field.value, slider.valueAsNumber); });
    slider.addEventListener('change', () => change(field.value, slider.valueAsNumber));
    slider.addEventListener('dblclick', () => { field.value = p.text; slider.value = p.number; change(p.text, p.number); });
    field.addEventListener('change', () => {
      const [, digits, unit] = field.value.trim().match(/^([-+]?(?:\d+\.?\d*|\.\d+)(?:e[-+]?\d+)?)\s*(.*)$/i) ?? [];
      // The tip is drawn from numbers in this unit; an experiment takes a text with any.
      if (digits === undefined || (live && unit && unit !== p.unit)) {
        say(`${p.key}: '${field.value}': a number${p.unit ? ` in ${p.unit}` : ''} is required`, 'bad');
        [field.value, slider.value] = last;
        return;
      }
      if (!unit && p.unit) field.value = `${digits} ${p.unit}`;
      if (!unit || unit === p.unit) slider.value = digits;
      say('');
      change(field.value, Number(digits));
    });
    return h('div', { class: 'row' }, h('span', { class: 'name', title: p.meaning }, words(p.title ?? p.key.split('.').at(-1))), slider, field);
  }

  // The tip -----------------------------------------------------------------------------------------------------------

  openTip() {
    const { tip } = this.info;
    const spacing = tip['actuator.piezo_spacing'];
    const height = tip['actuator.tip_height'];
    const stroke = tip['actuator.stroke_amplitude'];
    const phase = tip['actuator.phase'];
    this.tip = { piezo_spacing: spacing.si, tip_height: height.si, stroke: stroke.si, phase: phase.si };
    const draw = eachFrame(() => this.drawTip());
    const set = (name, p) => (_, value) => { if (Number.isFinite(value)) { this.tip[name] = value * (p.si / p.number); draw(); } };
    fill(this.body, h('div', { class: 'card rows' },
      this.slider({ ...spacing, title: 'piezo spacing D' }, set('piezo_spacing', spacing), true),
      this.slider({ ...height, title: 'tip height h' }, set('tip_height', height), true),
      this.slider({ ...stroke, title: 'piezo amplitude' }, set('stroke', stroke), true),
      this.slider({ ...phase, title: 'phase', range: { low: -180, high: 180, step: 1 } }, set('phase', phase), true)),
    h('div', { class: 'card dim' }, h('p', {}, 'Two piezos extend by sines with a phase between them; the tip above them moves on an ellipse and pushes the stage along.')));
    const title = h('div', { class: 'head' }, h('h2', {}, 'Path of the tip'), h('span', { class: 'dim' }, 'x along the travel, y towards the stage; the same scale on both axes'));
    const place = h('div', { class: 'plot grow' });
    fill(this.middle, title, place);
    const plot = new XyPlot(place, { x: 'x (µm)', y: 'y (µm)', xFactor: 1e6, yFactor: 1e6, equal: true });
    this.plots = [plot];
    this.heading.textContent = 'Ellipse';
    fill(this.features);
    const still = matchMedia('(prefers-reduced-motion: reduce)').matches;
    const move = (time) => {
      if (!this.section.hidden && this.path) {
        const n = this.path.x.length;
        const k = still ? 0 : Math.floor(((time % TURN) / TURN) * n);
        plot.marks = [{ x: this.path.x[k], y: this.path.y[k], ink: '#e69f00' }];
        plot.draw();
      }
      if (!still) this.animation = requestAnimationFrame(move);
    };
    this.animation = requestAnimationFrame(move);
    this.tipPlot = plot;
    this.limits = null;
    this.drawTip();
  }

  async drawTip() {
    if (this.asking) { this.again = true; return; }
    this.asking = true;
    try {
      do {
        this.again = false;
        this.path = await post('/api/simulation/tip', this.tip);
      } while (this.again);
      if (this.name !== 'tip') return;
      // The frame follows the amplitude in steps, so that the ellipse is seen to change and not the axes.
      const reach = Math.max(...this.path.x.map(Math.abs), ...this.path.y.map(Math.abs));
      const round = (v) => { const d = 10 ** Math.floor(Math.log10(v)); return [1, 2, 5, 10].map((k) => k * d).find((s) => s >= v); };
      const frame = round(reach * 1.15);
      this.tipPlot.set([{ x: this.path.x, y: this.path.y, ink: INKS()[0], label: 'path of the tip', width: 2, closed: true }], [-frame, frame, -frame, frame]);
      const { semi_major: major, semi_minor: minor, tilt } = this.path.features;
      fill(this.features, h('div', { class: 'card' }, h('table', {}, [
        ['semi-major axis', quantity(major)], ['semi-minor axis', quantity(minor)], ['tilt', `${number(tilt.value * 180 / Math.PI, 3)}°`],
        ['amplitude in x', quantity({ value: Math.max(...this.path.x.map(Math.abs)), unit: 'm' })],
        ['amplitude in y', quantity({ value: Math.max(...this.path.y.map(Math.abs)), unit: 'm' })],
      ].map(([name, value]) => h('tr', {}, h('td', {}, name), h('td', { class: 'num' }, value))))));
    } catch (error) { say(error.message, 'bad'); } finally { this.asking = false; }
  }

  // Experiments on one body -------------------------------------------------------------------------------------------

  get stage() { return this.name.startsWith('stage-'); }

  openExperiment(job) {
    const models = Object.entries(this.info.models).map(([name, title]) => {
      const box = h('input', { type: 'checkbox', checked: this.models.has(name), onchange: () => { if (box.checked) this.models.add(name); else this.models.delete(name); this.run(); } });
      return h('label', { class: 'model', title }, box, words(name));
    });
    fill(this.body,
      h('div', { class: 'card dim' }, h('p', {}, this.info.experiments[this.name])),
      this.stage ? null : h('div', { class: 'card' }, h('h3', {}, 'Friction model'), models),
      h('div', { class: 'card rows' }, h('h3', {}, 'Parameters'), this.info.parameters[this.stage ? 'stage' : 'body'].map((p) =>
        this.slider(p, (text, _, reset) => this.change(p, text, reset), false, this.changes[p.key]))));
    this.heading.textContent = 'Features';
    fill(this.features);
    fill(this.middle, h('p', { class: 'empty' }, 'simulating …'));
    const current = this.turn();
    if (job) result(job).then((found) => { if (current()) this.draw(job.number, found); }).catch(() => { if (current()) this.run(); });
    else if (this.stage) fill(this.middle, h('p', { class: 'empty' }, 'This study takes a minute or more. ', h('button', { class: 'main', onclick: () => this.run() }, 'Simulate')));
    else this.run();
  }

  change(p, text, reset) {
    const before = this.changes;
    this.changes = { ...before, [p.key]: text };
    if (text === p.text) delete this.changes[p.key];
    this.run(() => { this.changes = before; reset(); });
  }

  /** Simulate with the present values; `refused` is called where the server does not take them. */
  async run(refused = () => {}) {
    if (!this.models.size) { say('choose at least one friction model', 'bad'); return; }
    const current = this.turn();
    if (!this.plots.length) fill(this.middle, h('p', { class: 'empty' }, 'simulating …'));
    try {
      const job = await post('/api/simulation/run', { experiment: this.name, models: [...this.models], changes: this.changes }).catch((error) => { if (current()) refused(); throw error; });
      const found = await result(job);
      if (current()) { this.draw(job.number, found); say(''); }
    } catch (error) {
      if (!current()) return;
      const cancelled = error.name === 'Cancelled';
      say(cancelled ? `Simulate: ${error.message}` : error.message, cancelled ? '' : 'bad');
      if (!this.plots.length) fill(this.middle, h('p', { class: 'empty' }, h('span', { class: cancelled ? '' : 'bad' }, cancelled ? `${error.message}.` : error.message), ' ', h('button', { onclick: () => this.run() }, 'Simulate')));
    }
  }

  draw(job, found) {
    this.found = found;
    this.job = job;
    const columns = found.curves[0].series;
    const cases = [...new Set(found.curves.map((one) => one.title))];
    const quantities = columns.slice(1);
    const [over, pair] = USUAL[found.experiment] ?? [quantities.slice(0, 2), [quantities[0], quantities[1] ?? quantities[0]]];
    this.pick ??= {};
    const pick = this.pick[found.experiment] ??= { y: [...over], phase: [...pair] };
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
    const selector = (value, set) => { const s = h('select', { 'aria-label': 'quantity', onchange: () => { set(s.value); this.draw(job, found); } }, quantities.map((name) => h('option', { value: name }, title(name)))); s.value = value; return s; };
    const inks = INKS();
    const inkOf = (k) => inks[k % inks.length];
    const legend = h('span', { class: 'legend' }, cases.map((name, k) => legendItem(inkOf(k), caseName(name), this.hidden, () => this.draw(job, found))));
    const places = pick.y.map(() => h('div', { class: 'plot' }));
    const phase = h('div', { class: 'plot' });
    fill(this.middle,
      h('div', { class: 'head' }, h('h2', {}, words(found.experiment)), legend),
      pick.y.map((name, k) => h('div', { class: 'plot-box' }, h('div', { class: 'plot-head' }, selector(name, (v) => { pick.y[k] = v; }), null), places[k])),
      h('div', { class: 'plot-box' }, h('div', { class: 'plot-head' }, selector(pick.phase[1], (v) => { pick.phase[1] = v; }), 'over', selector(pick.phase[0], (v) => { pick.phase[0] = v; })), phase));
    this.middle.classList.add('stack');
    this.linePlots(pick.y, places, columns, inkOf);
    this.phasePlot(phase, pick.phase, columns, inkOf);
    this.showFeatures(Object.values(found.document)[0]);
  }

  async linePlots(names, places, columns, inkOf) {
    const shown = this.found.curves.slice(0, 8);
    const whole = [Math.min(...shown.map((one) => one.from)), Math.max(...shown.map((one) => one.to))];
    let range = null;
    const { job } = this;
    const turn = newest();
    const plots = names.map((name, k) => new LinePlot(places[k], {
      x: k === names.length - 1 ? title(columns[0]) : '', y: title(name), abscissa: title(columns[0]), sync: 'simulation', whole: () => whole, series: shown.map((one, i) => ({ label: caseName(one.title), ink: inkOf(i), width: 1.5, dash: DASHES[i % 4], show: !this.hidden.has(caseName(one.title)) })),
      onzoom: (next) => { range = next; load(); },
    }));
    this.plots.push(...plots);
    const load = async () => {
      const current = turn();
      const asked = range;
      const [start, stop] = asked ?? [null, null];
      try {
        await Promise.all(plots.map(async (plot, k) => {
          const row = columns.indexOf(names[k]);
          const found = await Promise.all(shown.map((one) => curves(job, one.curves, [row], { start, stop, columns: plot.columns })));
          if (!current() || !this.plots.includes(plot)) return;
          const joined = found.every(([x]) => same(x, found[0][0])) ? [found[0][0], ...found.map(([, y]) => y)] : join(found);
          const peak = joined.slice(1).reduce((m, y) => y.reduce((a, v) => (Math.abs(v) > a ? Math.abs(v) : a), m), 0);
          const { factor, unit } = scaleOf(peak, unitOf(names[k]));
          plot.label(`${words(names[k].split(' [')[0])} (${unit})`);
          joined.slice(1).forEach((y, i) => plot.dash(i, isDense(y) ? undefined : DASHES[i % 4]));
          plot.set([joined[0], ...joined.slice(1).map((y) => scaled(y, factor))], asked);
        }));
      } catch (error) { say(error.message, 'bad'); }
    };
    await load();
  }

  async phasePlot(place, [xName, yName], columns, inkOf) {
    const rows = [columns.indexOf(xName), columns.indexOf(yName)];
    const shown = this.found;
    const found = await Promise.all(shown.curves.slice(0, 8).map((one) => curves(this.job, one.curves, rows, { columns: 6000, pairs: true })));
    if (!place.isConnected) return;
    const peak = (k) => found.reduce((m, f) => f[k].reduce((a, v) => (Math.abs(v) > a ? Math.abs(v) : a), m), 0);
    const [sx, sy] = [scaleOf(peak(1), unitOf(xName)), scaleOf(peak(2), unitOf(yName))];
    const plot = new XyPlot(place, { x: `${words(xName.split(' [')[0])} (${sx.unit})`, y: `${words(yName.split(' [')[0])} (${sy.unit})`, xFactor: sx.factor, yFactor: sy.factor });
    this.plots.push(plot);
    plot.set(found.map(([, x, y], k) => ({ x, y, ink: inkOf(k), width: 1.4, dash: DASHES[k % 4], label: caseName(shown.curves[k].title) })).filter(({ label }) => !this.hidden.has(label)));
  }

  showFeatures(features) {
    const rows = [];
    const walk = (node, path) => {
      for (const [name, value] of Object.entries(node)) {
        if (value !== null && typeof value === 'object' && !('unit' in value)) walk(value, [...path, name]);
        else rows.push([path, name, value]);
      }
    };
    walk(features, []);
    const groups = new Map();
    for (const [path, name, value] of rows) groups.set(path.join(' '), [...(groups.get(path.join(' ')) ?? []), [name, value]]);
    fill(this.features, [...groups].map(([path, members]) => h('div', { class: 'card' }, h('h3', {}, caseName(path)),
      h('table', {}, members.map(([name, value]) => h('tr', {}, h('td', {}, caseName(name)), h('td', { class: 'num' }, quantity(value, 5))))))));
  }
}

/** A case of an experiment in words; its name has no slash: `v0_1.5mm_s`. */
const caseName = (name) => words(name).replace(/(\d)mm s\b/g, '$1 mm/s');
const unitOf = (name) => name.slice(name.indexOf('[') + 1, -1);
const title = (name) => `${words(name.split(' [')[0])} (${unitText(unitOf(name)) || '1'})`;
const same = (a, b) => a.length === b.length && a[0] === b[0] && a.at(-1) === b.at(-1) && a[a.length >> 1] === b[b.length >> 1];

/** Series over different abscissas as one table with gaps, for uPlot. */
function join(found) {
  const all = Float64Array.from(new Set(found.flatMap(([x]) => [...x]))).sort();
  return [all, ...found.map(([x, y]) => {
    const out = new Array(all.length);
    let k = 0;
    for (let i = 0; i < all.length; i++) {
      while (k < x.length - 1 && x[k + 1] <= all[i]) k++;
      const next = Math.min(k + 1, x.length - 1);
      const share = x[next] > x[k] ? (all[i] - x[k]) / (x[next] - x[k]) : 0;
      out[i] = all[i] < x[0] || all[i] > x.at(-1) ? null : y[k] + share * (y[next] - y[k]);
    }
    return out;
  })];
}

export async function open(section) {
  const simulation = new Simulation(section);
  await simulation.start();
  return simulation;
}
