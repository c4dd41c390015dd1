// The nearest design without violated rules and failed checks: what may change, the search, its result.
import { cancel, get, jobs, onJob, post, result } from './api.js';
import { h, fill, newest, quantity, say, swatch, words } from './dom.js';
import { INKS, XyPlot } from './plot.js';

export class Optimize {
  /**
   * @param {HTMLElement} place
   * @param {{apply: (changes: object) => void, digest: () => string, reveal: (key: string) => void, selected: () => string|undefined, range: (key: string) => string}} machine
   */
  constructor(place, machine) {
    this.machine = machine;
    this.turn = newest();
    this.opened = 0;
    this.current = 0;
    this.found = null;
    this.free = new Map();
    this.list = h('div', { class: 'free-list' });
    this.keep = h('input', { type: 'text', 'aria-label': 'required checks', placeholder: 'all checks', spellcheck: 'false', title: 'Names of the required checks, with commas; * stands for any text' });
    this.budget = h('input', { type: 'text', value: '600', 'aria-label': 'designs of the search', inputmode: 'numeric' });
    this.time = h('input', { type: 'text', value: '5', 'aria-label': 'minutes of the search', inputmode: 'decimal', title: 'Minutes after which the search ends with the best design so far' });
    this.start = h('button', { class: 'main', onclick: () => this.run() }, 'Optimize');
    this.progress = h('div', { class: 'search', hidden: true });
    this.best = h('div', { class: 'card best', hidden: true });
    this.result = h('div', { class: 'optimum' });
    this.plots = [];
    const choose = (text, on) => h('button', { class: 'small', onclick: () => { for (const one of this.free.values()) one.on = on; this.draw(); } }, text);
    place.append(h('div', { class: 'optimize' },
      h('div', { class: 'free scroll' },
        h('div', { class: 'card' }, h('div', { class: 'line' }, h('h2', {}, 'May change'), h('span', { class: 'space' }), h('span', { class: 'group' }, choose('All', true), choose('None', false))), h('p', { class: 'dim' }, 'Range LOW:HIGH, or choices A|B. Those of the parameter file are listed first.'), this.list,
          h('button', { class: 'small', onclick: () => this.addSelected(), title: 'The parameter selected in the list on the left' }, 'Add the selected parameter')),
        h('div', { class: 'card' }, h('h3', {}, 'Required'), h('label', { class: 'field' }, h('span', {}, 'checks'), this.keep), h('label', { class: 'field', title: 'Largest number of designs in each search; there are several' }, h('span', {}, 'designs'), this.budget), h('label', { class: 'field' }, h('span', {}, 'minutes'), this.time), h('div', { class: 'actions' }, this.start))),
      h('div', { class: 'scroll outcome' }, this.progress, this.best, this.result)));
    onJob((job) => { if (job.task === 'optimize') this.showProgress(job); });
    this.showEmpty();
  }

  showEmpty() {
    fill(this.result, h('p', { class: 'empty' }, 'Finds the design nearest to the present one that violates no rule and passes every required check. Where there is none, it names the requirements that contradict each other, and how far each must be relaxed.'));
  }

  async shown() {
    if (this.asked) return;
    this.asked = true;
    await this.load();
    const last = [...jobs.values()].filter((job) => job.task === 'optimize').at(-1);
    if (last && last.state !== 'failed' && last.state !== 'cancelled') this.follow(last);
  }

  /** Parameters that the file marks as free; called again when another file is opened. */
  async load() {
    const current = this.turn();
    const found = await get('/api/machine/optimize');
    if (!current()) return;
    this.free = new Map(Object.entries(found).map(([key, text]) => [key, { text, on: true }]));
    this.draw();
  }

  draw() {
    fill(this.list, this.free.size ? [...this.free].map(([key, one]) => {
      const box = h('input', { type: 'checkbox', checked: one.on, 'aria-label': `${key} may change`, onchange: () => { one.on = box.checked; } });
      const range = h('input', { type: 'text', value: one.text, 'aria-label': `range of ${key}`, spellcheck: 'false', onchange: () => { one.text = range.value; one.on = box.checked = true; } });
      return h('div', { class: 'free-row' }, box, h('button', { class: 'chip', title: 'Show the parameter', onclick: () => this.machine.reveal(key) }, broken(key)), range);
    }) : h('p', { class: 'dim' }, 'The file marks none (free = "8 mm..20 mm"): select a parameter on the left and add it.'));
  }

