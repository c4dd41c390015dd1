// Dropped record files: upload, the program's proposal of channels and units with its questions, a new experiment.toml.
import { get, post, upload } from './api.js';
import { h, fill, newest, say, words } from './dom.js';
import { RecordStrip, drawSpark } from './strip.js';

export function newExperimentPlace(onfiles) {
  const input = h('input', { type: 'file', multiple: true, hidden: true, onchange: () => { onfiles([...input.files]); input.value = ''; } });
  get('/api/formats').then(({ suffixes }) => { input.accept = suffixes.join(','); }).catch(() => {});
  return h('div', { class: 'drop' }, input, h('button', { class: 'dropzone', onclick: () => input.click() }, 'Drop record files here, or choose them', h('span', { class: 'dim' }, 'CSV, Parquet, MAT, HDF5, NumPy, TDMS')));
}

/**
 * Ask for a name, upload, map the columns, write the experiment. Resolves to its name, or null when cancelled.
 * @param {(File|{name: string})[]} files  dropped on the page, or by name those of the folder
 */
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
      h('table', {}, this.files.map((file) => h('tr', {}, h('td', {}, file.name), h('td', { class: 'num dim' }, file.size === undefined ? 'in this folder' : `${(file.size / 1e6).toFixed(2)} MB`)))));
    this.name.focus();
  }

  /** Bring the files into the folder of the experiment, one after another. */
  async bring() {
    const stored = [];
    for (const [k, file] of this.files.entries()) {
      this.next.textContent = `uploading ${k + 1} of ${this.files.length}`;
      const name = file.name.replace(/[^A-Za-z0-9_.-]+/g, '_');
      stored.push(file instanceof File ? await upload(`/api/upload/${encodeURIComponent(this.name.value)}/${encodeURIComponent(name)}`, file)
        : (await post('/api/records', { name: this.name.value, files: [file.name] }))[0]);
    }
    return stored;
  }

  async send() {
    this.problem.textContent = '';
    this.next.disabled = true;
    try {
      this.records = await this.bring();
      const last = this.records.length - 1;
      this.roles = this.records.map((record, k) => choice(`role of ${record.file}`, { fit: 'fit', validate: 'held out' }, k > 0 && k === last ? 'validate' : 'fit'));
      this.previews = await post('/api/preview', { name: this.name.value, files: this.records.map((record) => record.file) });
      this.strips = this.previews.map((preview) => new RecordStrip(preview));
      await this.propose();
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
    this.found = found;
    this.kind = choice('kind of rig', Object.fromEntries(this.kinds.map((name) => [name, name])), found.kind);
    this.kind.addEventListener('change', () => this.propose(this.kind.value).catch((error) => { this.problem.textContent = error.message; }));
    this.kindQuestion = found.question ? this.question(found.question) : null;
    this.effects = h('input', { type: 'text', value: this.effects?.value ?? found.effects.join(', '), 'aria-label': 'effects of the model', spellcheck: 'false' });
    const given = Object.fromEntries((this.known ?? []).map(([name, input]) => [name, input.value]));
    this.known = Object.entries(found.known).map(([name, unit]) => [name, h('input', { type: 'text', value: given[name] ?? '', placeholder: `${name.startsWith('rated_') ? 'what are 100 % of it?' : 'fitted, or'} e.g. 1.79 ${unit}`.trim(), 'aria-label': name, spellcheck: 'false' })]);
    const channels = { '': '–', ...Object.fromEntries(Object.keys(found.channels).map((name) => [name, words(name)])) };
    this.columns = found.columns.map((one) => this.column(one, channels));
    this.show();
    for (const { spark, one } of this.columns) drawSpark(spark, this.previews[0].columns[one.label]);
    this.look();
  }

  /** A question to be answered: by a control beside it, or by a yes to what is proposed. */
  question(text) {
    const asked = { open: true };
    asked.yes = h('button', { class: 'small', type: 'button', onclick: () => { asked.answer(); this.look(); } }, 'Yes, as proposed');
    asked.element = h('p', { class: 'warn question' }, h('span', {}, text), asked.yes);
    asked.answer = () => { asked.open = false; asked.element.hidden = true; };
    return asked;
  }

  /** One column of the files with its controls. */
  column(one, channels) {
    const channel = choice(`channel of ${one.label}`, channels, one.channel ?? '');
    const unit = h('input', { type: 'text', value: one.unit, placeholder: one.unit_in_file ? 'as in the file' : 'unit', 'aria-label': `unit of ${one.label}`, spellcheck: 'false' });
    const scale = h('input', { type: 'text', placeholder: one.scale ? one.scale.replace('?', 'e.g. 5') : '1', 'aria-label': `scale of ${one.label}`, spellcheck: 'false' });
    const sign = choice(`sign of ${one.label}`, { 1: '+', '-1': '−' }, '1');
    const asked = one.question && one.channel ? this.question(one.question) : null;
    // A number that only the user knows is not answered by a yes.
    if (asked && one.scale) asked.yes.hidden = true;
    for (const control of [channel, unit, scale, sign]) control.addEventListener('change', () => { asked?.answer(); this.look(); });
    const spark = h('canvas', { class: 'spark', role: 'img', 'aria-label': `${one.label} in ${this.previews[0].file}` });
    return { one, channel, unit, scale, sign, asked, spark };
  }

  /** The questions of the proposal. */
  get asked() { return [this.kindQuestion, ...this.columns.map(({ asked }) => asked)].filter(Boolean); }

  /** What is wrong, and what is still to be answered: a line, and the control that answers it. */
  open() {
    const wrong = [];
    const items = [];
    const taken = new Map();
    if (this.kindQuestion?.open) items.push([this.found.question, this.kind]);
    for (const { one, channel, scale, asked } of this.columns) {
      const name = channel.value;
      if (!name) continue;
      const before = taken.get(name);
      if (before && !isAdded(name, before, one)) wrong.push([`two columns are taken for ${words(name)}: ${before.label} and ${one.label}`, channel]);
      taken.set(name, one);
      if (asked?.open) items.push([`${one.label}: ${one.question}`, one.scale ? scale : channel]);
      else if (one.scale && name === one.channel && !scale.value.trim()) items.push([`${one.label}: its scale is missing, like ${scale.placeholder.replace('e.g. ', '')}`, scale]);
    }
    for (const group of this.found.needed.filter((names) => !names.some((name) => taken.has(name)))) wrong.push([`no column is taken for ${group.map(words).join(' or ')}`, this.columns[0]?.channel]);
    for (const [name, input] of this.known) if (name.startsWith('rated_') && taken.has(name.slice(6)) && !input.value.trim()) items.push([`${words(name)}: what are 100 % of it?`, input]);
    return [...wrong, ...items];
  }

  /** Count what is open, and draw the channels of the records. */
  look() {
    const items = this.open();
    this.next.textContent = items.length ? `Create (${items.length} open)` : 'Create';
    this.all.hidden = !this.asked.some((one) => one.open && !one.yes.hidden);
    const sums = Object.entries(Object.groupBy(this.columns.filter(({ channel }) => channel.value), ({ channel }) => channel.value)).filter(([, group]) => group.length > 1);
    fill(this.missing, [...items.map(([text]) => text).filter((text) => text.startsWith('no column')),
      ...sums.map(([name, group]) => `${words(name)}: the sum of ${group.map(({ one }) => one.label).join(' and ')}`)].map((text) => h('span', {}, text, h('br'))));
    const channels = this.columns.filter(({ channel }) => channel.value && channel.value !== 'time').map(({ one, channel }) => [one.label, words(channel.value)]);
    const time = this.columns.find(({ channel }) => channel.value === 'time');
    this.strips.forEach((strip) => strip.show(channels, time && { label: time.one.label, unit: time.unit.value.trim() || time.one.stated || 's' }));
  }

  show() {
    const { found } = this;
    const field = (name, input) => h('label', { class: 'field' }, h('span', {}, name), input);
    this.missing = h('p', { class: 'warn' });
    this.all = h('button', { class: 'small', type: 'button', onclick: () => { for (const one of this.asked) if (!one.yes.hidden) one.answer(); this.look(); } }, 'Take all as proposed');
    fill(this.body,
      found.read_as.length ? h('p', { class: 'dim' }, `read as: ${found.read_as.join(', ')}`) : null,
      field('kind of rig', this.kind), this.kindQuestion?.element, this.missing,
      this.known.map(([name, input]) => field(words(name), input)), field('model', this.effects),
      h('div', { class: 'record-head' }, h('h3', {}, 'Columns'), this.all), h('table', { class: 'columns' }, h('thead', {}, h('tr', {}, ['column', 'values', 'channel', 'unit', 'scale', 'sign'].map((text) => h('th', {}, text)))),
        h('tbody', {}, this.columns.map((row) => this.lines(row)))),
      h('h3', {}, 'Records'), h('p', { class: 'dim' }, 'Drag over a record to use a part of it; a double click takes it whole.'),
      this.records.map((record, k) => h('div', { class: 'record-row' }, h('div', { class: 'record-head' }, h('b', {}, record.file), h('span', { class: 'dim' }, `${record.rows} rows`), this.roles[k], this.strips[k].ends), this.strips[k].element)));
  }

  lines({ one, channel, unit, scale, sign, asked, spark }) {
    const values = one.first ? one.first.slice(0, 3).map((v) => (v === null ? '·' : String(Number(v.toPrecision(12))))).join(', ') : 'text';
    const seen = this.previews[0].columns[one.label]?.filter((v) => v !== null);
    const ends = seen?.length ? `${short(Math.min(...seen))} … ${short(Math.max(...seen))}` : values;
    return [h('tr', {}, h('td', {}, one.label), h('td', { class: 'dim values', title: `first values: ${values}` }, spark, ends), ...[channel, unit, scale, sign].map((input) => h('td', {}, input))),
      asked ? h('tr', {}, h('td', {}), h('td', { colSpan: 5 }, asked.element)) : null];
  }

  async create() {
    this.problem.textContent = '';
    const [first] = this.open();
    if (first) {
      const [line, control] = first;
      this.problem.textContent = line;
      control?.scrollIntoView({ block: 'center' });
      control?.focus();
      return;
    }
    const text = (input) => input.value.trim();
    const channels = {};
    for (const { one, channel, unit, scale, sign } of this.columns.filter((column) => column.channel.value)) {
      const setting = { column: one.column, unit: text(unit), scale: text(scale), sign: Number(sign.value) };
      channels[channel.value] = channel.value in channels ? [channels[channel.value], setting].flat() : setting;
    }
    this.next.disabled = true;
    try {
      const found = await post('/api/experiments', {
        name: this.name.value, kind: this.kind.value, channels,
        known: Object.fromEntries(this.known.map(([name, input]) => [name, text(input)]).filter(([, given]) => given)),
        effects: this.effects.value.split(',').map((one) => one.trim()).filter(Boolean),
        records: this.records.map((record, k) => ({ file: record.file, role: this.roles[k].value, ...this.strips[k].range })),
      });
      say(`${found.name}/experiment.toml written`, 'good');
      this.dialog.close(found.name);
    } catch (error) { this.problem.textContent = error.message; }
    this.next.disabled = false;
  }
}

/** Two forces in one unit are added, as of two load cells. */
const isAdded = (name, one, other) => name.endsWith('force') && one.stated && one.stated === other.stated;
const short = (value) => String(Number(value.toPrecision(5))).replace('-', '−');

function choice(label, options, value) {
  const made = h('select', { 'aria-label': label }, Object.entries(options).map(([name, text]) => h('option', { value: name }, text)));
  made.value = value;
  return made;
}
