// Dropped record files: upload, the program's proposal of channels and units with its questions, a new experiment.toml.
import { get, post, upload } from './api.js';
import { h, fill, newest, say, words } from './dom.js';

export function newExperimentPlace(onfiles) {
  const input = h('input', { type: 'file', multiple: true, hidden: true, onchange: () => { onfiles([...input.files]); input.value = ''; } });
  get('/api/formats').then(({ suffixes }) => { input.accept = suffixes.join(','); }).catch(() => {});
  return h('div', { class: 'drop' }, input, h('button', { class: 'dropzone', onclick: () => input.click() }, 'Drop record files here, or choose them', h('span', { class: 'dim' }, 'CSV, Parquet, MAT, HDF5, NumPy, TDMS')));
}

/** Ask for a name, upload, map the columns, write the experiment. Resolves to its name, or null when cancelled. */
export function importFiles(files) {
  return new Promise((settle, fail) => {
    const dialog = h('dialog', { class: 'import', 'aria-label': 'New experiment' });
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
    this.turn = newest();
    this.problem = h('p', { class: 'bad', role: 'alert' });
    this.name = h('input', { type: 'text', value: files[0].name.replace(/\.[^.]*$/, '').replace(/[^A-Za-z0-9_-]+/g, '_').slice(0, 40) || 'experiment', 'aria-label': 'name of the experiment', spellcheck: 'false' });
    this.next = h('button', { class: 'main' }, 'Upload');
    this.act = () => this.send();
    this.next.addEventListener('click', () => this.act());
    this.body = h('div', { class: 'import-body' });
    this.body.addEventListener('keydown', (event) => { if (event.key === 'Enter' && event.target.matches('input') && !this.next.disabled) this.act(); });
    fill(dialog, h('h2', {}, 'New experiment'), this.body, this.problem,
      h('div', { class: 'actions' }, h('button', { onclick: () => dialog.close('') }, 'Cancel'), this.next));
  }

  async start() {
    this.kinds = (await get('/api/formats')).kinds;
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
      const last = this.records.length - 1;
      this.roles = this.records.map((record, k) => choice(`role of ${record.file}`, { fit: 'fit', validate: 'held out' }, k > 0 && k === last ? 'validate' : 'fit'));
      await this.propose();
      this.next.textContent = 'Create';
      this.act = () => this.create();
    } catch (error) {
      this.problem.textContent = error.message;
      this.next.textContent = 'Upload';
    }
    this.next.disabled = false;
  }

  /** What the program takes the columns for, with the kind of rig that it guesses or that was chosen. */
  async propose(kind = null) {
    const current = this.turn();
    const found = await post('/api/propose', { name: this.name.value, files: this.records.map((record) => record.file), kind });
    if (!current()) return;
    this.kind = choice('kind of rig', Object.fromEntries(this.kinds.map((name) => [name, name])), found.kind);
    this.kind.addEventListener('change', () => this.propose(this.kind.value).catch((error) => { this.problem.textContent = error.message; }));
    this.effects = h('input', { type: 'text', value: this.effects?.value ?? found.effects.join(', '), 'aria-label': 'effects of the model', spellcheck: 'false' });
    const given = Object.fromEntries((this.known ?? []).map(([name, input]) => [name, input.value]));
    this.known = Object.entries(found.known).map(([name, unit]) => [name, h('input', { type: 'text', value: given[name] ?? '', placeholder: `fitted, or e.g. 1.79 ${unit}`.trim(), 'aria-label': name, spellcheck: 'false' })]);
    const channels = { '': '–', ...Object.fromEntries(Object.keys(found.channels).map((name) => [name, words(name)])) };
    this.columns = found.columns.map((one) => {
      const channel = choice(`channel of ${one.label}`, channels, one.channel ?? '');
      const unit = h('input', { type: 'text', value: one.unit, placeholder: one.unit_in_file && one.channel ? 'as in the file' : 'unit', 'aria-label': `unit of ${one.label}`, spellcheck: 'false' });
      const scale = h('input', { type: 'text', value: one.scale ?? '', placeholder: '1', 'aria-label': `scale of ${one.label}`, spellcheck: 'false' });
      return { one, channel, unit, scale, sign: choice(`sign of ${one.label}`, { 1: '+', '-1': '−' }, '1') };
    });
    const missing = h('p', { class: 'warn' });
    const look = () => {
      const taken = new Set(this.columns.map(({ channel }) => channel.value));
      const names = found.needed.filter((group) => !group.some((name) => taken.has(name)));
      missing.textContent = names.length ? `no column is taken for ${names.map((group) => group.map(words).join(' or ')).join(', ')}` : '';
    };
    for (const { channel } of this.columns) channel.addEventListener('change', look);
    look();
    const field = (name, input) => h('label', { class: 'field' }, h('span', {}, name), input);
    fill(this.body,
      found.read_as.length ? h('p', { class: 'dim' }, `read as: ${found.read_as.join(', ')}`) : null,
      field('kind of rig', this.kind), found.question ? h('p', { class: 'warn' }, found.question) : null,
      missing,
      this.known.map(([name, input]) => field(words(name), input)), field('model', this.effects),
      h('h3', {}, 'Records'), h('table', {}, this.records.map((record, k) => h('tr', {}, h('td', {}, record.file), h('td', { class: 'num dim' }, `${record.rows} rows`), h('td', {}, this.roles[k])))),
      h('h3', {}, 'Columns'), h('table', { class: 'columns' }, h('thead', {}, h('tr', {}, ['column', 'first values', 'channel', 'unit', 'scale', 'sign'].map((text) => h('th', { class: text.replace(' ', '-') }, text)))),
        h('tbody', {}, this.columns.map(({ one, channel, unit, scale, sign }) => [
          h('tr', {}, h('td', {}, one.label), h('td', { class: 'dim values' }, one.first ? one.first.slice(0, 3).map((v) => (v === null ? '·' : Number(v.toPrecision(5)))).join(', ') : 'text'), ...[channel, unit, scale, sign].map((input) => h('td', {}, input))),
          one.question && one.channel ? h('tr', {}, h('td', {}), h('td', { class: 'warn', colSpan: 5 }, one.question)) : null]))));
  }

  async create() {
    this.problem.textContent = '';
    const text = (input) => input.value.trim();
    const channels = {};
    for (const { one, channel, unit, scale, sign } of this.columns) {
      if (channel.value in channels) { this.problem.textContent = `two columns are taken for ${words(channel.value)}: ${channels[channel.value].column} and ${one.label}`; return; }
      if (channel.value) channels[channel.value] = { column: one.column, unit: text(unit), scale: text(scale), sign: Number(sign.value) };
    }
    this.next.disabled = true;
    try {
      const found = await post('/api/experiments', {
        name: this.name.value, kind: this.kind.value, channels,
        known: Object.fromEntries(this.known.map(([name, input]) => [name, text(input)]).filter(([, given]) => given)),
        effects: this.effects.value.split(',').map((one) => one.trim()).filter(Boolean),
        records: this.records.map((record, k) => ({ file: record.file, role: this.roles[k].value })),
      });
      say(`${found.name}/experiment.toml written`, 'good');
      this.dialog.close(found.name);
    } catch (error) { this.problem.textContent = error.message; }
    this.next.disabled = false;
  }
}

function choice(label, options, value) {
  const made = h('select', { 'aria-label': label }, Object.entries(options).map(([name, text]) => h('option', { value: name }, text)));
  made.value = value;
  return made;
}
