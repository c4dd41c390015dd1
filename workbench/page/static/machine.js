// The machine: parameters on the left, solids or drawings in the middle, checks on the right.
import { get, post, result } from './api.js';
import { movablePanels } from './borders.js';
import { CheckList } from './checks.js';
import { h, fill, newest, quantity, say, setAddress, withdraw, words } from './dom.js';
import { Drawings } from './drawings.js';
import { ParameterList, sliderRange, toggle, valueText } from './parameters.js';
import { PartTree } from './tree.js';
import { View3d } from './view3d.js';

const QUICK = 0.025;
const SOLIDS_AFTER = 120;

class Machine {
  constructor(section) {
    this.section = section;
    this.changes = {};
    this.newest = { solids: newest(), difference: newest() };
    const left = h('div', { class: 'panel' });
    const middle = h('div', { class: 'panel middle' });
    const right = h('div', { class: 'panel' });
    fill(section, left, middle, right);
    this.parameters = new ParameterList(left, { drag: (key, text) => this.drag(key, text), commit: (key, text) => this.commit(key, text) });
    this.checks = new CheckList(right, (key) => this.parameters.reveal(key));
    this.makeMiddle(middle);
    movablePanels('machine', left, right);
    addEventListener('keydown', (event) => this.key(event));
    // Another server may have begun: its versions of the checks are not those of the former one.
    addEventListener('reconnected', () => this.inTurn(async () => { this.version = 0; this.take(await get('/api/machine')); this.changed(); }).catch((error) => say(error.message, 'bad')));
  }

  makeMiddle(middle) {
    this.file = h('select', { title: 'Parameter file', 'aria-label': 'parameter file', onchange: () => this.openFile() });
    this.undo = h('button', { class: 'small', title: 'Undo (Ctrl Z)', 'aria-label': 'Undo', onclick: () => this.step('undo') }, '↶');
    this.redo = h('button', { class: 'small', title: 'Redo (Ctrl Shift Z)', 'aria-label': 'Redo', onclick: () => this.step('redo') }, '↷');
    this.save = h('button', { class: 'small', onclick: () => this.saveAs() }, 'Save as …');
    this.tabs = Object.fromEntries([['solids', 'Solids'], ['drawings', 'Drawings'], ['difference', 'Difference'], ['optimize', 'Optimize']].map(([name, title]) =>
      [name, h('button', { class: 'small', 'aria-pressed': 'false', onclick: () => this.showTab(name) }, title)]));
    this.panes = {
      solids: h('div', { class: 'pane solids' }), drawings: h('div', { class: 'pane drawings' }), difference: h('div', { class: 'pane difference scroll' }), optimize: h('div', { class: 'pane' }),
    };
    this.makeSolids(this.panes.solids);
    this.drawings = new Drawings(this.panes.drawings, () => this.link());
    this.violations = h('div', { class: 'violations', role: 'alert', hidden: true });
    middle.append(
      h('div', { class: 'head' }, h('span', { class: 'group' }, Object.values(this.tabs)), h('span', { class: 'space' }), this.file, this.undo, this.redo, this.save),
      this.place = h('div', { class: 'panes' }, Object.values(this.panes), this.violations));
  }

  makeSolids(pane) {
    const place = h('div', { class: 'canvas' });
    this.view = new View3d(place, (name) => this.showPart(name), () => this.tree.mark());
    this.tree = new PartTree(this.view);
    const look = (name, title, key) => h('button', { class: 'small', title: `${title} (${key})`, onclick: () => this.view.look(name) }, title);
    this.explosion = h('input', { type: 'range', min: 0, max: 1, step: 0.01, value: 0, 'aria-label': 'exploded view', oninput: () => this.pull() });
    this.axis = h('select', { class: 'small', 'aria-label': 'section', onchange: () => this.cut() },
      [['', 'no section'], ['x', 'section x'], ['y', 'section y'], ['z', 'section z']].map(([value, text]) => h('option', { value }, text)));
    this.share = h('input', { type: 'range', min: 0, max: 1, step: 0.002, value: 0.5, disabled: true, 'aria-label': 'position of the section', oninput: () => this.cut() });
    this.at = h('span', { class: 'at dim' });
    this.measure = h('button', { class: 'small', 'aria-pressed': 'false', title: 'Distance between two points (M)', onclick: () => this.view.setMeasuring(toggle(this.measure)) }, 'Measure');
    this.part = h('div', { class: 'part-card', hidden: true });
    this.building = h('div', { class: 'building', hidden: true });
    pane.append(place,
      h('div', { class: 'toolbar top' },
        h('span', { class: 'group' }, look('front', 'Front', '1'), look('right', 'Right', '2'), look('top', 'Top', '3'), look('oblique', 'Oblique', '4'), look('', 'Fit', 'F')),
        h('span', { class: 'space' }), this.tree.button, this.measure),
      h('div', { class: 'toolbar bottom' },
        h('label', { title: 'Exploded view (E)' }, 'explode', this.explosion), h('span', { class: 'space' }), this.at, this.share, this.axis),
      this.tree.element, this.part, this.building);
  }