  addSelected() {
    const key = this.machine.selected();
    if (!key) { say('select a parameter on the left first', 'bad'); return; }
    this.free.set(key, { text: this.free.get(key)?.text ?? this.machine.range(key), on: true });
    this.draw();
    this.list.lastChild?.scrollIntoView({ block: 'nearest' });
  }

  /** Another file is open: the last result is of another design. */
  async reset() {
    this.current = Infinity;
    this.opened += 1;
    this.start.disabled = false;
    this.clear();
    this.showEmpty();
    await this.load();
  }

  clear() {
    this.found = null;
    this.best.hidden = true;
    for (const plot of this.plots) plot.destroy();
    this.plots = [];
  }

  async run() {
    const free = Object.fromEntries([...this.free].filter(([, one]) => one.on).map(([key, one]) => [key, one.text]));
    const budget = Number(this.budget.value);
    const keep = this.keep.value.split(',').map((text) => text.trim()).filter(Boolean);
    this.start.disabled = true;
    const { opened } = this;
    try {
      if (!Object.keys(free).length) throw new Error('let at least one parameter change');
      if (!(Number.isInteger(budget) && budget >= 20)) throw new Error(`designs: '${this.budget.value}': a whole number from 20 is required`);
      const minutes = Number(this.time.value.replace(',', '.'));
      if (!(minutes >= 0.05 && minutes <= 10_000)) throw new Error(`minutes: '${this.time.value}': a number from 0.05 is required`);
      say('');
      const job = await post('/api/machine/optimize', { free, keep, budget, seconds: 60 * minutes });
      // Another file may be open by now.
      if (opened !== this.opened) return;
      this.clear();
      fill(this.result);
      this.follow(job);
    } catch (error) {
      if (opened !== this.opened) return;
      this.start.disabled = false;
      say(error.message, 'bad');
    }
  }

  async follow(job) {
    this.current = job.number;
    this.best.hidden = true;
    this.bestOf = null;
    this.showProgress(jobs.get(job.number) ?? job);
    try {
      const found = await result(job);
      if (job.number === this.current) this.show(found);
    } catch (error) {
      if (job.number !== this.current) return;
      if (error.name === 'Cancelled') say(`Optimize: ${error.message}`); else say(error.message, 'bad');
    }
    this.showProgress(jobs.get(job.number) ?? job);
  }

  /** The best design that a search has evaluated so far, at most once a second; it stays after a search is cancelled. */
  async showBest(job) {
    if (this.asking || job.number !== this.current) return;
    this.asking = true;
    const best = await get(`/api/machine/optimize/${job.number}/best`).catch(() => null);
    if (best && job.number === this.current && !this.found) {
      const changes = Object.fromEntries(best.changes.map(([key, , to]) => [key, to]));
      const text = JSON.stringify(best);
      if (text !== this.bestOf) {
        fill(this.best, h('div', { class: 'line' }, h('h3', {}, 'Best design so far'), h('span', { class: 'space' }), best.changes.length ? h('button', { class: 'small', onclick: () => this.machine.apply(changes) }, 'Apply') : null),
          h('p', {}, [best.rules ? `${best.rules} rules violated, ` : '', `${best.required - best.failing} of ${best.required} requirements met`]),
          h('table', {}, h('tbody', {}, best.changes.map(([key, before, after]) => h('tr', {}, h('td', {}, broken(key)), h('td', { class: 'num' }, rounded(before)), h('td', { class: 'num now' }, rounded(after)))))));
        this.bestOf = text;
      }
      this.best.hidden = false;
    }
    setTimeout(() => { this.asking = false; }, 1000);
  }

  showProgress(job) {
    // A search that was replaced may end after the present one began.
    if (job.number < this.current && this.current !== Infinity) return;
    const busy = job.state === 'running' || job.state === 'waiting';
    this.start.disabled = busy;
    if (!busy) { this.showAge(); return; }
    if (job.state === 'running') this.showBest(job);
    this.progress.hidden = false;
    // The elements of a job stay: a button that is made anew at each step cannot be clicked.
    if (this.line?.number !== job.number) {
      this.line = { number: job.number, step: h('span', { class: 'dim step' }) };
      fill(this.progress, this.line.step, h('progress', { 'aria-label': 'Optimize' }),
        h('button', { class: 'small', title: 'End the search with the best design so far', onclick: () => post(`/api/machine/optimize/${job.number}/stop`) }, 'Stop'), h('button', { class: 'small', onclick: () => cancel(job) }, 'Cancel'));
    }
    this.line.step.textContent = job.step || 'waiting';
  }

