// The list of parameters: search, groups, a slider and a field for each value, and the selected one in full.
import { h, fill, number, words } from './dom.js';

/** Range of a slider: half to one and a half times the saved value, within the bounds of the key. */
export function sliderRange(p) {
  if (p.kind === 'count') return { low: p.low ?? 1, high: Math.min(p.high ?? 100, Math.max(3 * p.number, 6)), step: 1 };
  const [a, b] = p.number === 0 ? [0, 1] : [0.5 * p.number, 1.5 * p.number].sort((x, y) => x - y);
  const low = Math.max(a, p.low ?? -Infinity);
  const high = Math.min(b, p.high ?? Infinity);
  // Round steps: two hundred or a little more over the range.
  const raw = (high - low) / 200;
  const decade = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5].map((k) => k * decade).reverse().find((s) => s <= raw * 1.0001) ?? decade;
  return { low: Math.ceil(low / step - 1e-9) * step, high: Math.floor(high / step + 1e-9) * step, step };
}

/** Text of a value: `12.5 mm`, with no more digits than the step has. */
export const valueText = (p, value, step) => {
  const decimals = Math.max(0, Math.ceil(-Math.log10(step) - 1e-9));
  const rounded = p.kind === 'count' ? String(Math.round(value)) : decimals > 12 ? String(value) : String(Number(value.toFixed(decimals)));
  return p.unit ? `${rounded} ${p.unit}` : rounded;
};

/** A number without a unit takes the unit that stands in its field. */
export const inUnit = (text, present, p) => {
  if (!p.unit || !/^[-+]?[\d.]+(e[-+]?\d+)?$/i.test(text)) return text;
  return `${text} ${present.startsWith('=') ? p.unit : present.match(/[A-Za-zµ°%]\S*$/)?.[0] ?? p.unit}`;
};

const BOUND = 1e300;
const rangeText = (p) => {
  if (p.allowed.length) return p.allowed.map(words).join(', ');
  const low = p.low !== null && p.low > -BOUND ? `${p.closed ? '≥' : '>'} ${number(p.low)}` : '';
  const high = p.high !== null && p.high < BOUND ? `≤ ${number(p.high)}` : '';
  return [low, high].filter(Boolean).join(' and ') + (low || high ? ` ${p.unit}` : 'any');
};

export class ParameterList {
  /**
   * @param {HTMLElement} place
   * @param {{drag: (key: string, text: string) => void, commit: (key: string, text: string|null) => void}} on
   */
  constructor(place, on) {
    this.on = on;
    this.rows = new Map();
    this.search = h('input', { type: 'search', placeholder: 'Search parameters  ( / )', 'aria-label': 'search parameters', oninput: () => this.filter() });
    this.onlyChanged = h('button', { class: 'small', 'aria-pressed': 'false', title: 'Only what differs from the saved file', onclick: () => { toggle(this.onlyChanged); this.filter(); } }, 'changed');
    this.list = h('div', { class: 'scroll parameters' });
    this.detail = h('div', { class: 'detail' }, h('p', { class: 'dim' }, 'Select a parameter for its meaning, range and origin.'));
    this.keys = null;
    place.append(h('div', { class: 'head' }, this.search, this.onlyChanged), this.list, this.detail);
  }

  load(parameters) {
    this.parameters = new Map(parameters.map((p) => [p.key, p]));
    this.rows.clear();
    const groups = new Map();
    for (const p of parameters) {
      const table = p.key.slice(0, p.key.lastIndexOf('.'));
      groups.set(table, [...(groups.get(table) ?? []), p]);
    }
    fill(this.list, [...groups].map(([table, members]) => {
      const body = h('div', { class: 'rows' });
      const group = h('details', { dataset: { table }, ontoggle: () => { if (group.open) this.make(body, members); } },
        h('summary', {}, h('span', {}, words(table).replaceAll('.', ' · ')), h('span', { class: 'count dim' }, String(members.length))), body);
      return group;
    }));
    this.groups = groups;
    this.openGroup('stage');
    this.filter();
  }