  async start() {
    const [state, parameters] = await Promise.all([get('/api/machine'), get('/api/machine/parameters')]);
    this.parameters.load(parameters);
    this.take(state);
    // A tab that was chosen while the page was loading stays.
    this.showTab(this.tab ?? 'solids');
    this.preview();
    this.buildSolids();
  }

  /** `#machine/TAB`, `#machine/drawings/SHEET`, `#machine/solids?part=NAME`. */
  async shown([tab, sheet], { part } = {}) {
    this.view.resize();
    if (part) this.wantedPart = part;
    this.choosePart();
    if (tab && !(tab in this.tabs)) say(`${tab}: no such view of the machine`, 'bad');
    if (tab === 'drawings' && sheet) this.drawings.wanted = sheet;
    if (tab in this.tabs && (tab !== this.tab || sheet)) this.showTab(tab); else this.link();
  }

  /** Select the part that the address names, once it is there. */
  choosePart() {
    if (!this.wantedPart || !this.view.instances.length) return;
    if (this.view.result.parts[this.wantedPart]) this.view.select(this.wantedPart); else say(`${this.wantedPart}: no such part`, 'bad');
    this.wantedPart = null;
  }

  /** The address names what is shown, so that it can be kept or sent. */
  link() {
    if (this.wantedPart) return;
    const sheet = this.tab === 'drawings' ? this.drawings.name : null;
    setAddress(this.section, [this.tab ?? 'solids', ...(sheet ? [sheet] : [])], { part: this.tab === 'solids' ? this.view.selected : null });
  }

  /** Take the state of the server: file, changes, history. */
  take(state) {
    this.state = state;
    this.changes = state.changes;
    this.parameters.take(state.changes, this.held);
    const files = [...new Set([null, ...state.files, state.file])];
    fill(this.file, files.map((name) => h('option', { value: name ?? '' }, name ?? 'packaged design')));
    this.file.value = state.file ?? '';
    this.undo.disabled = state.undo === 0;
    this.redo.disabled = state.redo === 0;
    const count = Object.keys(state.changes).length;
    this.tabs.difference.textContent = count ? `Difference (${count})` : 'Difference';
    this.optimize?.showAge();
  }

  /** Key of the slider that is dragged, or whose value the server has not confirmed; null: none. */
  get held() { return this.dragged ? this.draggedKey : null; }

  drag(key, text) {
    if (!this.dragged) this.checks.rebase();
    this.dragged = { ...this.changes, [key]: text };
    this.draggedKey = key;
    this.preview();
  }

  /** Changes reach the server one after another, in the order they were made. */
  inTurn(change) {
    this.turn = (this.turn ?? Promise.resolve()).then(change, change);
    return this.turn;
  }

  commit(key, text) {
    const { dragged } = this;
    return this.inTurn(() => this.commitNow(key, text, dragged));
  }

  /** Refused where another window changed the design since; the page then shows what is there now. */
  async post(which, body = {}) {
    try {
      return await post(`/api/machine/${which}`, { ...body, seen: this.state.digest });
    } catch (error) {
      const there = error.answer?.state;
      if (there) {
        const { file } = this.state;
        this.take(there);
        if (there.file === file) this.changed(); else await this.readParameters();
      }
      throw error;
    }
  }

