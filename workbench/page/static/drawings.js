// Drawing sheets as SVG: a list of sheets, and one of them with zoom and shift.
import { get, post, result } from './api.js';
import { h, fill, newest, say, words } from './dom.js';

export class Drawings {
  /** @param {() => void} onopen  another sheet is shown */
  constructor(place, onopen = () => {}) {
    this.onopen = onopen;
    this.names = h('div', { class: 'sheets scroll' });
    this.paper = h('img', { class: 'paper', alt: '', draggable: 'false' });
    this.desk = h('div', { class: 'desk', tabindex: '0', role: 'group', 'aria-label': 'drawing; wheel zooms, dragging shifts, double click fits' }, this.paper);
    this.note = h('div', { class: 'sheet-note' }, 'Choose a sheet.');
    place.append(this.names, h('div', { class: 'desk-frame' }, this.desk, this.note));
    this.view = { x: 0, y: 0, scale: 1 };
    this.turn = { sheets: newest(), open: newest() };
    this.desk.addEventListener('wheel', (event) => {
      event.preventDefault();
      const box = this.desk.getBoundingClientRect();
      this.zoom(Math.exp(-event.deltaY * 0.0015), event.clientX - box.left, event.clientY - box.top);
    }, { passive: false });
    this.desk.addEventListener('pointerdown', (event) => { this.desk.setPointerCapture(event.pointerId); this.drag = [event.clientX - this.view.x, event.clientY - this.view.y]; });
    this.desk.addEventListener('pointermove', (event) => { if (this.drag) { this.view.x = event.clientX - this.drag[0]; this.view.y = event.clientY - this.drag[1]; this.place(); } });
    this.desk.addEventListener('pointerup', () => { this.drag = null; });
    this.desk.addEventListener('dblclick', () => this.fit());
    this.desk.addEventListener('keydown', (event) => {
      if ('+=-'.includes(event.key)) this.zoom(event.key === '-' ? 0.8 : 1.25, this.desk.clientWidth / 2, this.desk.clientHeight / 2);
      if (event.key === '0') this.fit();
    });
    this.paper.addEventListener('load', () => this.fit());
    new ResizeObserver(() => this.fit()).observe(this.desk);
  }

  async shown() {
    const current = this.turn.sheets();
    const sheets = await get('/api/machine/sheets');
    if (!current()) return;
    fill(this.names, Object.entries(sheets).flatMap(([subject, names]) => names.map((name) =>
      h('button', { class: 'sheet', dataset: { name }, onclick: () => this.open(subject, name) }, words(name)))));
    this.mark();
    // Something to look at: the first sheet, until another one is chosen.
    const every = Object.entries(sheets).flatMap(([subject, names]) => names.map((name) => [subject, name]));
    const wanted = every.find(([, name]) => name === this.wanted);
    if (this.wanted && !wanted) say(`${this.wanted}: no such sheet`, 'bad');
    this.wanted = null;
    const [subject, name] = wanted ?? every[0] ?? [];
    if (wanted || (!this.name && name)) this.open(subject, name);
  }

  mark() { for (const one of this.names.children) one.setAttribute('aria-pressed', String(one.dataset.name === this.name)); }

  async open(subject, name) {
    const current = this.turn.open();
    this.name = name;
    this.subject = subject;
    this.mark();
    this.onopen();
    fill(this.note, `drawing ${words(name)} …`);
    try {
      const found = await result(await post(`/api/machine/drawings/${subject}`));
      const sheet = found.sheets.find((one) => one.name === name) ?? found.sheets[0];
      if (!current()) return;
      this.paper.src = `/api/machine/artefacts/${sheet.key}/${sheet.name}.svg`;
      const file = (kind) => h('a', { href: `/api/machine/artefacts/${sheet.key}/${sheet.name}.${kind}`, ...(kind === 'dxf' ? { download: `${sheet.name}.dxf` } : { target: '_blank' }) }, kind.toUpperCase());
      fill(this.note, ['pdf', 'dxf', 'svg'].map(file), sheet.hits.length ? h('span', { class: 'bad' }, `${sheet.hits.length} lint hits`) : h('span', {}, 'no lint hits'),
        h('span', {}, words(sheet.name)), h('span', {}, sheet.paper), h('span', {}, sheet.scale), h('span', { class: 'views', title: sheet.views.join(', ') }, sheet.views.join(', ')));
    } catch (error) {
      if (!current()) return;
      if (error.name === 'Cancelled') fill(this.note, `${words(name)}: ${error.message}; choose the sheet again`);
      else { fill(this.note, h('span', { class: 'bad' }, error.message)); say(error.message, 'bad'); }
    }
  }

  /** The design changed: draw the open sheet again when it is looked at. */
  refresh() { if (this.name) this.open(this.subject, this.name); }

  fit() {
    const { naturalWidth: w, naturalHeight: h0 } = this.paper;
    if (!w || !this.desk.clientWidth) return;
    const scale = Math.min((this.desk.clientWidth - 24) / w, (this.desk.clientHeight - 24) / h0);
    this.view = { scale, x: (this.desk.clientWidth - w * scale) / 2, y: (this.desk.clientHeight - h0 * scale) / 2 };
    this.place();
  }

  zoom(factor, x, y) {
    const scale = Math.min(Math.max(this.view.scale * factor, 0.02), 60);
    const f = scale / this.view.scale;
    this.view = { scale, x: x - (x - this.view.x) * f, y: y - (y - this.view.y) * f };
    this.place();
  }

  place() {
    const { x, y, scale } = this.view;
    // The width, not a transform: the browser then draws the lines anew at each size.
    this.paper.style.width = `${this.paper.naturalWidth * scale}px`;
    this.paper.style.left = `${x}px`;
    this.paper.style.top = `${y}px`;
  }
}