  /** A result is that of one design: it is marked while the present design is another. */
  showAge() {
    const old = this.found !== null && this.found.digest !== this.machine.digest();
    this.result.classList.toggle('outdated', old);
    for (const button of this.result.querySelectorAll('button.main')) button.disabled = old;
    if (this.start.disabled) return;
    this.line = null;
    fill(this.progress, old ? h('span', { class: 'warn' }, 'Out of date: the design has changed since this search.') : '');
    this.progress.hidden = !old;
  }

  show(found) {
    const { document } = found;
    this.clear();
    this.found = found;
    const alone = (document.conflicts ?? []).filter((names) => names.length === 1).map(([name]) => name);
    const sets = (document.conflicts ?? []).filter((names) => names.length > 1);
    const margins = (document.margins ?? []).filter((row) => row.after && (row.after.verdict !== row.before.verdict || percent(row.after.margin) !== percent(row.before.margin)));
    const count = Object.keys(found.changes).length;
    fill(this.result,
      h('div', { class: `card verdict ${document.feasible ? 'good' : 'unexplained'}` },
        h('b', {}, document.feasible ? (count ? 'A design that meets all requirements' : 'The present design meets all requirements') : 'No design within the ranges meets all requirements'),
        h('p', { class: 'dim' }, `${found.required} requirements, ${document.evaluations} designs evaluated${found.ended ? `; ${found.ended}: more time may find more` : ''}`),
        found.unverified.length ? h('p', { class: 'warn' }, `With the masses of its own solids these fail: ${found.unverified.join(', ')}`) : null),
      count ? h('div', { class: 'card' },
        h('div', { class: 'line' }, h('h3', {}, document.feasible ? 'Changes' : 'Changes that meet all but the contradicting requirements'), h('span', { class: 'space' }),
          h('button', { class: 'main', onclick: () => this.machine.apply(found.changes) }, 'Apply')),
        h('table', {}, h('thead', {}, h('tr', {}, ['parameter', 'from', 'to'].map((text, k) => h('th', { class: k ? 'num' : '' }, text)))),
          h('tbody', {}, document.changes.map((row) => [h('tr', {}, h('td', {}, h('button', { class: 'chip', onclick: () => this.machine.reveal(row.key) }, broken(row.key))), h('td', { class: 'num', title: row.from }, rounded(row.from)), h('td', { class: 'num now', title: row.to }, rounded(row.to))), h('tr', { class: 'why' }, h('td', { class: 'dim', colSpan: 3 }, row.reason))])))) : null,
      alone.length ? h('div', { class: 'card' }, h('h3', {}, 'Out of reach whatever changes'), h('ul', {}, alone.map((name) => h('li', {}, name)))) : null,
      sets.length ? h('div', { class: 'card' }, h('h3', {}, 'Contradicting requirements'), h('ul', {}, sets.map((names) => h('li', {}, names.join(' · '))))) : null,
      found.fronts.map(() => h('figure', { class: 'front' }, h('figcaption', { class: 'dim' }, 'Margins of the designs evaluated, and their front. Both requirements hold in the upper right, beyond the lines of zero margin. ', h('span', {}, dot(INKS()[0]), 'present design'), ' ', h('span', {}, dot(INKS()[2]), 'with the changes')), h('div', { class: 'plot' }))),
      document.relax?.length ? h('div', { class: 'card' }, h('h3', {}, 'What to relax'), h('table', {},
        h('thead', {}, h('tr', {}, ['requirement', 'limit', 'reached'].map((text, k) => h('th', { class: k ? 'num' : '' }, text)))),
        h('tbody', {}, document.relax.map((row) => h('tr', {}, h('td', {}, row.check, row.keeping.length ? h('span', { class: 'dim' }, ` with ${row.keeping.join('; ')}`) : null), h('td', { class: 'num' }, quantity(row.limit)), h('td', { class: 'num' }, quantity(row.needed))))))) : null,
      margins.length ? h('div', { class: 'card' }, h('h3', {}, 'Margins that change'), h('table', {},
        h('thead', {}, h('tr', {}, ['check', 'before', 'after'].map((text, k) => h('th', { class: k ? 'num' : '' }, text)))),
        h('tbody', {}, margins.map((row) => h('tr', {}, h('td', {}, row.check), h('td', { class: 'num' }, percent(row.before.margin)), h('td', { class: `num ${row.after.verdict === 'passes' ? 'good' : 'bad'}` }, percent(row.after.margin))))))) : null);
    this.drawFronts(found.fronts, document.margins ?? []);
    this.showAge();
  }