  openGroup(table) {
    const group = this.list.querySelector(`details[data-table="${CSS.escape(table)}"]`);
    if (group && !group.open) { group.open = true; this.make(group.lastChild, this.groups.get(table)); }
    return group;
  }

  make(body, members) {
    if (body.childElementCount) return;
    body.append(...members.map((p) => this.row(p)));
    this.show(this.texts ?? {}, this.changes ?? {});
  }

  row(p) {
    const name = p.key.slice(p.key.lastIndexOf('.') + 1);
    const label = h('span', { class: 'name', title: p.meaning }, words(name));
    const row = h('div', { class: 'row', dataset: { key: p.key }, onfocusin: () => this.select(p.key), onclick: () => this.select(p.key) }, label);
    if (p.allowed.length || p.kind === 'switch') {
      const choice = h('select', { 'aria-label': p.key, onchange: () => this.on.commit(p.key, choice.value) },
        (p.allowed.length ? p.allowed : ['true', 'false']).map((value) => h('option', { value }, words(value))));
      choice.value = p.text;
      row.append(choice);
      row.classList.add('wide');
      this.rows.set(p.key, { p, row, field: choice });
      return row;
    }
    const field = h('input', { type: 'text', value: p.text, spellcheck: 'false', 'aria-label': p.key });
    const settle = () => {
      const text = inUnit(field.value.trim(), this.texts?.[p.key] ?? p.text, p);
      if (text !== (this.texts?.[p.key] ?? p.text)) this.on.commit(p.key, text); else field.value = text;
    };
    field.addEventListener('change', settle);
    field.addEventListener('keydown', (event) => { if (event.key === 'Escape') { field.value = this.texts?.[p.key] ?? p.text; field.blur(); } });
    let slider = null;
    if (p.number !== null) {
      const range = sliderRange(p);
      slider = h('input', { type: 'range', 'aria-label': `${p.key}, slider`, tabindex: '-1' });
      Object.assign(slider, { min: range.low, max: range.high, step: range.step, value: p.number });
      const position = () => valueText(p, slider.valueAsNumber, range.step);
      slider.addEventListener('input', () => { field.value = position(); this.on.drag(p.key, field.value); });
      slider.addEventListener('change', () => this.on.commit(p.key, position()));
      slider.addEventListener('dblclick', () => this.on.commit(p.key, null));
      // A key that is held is one change, as a slider that is dragged.
      let held = false;
      const release = () => { if (held) { held = false; this.on.commit(p.key, field.value); } };
      field.addEventListener('keydown', (event) => {
        const sign = { ArrowUp: 1, ArrowDown: -1 }[event.key];
        if (!sign) return;
        event.preventDefault();
        const now = Number.parseFloat(field.value);
        if (!Number.isFinite(now)) return;
        held = true;
        field.value = valueText(p, now + sign * range.step * (event.shiftKey ? 10 : 2), range.step);
        this.on.drag(p.key, field.value);
      });
      field.addEventListener('keyup', (event) => { if (event.key.startsWith('Arrow')) release(); });
      field.addEventListener('blur', release);
      row.append(slider, field);
    } else {
      row.classList.add('wide');
      row.append(field);
    }
    this.rows.set(p.key, { p, row, field, slider });
    return row;
  }

  /**
   * Texts by key that differ from the saved file (set or computed), and the keys that were set. The value of the key
   * that is being dragged stays: the texts may be those of an earlier position of its slider.
   */
  show(texts, changes, held = null) {
    this.texts = texts;
    this.changes = changes;
    for (const [key, { p, row, field, slider }] of this.rows) {
      const text = texts[key] ?? p.text;
      if (key !== held) {
        if (document.activeElement !== field || field.tagName === 'SELECT') field.value = text;
        if (slider) slider.value = Number.parseFloat(text);
      }
      row.classList.toggle('set', key in changes);
      row.classList.toggle('computed', key in texts && !(key in changes));
    }
    if (this.selected) this.showDetail();
    if (this.onlyChanged.getAttribute('aria-pressed') === 'true') this.filter();
  }

