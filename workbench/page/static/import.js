// Dropped record files: upload, columns to channels, and a new experiment.toml.
import { get, post, upload } from './api.js';
import { h, fill, say, words } from './dom.js';

export function newExperimentPlace(onfiles) {
  const input = h('input', { type: 'file', multiple: true, accept: '.csv,.txt,.dat,.parquet,.pq,.mat', hidden: true, onchange: () => { onfiles([...input.files]); input.value = ''; } });
  return h('div', { class: 'drop' }, input, h('button', { class: 'dropzone', onclick: () => input.click() }, 'Drop record files here, or choose them', h('span', { class: 'dim' }, 'CSV, Parquet, MAT')));
}

/** Ask for a name, upload, map the columns, write the experiment. Resolves to its name, or null when cancelled. */
export function importFiles(files) {
  return new Promise((settle, fail) => {
    const dialog = h('dialog', { class: 'import' });
    dialog.addEventListener('close', () => { dialog.remove(); settle(dialog.returnValue || null); });
    document.body.append(dialog);
    new Import(dialog, files).start().catch((error) => { dialog.close(); fail(error); });
    dialog.showModal();
  });
}

class Import {
  constructor(dialog, files) {
    this.dialog = dialog;
    this.files = files;
    this.problem = h('p', { class: 'bad', role: 'alert' });
    this.name = h('input', { type: 'text', value: files[0].name.replace(/\.[^.]*$/, '').replace(/[^A-Za-z0-9_-]+/g, '_').slice(0, 40) || 'experiment', 'aria-label': 'name of the experiment', spellcheck: 'false' });
    this.next = h('button', { class: 'main', onclick: () => this.send() }, 'Upload');
    this.body = h('div', { class: 'import-body' });
    fill(dialog, h('h2', {}, 'New experiment'), this.body, this.problem,
      h('div', { class: 'actions' }, h('button', { onclick: () => dialog.close('') }, 'Cancel'), this.next));
  }

  async start() {
    this.info = await get('/api/rigs');
    fill(this.body, h('label', { class: 'field' }, h('span', {}, 'folder'), this.name),
      h('table', {}, this.files.map((file) => h('tr', {}, h('td', {}, file.name), h('td', { class: 'num dim' }, `${(file.size / 1e6).toFixed(2)} MB`)))));
    this.name.focus();
  }

  async send() {
    this.problem.textContent = '';
    this.next.disabled = true;
    this.records = [];
    try {
      for (const [k, file] of this.files.entries()) {
        this.next.textContent = `uploading ${k + 1} of ${this.files.length}`;
        const name = file.name.replace(/[^A-Za-z0-9_.-]+/g, '_');
        this.records.push(await upload(`/api/upload/${encodeURIComponent(this.name.value)}/${encodeURIComponent(name)}`, file));
      }
      this.map();
    } catch (error) {
      this.problem.textContent = error.message;
      this.next.textContent = 'Upload';
    }
    this.next.disabled = false;
  }

  map() {
    const columns = this.records[0].columns;
    const kinds = Object.keys(this.info.kinds);
    const guess = guessKind(this.info.kinds, columns.map((column) => channelOf(column.label)));
    this.kind = h('select', { 'aria-label': 'kind of rig', onchange: () => this.showColumns() }, kinds.map((name) => h('option', { value: name }, name)));
    this.kind.value = guess;
    this.known = h('div', { class: 'known' });
    this.columns = h('table', { class: 'columns' });
    this.roles = this.records.map((record, k) => { const s = h('select', { 'aria-label': `role of ${record.file}` }, h('option', { value: 'fit' }, 'fit'), h('option', { value: 'validate' }, 'held out')); s.value = k > 0 && k === this.records.length - 1 ? 'validate' : 'fit'; return s; });
    this.effects = h('input', { type: 'text', value: 'coulomb, viscous', 'aria-label': 'effects of the model', spellcheck: 'false' });
    fill(this.body,
      h('label', { class: 'field' }, h('span', {}, 'kind of rig'), this.kind), this.known,
      h('label', { class: 'field' }, h('span', {}, 'model'), this.effects),
      h('h3', {}, 'Records'), h('table', {}, this.records.map((record, k) => h('tr', {}, h('td', {}, record.file), h('td', { class: 'num dim' }, `${record.columns[0]?.rows ?? '?'} rows`), h('td', {}, this.roles[k])))),
      h('h3', {}, 'Columns'), this.columns);
    this.next.textContent = 'Create';
    this.next.onclick = null;
    const create = h('button', { class: 'main', onclick: () => this.create() }, 'Create');
    this.next.replaceWith(create);
    this.next = create;
    this.showColumns();
  }

