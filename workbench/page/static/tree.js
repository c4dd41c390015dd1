// The tree of parts: what the machine is made of, each part shown or hidden, found in the view, and saved as a file.
import { fill, h, words } from './dom.js';

const KEPT = 'tree';
const MANY = 12;

export class PartTree {
  /** @param {import('./view3d.js').View3d} view */
  constructor(view) {
    this.view = view;
    this.filter = h('input', { type: 'search', placeholder: 'Search parts', 'aria-label': 'search parts', oninput: () => this.narrow() });
    this.list = h('ul');
    this.element = h('div', { class: 'tree scroll', hidden: (localStorage.getItem(KEPT) ?? (innerWidth < 1440 ? 'closed' : 'open')) === 'closed', tabindex: '0', role: 'region', 'aria-label': 'tree of parts', onpointerleave: () => view.hover(null) });
    this.button = h('button', { class: 'small', 'aria-pressed': String(!this.element.hidden), title: 'Tree of parts (P)', onclick: () => this.toggle() }, 'Parts');
  }

  toggle() {
    this.element.hidden = !this.element.hidden;
    this.button.setAttribute('aria-pressed', String(!this.element.hidden));
    localStorage.setItem(KEPT, this.element.hidden ? 'closed' : 'open');
    this.makeRoom();
  }

  /** The machine stands beside the tree, where there is room for both. */
  makeRoom() {
    const { offsetLeft, offsetWidth, parentElement } = this.element;
    this.view.keepFree(offsetWidth && parentElement.clientWidth > 2 * offsetWidth ? offsetLeft + offsetWidth : 0);
  }

  /** The parts of a result of the job `solids`. */
  show({ parts, instances }) {
    const counts = new Map();
    for (const { part } of instances) counts.set(part, (counts.get(part) ?? 0) + 1);
    this.rows = new Map([...counts].map(([name, count]) => [name, this.row(name, count, parts[name])]));
    fill(this.list, [...this.rows.values()].map(({ element }) => element));
    fill(this.element, h('div', { class: 'tree-head' }, h('b', {}, 'machine'), h('span', { class: 'dim' }, `${counts.size} parts`), h('button', { class: 'small', title: 'Show all parts', onclick: () => this.view.showOnly(null) }, 'All')),
      counts.size > MANY ? this.filter : null, this.list);
    this.mark();
    this.narrow();
    this.makeRoom();
  }

  row(name, count, part) {
    const { view } = this;
    const eye = h('input', { type: 'checkbox', 'aria-label': `show ${words(name)}`, title: 'Shown', onchange: () => view.hide(name) });
    const choose = h('button', { class: 'part-name', title: `${part.description ?? words(name)}; a double click shows it alone`, onclick: () => view.select(view.selected === name ? null : name), ondblclick: () => view.showOnly(name), onfocus: () => view.hover(name), onblur: () => view.hover(null) },
      words(name), count > 1 ? h('span', { class: 'dim' }, ` × ${count}`) : null);
    const file = (kind) => h('a', { class: 'report', href: `/api/machine/artefacts/${part.key}/${name}.${kind}`, download: `${name}.${kind}`, title: `${words(name)} as ${kind.toUpperCase()}` }, kind.toUpperCase());
    const element = h('li', { onpointerenter: () => view.hover(name) }, eye, choose, file('step'), file('stl'));
    return { element, eye, choose };
  }

  /** What is selected, hidden and under the pointer. */
  mark() {
    for (const [name, { element, eye, choose }] of this.rows ?? []) {
      eye.checked = !this.view.hidden.has(name);
      choose.setAttribute('aria-pressed', String(this.view.selected === name));
      element.classList.toggle('hovered', this.view.hovered === name);
    }
  }

  narrow() {
    const wanted = this.filter.value.trim().toLowerCase();
    for (const [name, { element }] of this.rows ?? []) element.hidden = !words(name).toLowerCase().includes(wanted);
  }
}
