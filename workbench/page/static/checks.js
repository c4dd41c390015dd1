// The list of design checks with their margins as bars, and the selected one in full.
import { get } from './api.js';
import { h, fill, newest, quantity, words } from './dom.js';
import { toggle } from './parameters.js';

const VERDICTS = { fails: 'bad', passes: 'good', out_of_range: 'warn', undecidable: 'dim' };

/** Length of a margin's bar in [-1, 1]: linear up to 10 %, logarithmic beyond, full at a factor of a thousand. */
export function barLength(margin) {
  if (margin === null) return 0;
  const a = Math.abs(margin);
  return Math.sign(margin) * Math.min(1, Math.log10(1 + a / 0.1) / 4);
}

const marginText = ({ margin, shown_margin: shown }) =>
  (shown.endsWith('%') && Math.abs(margin) >= 100 ? `${margin < 0 ? '−' : '+'}${(100 * Math.abs(margin)).toExponential(1).replace('e+', 'e')} %` : shown.replace('-', '−'));

export class CheckList {
  /** @param {HTMLElement} place  @param {(key: string) => void} onparameter  an input of a check was chosen */
  constructor(place, onparameter) {
    this.onparameter = onparameter;
    this.rows = new Map();
    this.turn = newest();
    this.data = new Map();
    this.counts = h('span', { class: 'counts' }, '–');
    this.failing = h('button', { class: 'small', 'aria-pressed': 'false', onclick: () => { toggle(this.failing); this.arrange(); } }, 'failing');
    this.byMargin = h('button', { class: 'small', 'aria-pressed': 'false', title: 'Smallest margin first', onclick: () => { toggle(this.byMargin); this.arrange(); this.list.scrollTop = 0; } }, 'by margin');
    this.list = h('div', { class: 'scroll checks' });
    this.detail = h('div', { class: 'detail' }, h('p', { class: 'dim' }, 'Select a check for its formula, numbers and source.'));
    place.append(h('div', { class: 'head' }, h('h2', {}, 'Checks'), this.counts, h('span', { class: 'space' }), this.failing, this.byMargin), this.list, this.detail);
  }

  /** Rows evaluated now, the number of all checks, the positions out of date. */
  update({ checks, pending, count }) {
    let structure = false;
    for (const check of checks) {
      const known = this.data.get(check.position);
      structure ||= !known || known.name !== check.name;
      this.data.set(check.position, { ...check, was: known ? known.was : check.margin });
    }
    for (const position of [...this.data.keys()]) if (position >= count) { this.data.delete(position); structure = true; }
    if (structure) this.arrange(); else for (const check of checks) this.paint(check.position);
    const stale = new Set(pending);
    for (const [position, row] of this.rows) row.element.classList.toggle('stale', stale.has(position));
    const all = [...this.data.values()];
    const fails = all.filter((check) => check.verdict === 'fails').length;
    const passes = all.filter((check) => check.verdict === 'passes').length;
    const open = all.length - fails - passes;
    fill(this.counts, h('span', { class: fails ? 'bad' : 'dim' }, `${fails} fail`), ' · ', h('span', { class: 'good' }, `${passes} pass`), open ? [' · ', h('span', { class: 'warn' }, `${open} open`)] : '');
    if (this.selected !== undefined && checks.some((check) => check.position === this.selected)) this.showDetail();
  }

  /** Take the present margins as those that later ones are compared with. */
  rebase() { for (const check of this.data.values()) check.was = check.margin; for (const position of this.rows.keys()) this.paint(position); }

  arrange() {
    const failing = this.failing.getAttribute('aria-pressed') === 'true';
    const byMargin = this.byMargin.getAttribute('aria-pressed') === 'true';
    const shown = [...this.data.values()].filter((check) => !failing || check.verdict !== 'passes');
    shown.sort((a, b) => (byMargin ? (a.margin ?? -Infinity) - (b.margin ?? -Infinity) : a.position - b.position));
    this.rows.clear();
    let subject = null;
    fill(this.list, shown.map((check) => {
      const before = !byMargin && check.subject !== subject ? h('h3', {}, check.subject) : null;
      subject = check.subject;
      return [before, this.row(check)];
    }));
    for (const position of this.rows.keys()) this.paint(position);
  }

  row(check) {
    const mark = h('i', { class: 'mark' });
    const bar = h('i', { class: 'fill' });
    const was = h('i', { class: 'was' });
    const margin = h('span', { class: 'margin num' });
    const element = h('button', { class: 'check', onclick: () => this.select(check.position) },
      mark, h('span', { class: 'name', title: check.name }, check.name), h('span', { class: 'track' }, bar, was), margin);
    this.rows.set(check.position, { element, mark, bar, was, margin });
    return element;
  }

  paint(position) {
    const row = this.rows.get(position);
    const check = this.data.get(position);
    if (!row || !check) return;
    const now = barLength(check.margin);
    row.element.dataset.verdict = VERDICTS[check.verdict];
    row.element.classList.toggle('selected', this.selected === position);
    row.mark.textContent = { fails: '✕', passes: '✓', out_of_range: '!', undecidable: '?' }[check.verdict];
    row.mark.title = words(check.verdict);
    row.bar.style.left = `${50 + Math.min(now, 0) * 50}%`;
    row.bar.style.width = `${Math.abs(now) * 50}%`;
    const moved = check.was !== null && check.margin !== null && Math.abs(check.was - check.margin) > 1e-9;
    row.was.hidden = !moved;
    row.was.style.left = `${50 + barLength(check.was) * 50}%`;
    row.margin.textContent = marginText(check);
  }

  select(position) {
    const before = this.selected;
    this.selected = position;
    for (const one of [before, position]) this.paint(one);
    this.showDetail();
  }

  async showDetail() {
    const current = this.turn();
    const position = this.selected;
    const check = await get(`/api/machine/checks/${position}`).catch(() => null);
    if (!check || !current()) return;
    const row = this.data.get(position);
    fill(this.detail,
      h('div', { class: 'line' }, h('b', {}, check.name), h('span', { class: 'space' }), h('span', { class: VERDICTS[check.verdict] }, words(check.verdict))),
      h('p', {}, `${row.value}, ${row.limit}; margin ${marginText(row).replace(' ', '\u00a0')}`),
      check.proposal ? h('p', { class: 'warn' }, check.proposal) : null,
      check.note ? h('p', { class: 'dim' }, check.note) : null,
      check.formula ? h('p', { class: 'formula' }, check.formula) : null,
      check.substituted ? h('p', { class: 'formula dim' }, check.substituted) : null,
      h('p', { class: 'dim' }, check.source),
      h('div', { class: 'inputs' }, Object.entries(check.inputs).map(([key, input]) =>
        h('button', { class: 'chip', title: `${key} = ${quantity(input)}; ${input.origin}`, onclick: () => this.onparameter(key) }, key, h('span', { class: 'dim' }, ` ${quantity(input)}`)))));
    this.detail.scrollTop = 0;
  }
}