  showColumns() {
    const kind = this.info.kinds[this.kind.value];
    this.knownFields = Object.entries(kind.known).map(([name, unit]) => [name, h('input', { type: 'text', placeholder: `fitted, or e.g. 1.79 ${unit}`, 'aria-label': name, spellcheck: 'false' })]);
    fill(this.known, this.knownFields.map(([name, field]) => h('label', { class: 'field' }, h('span', {}, words(name)), field)));
    this.maps = this.records[0].columns.map((column) => {
      const guess = channelOf(column.label);
      const channel = h('select', { 'aria-label': `channel of ${column.label}` }, h('option', { value: '' }, '–'), kind.channels.map((name) => h('option', { value: name }, words(name))));
      channel.value = kind.channels.includes(guess) ? guess : '';
      const written = unitOf(column.label) || column.unit || '';
      const unit = h('input', { type: 'text', value: written, placeholder: 'unit', 'aria-label': `unit of ${column.label}`, spellcheck: 'false' });
      const sign = h('select', { 'aria-label': `sign of ${column.label}` }, h('option', { value: '1' }, '+'), h('option', { value: '-1' }, '−'));
      return { column, channel, unit, sign };
    });
    fill(this.columns, h('thead', {}, h('tr', {}, ['column', 'first values', 'channel', 'unit', 'sign'].map((text) => h('th', {}, text)))),
      h('tbody', {}, this.maps.map(({ column, channel, unit, sign }) => h('tr', {}, h('td', {}, column.label), h('td', { class: 'dim' }, column.error ?? (column.first ?? []).slice(0, 3).map((v) => (v === null ? '·' : Number(v.toPrecision(5)))).join(', ')), h('td', {}, channel), h('td', {}, unit), h('td', {}, sign)))));
  }

  async create() {
    this.problem.textContent = '';
    const known = Object.fromEntries(this.knownFields.map(([name, field]) => [name, field.value.trim()]).filter(([, text]) => text));
    const columns = {}; const units = {}; const sign = {};
    for (const { column, channel, unit, sign: s } of this.maps) {
      if (!channel.value) continue;
      if (channelOf(column.label) !== channel.value) columns[channel.value] = column.label;
      // A unit in brackets in the header is read by the program itself.
      if (unit.value.trim() && !column.label.includes(`[${unit.value.trim()}]`)) units[channel.value] = unit.value.trim();
      if (s.value === '-1') sign[channel.value] = -1;
    }
    try {
      const found = await post('/api/experiments', {
        name: this.name.value, kind: this.kind.value, known, effects: this.effects.value.split(',').map((text) => text.trim()).filter(Boolean),
        records: this.records.map((record, k) => ({ file: record.file, role: this.roles[k].value, columns, units, sign })),
      });
      say(`${found.name}/experiment.toml written`, 'good');
      this.dialog.close(found.name);
    } catch (error) { this.problem.textContent = error.message; }
  }
}

const channelOf = (label) => label.replace(/\s*[[(].*$/, '').trim().toLowerCase().replace(/[\s-]+/g, '_');
const unitOf = (label) => label.match(/[[(]([^\])]*)[\])]\s*$/)?.[1]?.trim() ?? '';

function guessKind(kinds, names) {
  const has = new Set(names);
  const fits = Object.entries(kinds).filter(([, kind]) => kind.inputs.every((group) => group.some((name) => has.has(name))) && kind.measured.every((group) => group.some((name) => has.has(name))));
  return (fits.at(-1) ?? Object.entries(kinds)[0])[0];
}