  /** @param {object|null} dragged  the values that were dragged when the slider was released */
  async commitNow(key, text, dragged) {
    if (!dragged) this.checks.rebase();
    const changes = { ...this.changes };
    if (text === null) delete changes[key]; else changes[key] = text;
    let state = null;
    try { state = await this.post('commit', { changes }); } catch (error) { say(error.message, 'bad'); }
    // A slider that is dragged again by now keeps its value.
    if (this.dragged === dragged) this.dragged = null;
    if (state) { this.take(state); say(''); }
    if (this.held !== key) this.parameters.write(key, this.changes[key] ?? this.parameters.parameters.get(key).text);
    if (state) this.changed(); else this.preview();
  }

  step(which) { return this.inTurn(() => this.stepNow(which)); }

  async stepNow(which) {
    this.checks.rebase();
    let state;
    try { state = await this.post(which); } catch (error) { say(error.message, 'bad'); return; }
    // A slider that came back to where it was dragged from makes no commit.
    this.dragged = null;
    this.take(state);
    say(which === 'undo' ? 'undone' : 'done again');
    this.changed();
  }

  /** The committed design changed: checks in full, solids soon. */
  changed() {
    this.preview();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.buildSolids(), SOLIDS_AFTER);
    if (this.tab === 'difference') this.showDifference();
    if (this.tab === 'drawings') this.drawings.shown().then(() => this.drawings.refresh()).catch((error) => say(error.message, 'bad'));
  }

  /** Margins of the present values: one request at a time, the last values always. */
  async preview() {
    if (this.asking) { this.again = true; return; }
    this.asking = true;
    let limit = QUICK;
    do {
      this.again = false;
      try {
        const changes = this.dragged ?? this.changes;
        const found = await post('/api/machine/preview', { changes, limit, since: this.version ?? 0 });
        this.version = found.version;
        this.checks.update(found);
        // An answer for values that were replaced since says nothing of the present texts; the next one does.
        if (this.dragged || changes === this.changes) this.parameters.show(found.changed, changes, this.held);
        this.showViolations(found.violations);
        if (this.failure) { withdraw(this.failure); this.failure = null; }
        // What took too long for one answer comes with the next, unless the value has moved on.
        limit = found.pending.length && !this.again ? 0.25 : QUICK;
        if (found.pending.length) this.again = true;
      } catch (error) {
        // Neither does an error: it would replace the message on the newer change.
        if (this.again) continue;
        this.failure = error.message;
        say(error.message, 'bad');
      }
    } while (this.again);
    this.asking = false;
  }

  showViolations(violations) {
    this.violated = violations.length > 0;
    fill(this.violations, violations.length ? [
      h('b', {}, violations.length === 1 ? 'cannot be built: a rule is violated' : `cannot be built: ${violations.length} rules are violated`),
      h('ul', {}, violations.map((one) => h('li', { title: one.rule }, one.message)))] : '');
    this.violations.hidden = !violations.length;
    if (violations.length) this.building.hidden = true;
  }

  async buildSolids() {
    const current = this.newest.solids();
    if (this.violated && this.view.instances.length) { this.fresh(false, 'solids of the last design that can be built'); return; }
    try {
      this.fresh(false, 'making solids …');
      const job = await post('/api/machine/solids');
      const found = await result(job);
      if (!current() || !await this.view.show(found) || !current()) return;
      this.tree.show(found);
      this.showPart(this.view.selected);
      this.choosePart();
      this.fresh(true, '');
      await post(`/api/machine/masses/${job.number}`);
      await this.preview();
      // The first margins were those of estimated masses: no change to be shown.
      if (!this.weighed) { this.weighed = true; this.checks.rebase(); }
    } catch (error) {
      if (!current()) return;
      if (error.name === 'Cancelled') { this.fresh(false, `${error.message}; the next change makes the solids again`); return; }
      this.fresh(false, error.message);
      // A design that cannot be built: the saved one is better than nothing to look at.
      if (!this.view.instances.length && Object.keys(this.changes).length) {
        const found = await post('/api/machine/solids', { saved: true }).then(result).catch(() => null);
        if (found && current() && await this.view.show(found)) { this.tree.show(found); this.fresh(false, 'solids of the saved design'); }
      }
    }
  }

  fresh(done, text) {
    this.building.hidden = done || this.violated;
    this.building.textContent = text;
    this.view.canvas.dataset.state = done ? 'current' : 'old';
  }

  /** Pull the parts from each other, all of them in view. */
  pull() {
    this.view.explode(this.explosion.valueAsNumber);
    this.view.look('');
  }

  cut() {
    const axis = this.axis.value || null;
    this.share.disabled = !axis;
    const at = this.view.section(axis, this.share.valueAsNumber);
    this.at.textContent = axis ? `${axis} = ${at.toFixed(1)} mm` : '';
  }

  showPart(name) {
    this.link();
    this.part.hidden = !name;
    const found = this.view.result?.parts[name];
    if (!name || !found) { this.part.hidden = true; return; }
    const [low, high] = found.bounding_box.value;
    const count = this.view.instances.filter((one) => one.part === name).length;
    fill(this.part,
      h('b', {}, words(name)), count > 1 ? h('span', { class: 'dim' }, `  ${count} of them`) : null,
      h('dl', {},
        h('dt', {}, 'mass'), h('dd', {}, quantity(found.mass)),
        h('dt', {}, 'size'), h('dd', {}, `${low.map((v, k) => ((high[k] - v) * 1000).toFixed(1)).join(' × ')} mm`),
        h('dt', {}, 'volume'), h('dd', {}, `${(found.volume.value * 1e6).toPrecision(4)} cm³`),
        h('dt', {}, 'material'), h('dd', {}, words(found.material))),
      h('div', { class: 'actions' },
        h('button', { class: 'small', onclick: () => this.parameters.only(found.reads, `read by ${words(name)}`) }, `${found.reads.length} parameters`),
        ['step', 'stl'].map((kind) => h('a', { class: 'report', href: `/api/machine/artefacts/${found.key}/${name}.${kind}`, download: `${name}.${kind}` }, kind.toUpperCase())),
        h('button', { class: 'small', onclick: () => this.view.hide(name) }, this.view.hidden.has(name) ? 'show' : 'hide')));
  }

  showTab(name) {
    this.tab = name;
    if (!this.state) return;
    this.place.dataset.tab = name;
    for (const [one, button] of Object.entries(this.tabs)) button.setAttribute('aria-pressed', String(one === name));
    for (const [one, pane] of Object.entries(this.panes)) pane.hidden = one !== name;
    if (name === 'solids') this.view.resize();
    if (name === 'drawings') this.drawings.shown().catch((error) => say(error.message, 'bad'));
    if (name === 'difference') this.showDifference();
    if (name === 'optimize') this.showOptimize().catch((error) => say(error.message, 'bad'));
    this.link();
  }

  async showOptimize() {
    const { Optimize } = await import('./optimize.js');
    this.optimize ??= new Optimize(this.panes.optimize, {
      apply: (changes) => this.applyChanges(changes), digest: () => this.state.digest, reveal: (key) => this.parameters.reveal(key), selected: () => this.parameters.selected, range: (key) => this.rangeOf(key),
    });
    await this.optimize.shown();
  }

  /** Several changes as one step that can be undone. */
  applyChanges(changes) {
    return this.inTurn(async () => {
      this.checks.rebase();
      try {
        const state = await this.post('commit', { changes: { ...this.changes, ...changes } });
        this.dragged = null;
        this.take(state);
        say(`changed: ${Object.keys(changes).join(', ')}; Undo takes them back`, 'good');
        this.changed();
      } catch (error) { say(error.message, 'bad'); }
    });
  }

  /** Range of a parameter for a search: that of its slider, or its choices. */
  rangeOf(key) {
    const p = this.parameters.parameters.get(key);
    if (p.allowed.length || p.number === null) return (p.allowed.length ? p.allowed : ['true', 'false']).join('|');
    const { low, high, step } = sliderRange(p);
    return `${valueText(p, low, step)}:${valueText(p, high, step)}`;
  }

  async showDifference(other = this.other ?? '') {
    this.other = other;
    const current = this.newest.difference();
    const query = other ? `?other=${encodeURIComponent(other)}` : '';
    const rows = await get(`/api/machine/differences${query}`);
    if (!current()) return;
    const choice = h('select', { 'aria-label': 'compare with', onchange: () => this.showDifference(choice.value) },
      h('option', { value: '' }, `saved: ${this.state.file ?? 'packaged design'}`), this.state.files.map((name) => h('option', { value: name }, name)));
    choice.value = other;
    fill(this.panes.difference, h('div', { class: 'card' }, h('h2', {}, 'Difference to ', choice),
      rows.length ? h('table', { class: 'differences' },
        h('thead', {}, h('tr', {}, ['parameter', 'before', 'now', 'origin before', ''].map((text) => h('th', {}, text)))),
        h('tbody', {}, rows.map(({ key, before, after }) => h('tr', {},
          h('td', {}, h('button', { class: 'chip', onclick: () => this.parameters.reveal(key) }, key)),
          h('td', {}, before?.text ?? 'absent'), h('td', { class: 'now' }, after?.text ?? 'absent'), h('td', { class: 'dim' }, before?.origin ?? ''),
          h('td', {}, key in this.changes ? h('button', { class: 'small', onclick: () => this.commit(key, null) }, 'reset') : h('span', { class: 'dim' }, 'computed'))))))
        : h('p', { class: 'dim' }, 'No parameter differs.')));
  }

  openFile() {
    const name = this.file.value || null;
    return this.inTurn(async () => {
      try {
        this.take(await this.post('open', { name }));
        await this.readParameters();
        if (this.optimize) await this.optimize.reset();
      } catch (error) {
        this.file.value = this.state.file ?? '';
        say(error.message, 'bad');
      }
    });
  }

  /** The saved file is another one. */
  async readParameters() {
    this.parameters.load(await get('/api/machine/parameters'));
    this.dragged = null;
    this.other = '';
    this.changed();
  }

  saveAs() {
    const name = h('input', { type: 'text', 'aria-label': 'name of the new file', placeholder: 'thicker_stage', spellcheck: 'false' });
    const problem = h('p', { class: 'bad' });
    const dialog = h('dialog', {}, h('h2', {}, 'Save as a new parameter file'),
      h('p', { class: 'dim' }, 'Comments and order of the file are kept; the changed values get the origin "assumed: changed in the workbench".'),
      h('form', { method: 'dialog', onsubmit: async (event) => {
        event.preventDefault();
        try {
          await this.inTurn(async () => {
            this.take(await this.post('save', { name: name.value }));
            await this.readParameters();
          });
          say(`saved as ${this.state.file}`, 'good');
          dialog.close();
        } catch (error) { problem.textContent = error.message; }
      } }, h('label', {}, name, ' .toml'), problem, h('div', { class: 'actions' }, h('button', { type: 'button', onclick: () => dialog.close() }, 'Cancel'), h('button', { class: 'main' }, 'Save'))));
    dialog.addEventListener('close', () => dialog.remove());
    document.body.append(dialog);
    dialog.showModal();
    name.focus();
  }

  key(event) {
    if (this.section.hidden || document.querySelector('dialog[open]')) return;
    if ((event.ctrlKey || event.metaKey) && event.key.toLowerCase() === 'z') {
      // While a text is being typed, the key is that of the field.
      if (event.target.matches?.('input[type="text"], input[type="search"]') && !event.target.closest('.parameters .row')) return;
      event.preventDefault();
      this.step(event.shiftKey ? 'redo' : 'undo');
      return;
    }
    if (event.target.closest?.('input, select, textarea') || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === '/') { event.preventDefault(); this.parameters.search.focus(); }
    if (this.tab !== 'solids') return;
    const view = { 1: 'front', 2: 'right', 3: 'top', 4: 'oblique', f: '' }[event.key.toLowerCase()];
    if (view !== undefined) this.view.look(view);
    if (event.key === 'e') { this.explosion.value = this.explosion.valueAsNumber > 0 ? 0 : 1; this.pull(); }
    if (event.key === 's') { this.axis.value = this.axis.value ? '' : 'y'; this.cut(); }
    if (event.key === 'm') this.measure.click();
    if (event.key === 'p') this.tree.toggle();
    if (event.key === 'Escape') { if (this.view.measuring) this.measure.click(); this.view.select(null); }
  }
}

export async function open(section) {
  const machine = new Machine(section);
  await machine.start();
  return machine;
}