  /**
   * The keys that are set are others: their texts are known before the server answers with all texts and margins. The
   * value of the key that is being dragged stays.
   */
  take(changes, held = null) {
    const before = this.changes ?? {};
    this.texts = { ...this.texts };
    this.changes = changes;
    for (const key of new Set([...Object.keys(before), ...Object.keys(changes)])) {
      if (before[key] === changes[key]) continue;
      if (key in changes) this.texts[key] = changes[key]; else delete this.texts[key];
      if (key !== held) this.write(key, this.texts[key] ?? this.parameters.get(key)?.text ?? '');
    }
  }

  /** Write the text of a value that was committed, also into the field that has the focus. */
  write(key, text) {
    const row = this.rows.get(key);
    if (!row) return;
    row.field.value = text;
    if (row.slider) row.slider.value = Number.parseFloat(text);
  }

  /** Show only these keys (those a part or a check reads); null: all. */
  only(keys, title = '') {
    this.keys = keys ? new Set(keys) : null;
    this.onlyTitle = title;
    this.filter();
  }

  filter() {
    const wanted = this.search.value.trim().toLowerCase().replaceAll(' ', '_').split('_').filter(Boolean);
    const changed = this.onlyChanged.getAttribute('aria-pressed') === 'true';
    const narrow = wanted.length > 0 || changed || this.keys !== null;
    const match = (p) => (!changed || p.key in (this.texts ?? {})) && (!this.keys || this.keys.has(p.key))
      && wanted.every((word) => `${p.key} ${p.meaning.replaceAll(' ', '_')}`.toLowerCase().includes(word));
    for (const group of this.list.querySelectorAll('details')) {
      const members = this.groups.get(group.dataset.table).filter(match);
      group.hidden = members.length === 0;
      group.querySelector('.count').textContent = String(members.length);
      if (narrow && members.length && !group.open) this.openGroup(group.dataset.table);
      const shown = new Set(members.map((p) => p.key));
      for (const row of group.lastChild.children) row.hidden = !shown.has(row.dataset.key);
    }
    this.list.querySelector('.only')?.remove();
    if (this.keys) {
      this.list.prepend(h('div', { class: 'only' }, h('span', {}, this.onlyTitle),
        h('button', { class: 'icon', title: 'Show all parameters', 'aria-label': 'show all parameters', onclick: () => this.only(null) }, '×')));
    }
  }

  select(key) {
    if (this.selected === key) return;
    this.selected = key;
    for (const { row } of this.rows.values()) row.classList.toggle('selected', row.dataset.key === key);
    this.showDetail();
  }

  /** Open the group of a key and bring its row into view. */
  reveal(key) {
    if (!this.parameters.has(key)) return;
    if (this.keys && !this.keys.has(key)) this.only(null);
    this.search.value = '';
    this.filter();
    this.openGroup(key.slice(0, key.lastIndexOf('.')));
    this.select(key);
    this.rows.get(key)?.row.scrollIntoView({ block: 'center' });
    this.rows.get(key)?.field.focus();
  }

  showDetail() {
    const p = this.parameters.get(this.selected);
    if (!p) return;
    const text = this.texts?.[p.key];
    fill(this.detail,
      h('div', { class: 'line' }, h('b', {}, p.key), h('span', { class: 'space' }),
        h('button', { class: 'small', disabled: !(p.key in (this.changes ?? {})), onclick: () => this.on.commit(p.key, null) }, 'reset')),
      h('p', {}, p.meaning || words(p.key)),
      h('dl', {},
        h('dt', {}, 'saved'), h('dd', {}, text !== undefined && text !== p.text ? `${p.text}, now ${text}` : p.text),
        h('dt', {}, 'allowed'), h('dd', {}, rangeText(p)),
        h('dt', {}, 'tolerance'), h('dd', {}, p.tolerance ?? '–'),
        h('dt', {}, 'origin'), h('dd', { title: p.origin }, p.origin)));
  }
}

export function toggle(button) {
  const on = button.getAttribute('aria-pressed') !== 'true';
  button.setAttribute('aria-pressed', String(on));
  return on;
}