  drawFronts(fronts, margins) {
    const places = this.result.querySelectorAll('.front .plot');
    fronts.forEach(({ names, points, front }, k) => {
      const inks = INKS();
      const [x, y] = points.map((values) => values.map(squeezed));
      // As much of the names as the axes have room for.
      const em = parseFloat(getComputedStyle(places[k]).fontSize);
      const short = (name, length) => { const most = Math.max(Math.floor(length / (0.55 * em)), 8); return name.length > most ? `${name.slice(0, most - 2)} …` : name; };
      const plot = new XyPlot(places[k], { x: short(names[0], places[k].clientWidth - 7 * em), y: short(names[1], places[k].clientHeight - 4 * em), title: names.join(' over '), tick: (v) => percent(stretched(v)), ticks: marginTicks, room: 6.6 });
      // On the page margins are squeezed; a file has them as they are.
      plot.columns = names.map((name, i) => [`${name} (margin)`, points[i]]);
      const ends = (values) => [Math.min(...values, -0.1), Math.max(...values, 0.1)];
      plot.marks = [['before', inks[0]], ['after', inks[2]]].flatMap(([when, ink]) => {
        const [a, b] = names.map((name) => margins.find((row) => row.check === name)?.[when]?.margin ?? null);
        return a === null || b === null ? [] : [{ x: squeezed(a), y: squeezed(b), ink }];
      });
      // The limits: where a margin is zero.
      plot.set([{ x: [0, 0], y: ends([...y, ...plot.marks.map((mark) => mark.y)]), ink: 'strong', width: 1.6 }, { x: ends([...x, ...plot.marks.map((mark) => mark.x)]), y: [0, 0], ink: 'strong', width: 1.6 },
        { x, y, ink: 'measured', label: 'designs', points: true, width: 3 },
        { x: front[0].map(squeezed), y: front[1].map(squeezed), ink: inks[3], label: 'front', width: 1.6 }, { x: front[0].map(squeezed), y: front[1].map(squeezed), ink: inks[3], points: true, width: 5 }]);
      places[k].title = names.join(' over ');
      this.plots.push(plot);
    });
  }
}

/** Margins are shown linearly up to 10 %, logarithmically beyond. */
const squeezed = (v) => Math.sign(v) * Math.log10(1 + Math.abs(v) / 0.1);
const stretched = (v) => Math.sign(v) * 0.1 * (10 ** Math.abs(v) - 1);
const MARGINS = [0, 0.1, 0.3, 1, 3, 10, 30, 100, 300, 1000, 3000].flatMap((v) => [v, -v]);

/** Ticks of a squeezed margin: 0, 10 %, 30 %, 100 % and so on, as many as there is room for. */
function marginTicks(low, high, count) {
  const values = [...new Set(MARGINS.map(squeezed))].filter((v) => v >= low && v <= high).sort((a, b) => a - b);
  const every = Math.ceil(values.length / Math.max(count, 3));
  const zero = Math.max(values.indexOf(0), 0);
  return { values: values.filter((_, k) => (k - zero) % every === 0), step: 1 };
}
/** A key that may be broken after each part of it. */
const broken = (key) => key.split(/(?<=[._])/).flatMap((part) => [part, h('wbr')]);
const dot = (ink) => { const s = swatch(ink); s.classList.add('dot'); return s; };
/** A value of a search with as many digits as one reads; the whole number is applied. */
const rounded = (text) => text.replace(/^-?\d+\.\d+(?=\s|$)/, (digits) => String(Number(Number(digits).toPrecision(5))));
const percent = (v) => (v === null || v === undefined ? '–' : `${v > 0 ? '+' : v < 0 ? '−' : ''}${Math.abs(100 * v) >= 1e4 ? Math.abs(100 * v).toExponential(0).replace('e+', 'e') : Number(Math.abs(100 * v).toPrecision(2))} %`);
