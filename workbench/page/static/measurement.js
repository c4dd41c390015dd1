// The measurement: experiments and ladder on the left, model over record in the middle, ranking on the right.
import { cancel, get, jobs, onJob, post, result } from './api.js';
import { movable, movablePanels } from './borders.js';
import { h, fill, newest, number, quantity, say, setAddress, swatch, times, words } from './dom.js';
import { importFiles, newExperimentPlace } from './import.js';
import { drawLadder, worst } from './ladder.js';
import { drawMaps } from './maps.js';
import { Overlay } from './overlay.js';
import { ModelSliders, predictor } from './fitted_values.js';

const TASKS = new Set(['compare', 'diagnose', 'add', 'undo', 'suggest', 'export']);
/** In the address, the fitted model as the one whose residual is shown, where a candidate would be. */
const FITTED = 'model';
const LANGUAGES = { python: 'Python', c: 'C', fmu: 'FMU', modelica: 'Modelica', matlab: 'MATLAB', table: 'table' };

class Measurement {
  constructor(section) {
    this.section = section;
    this.turn = { list: newest(), choice: newest(), ladder: newest() };
    this.left = h('div', { class: 'panel' });
    this.middle = h('div', { class: 'panel' });
    this.right = h('div', { class: 'panel' });
    fill(section, this.left, this.middle, this.right);
    this.middle.classList.add('blank');
    // Models that are drawn over the record beside the fitted one, and the one whose maps are shown.
    this.drawn = new Set();
    this.chosen = null;
    this.candidates = new Map();
    this.makeLeft();
    this.makeMiddle();
    this.makeRight();
    movablePanels('measurement', this.left, this.right);
    onJob((job) => this.jobChanged(job));
    addEventListener('keydown', (event) => this.key(event));
    addEventListener('reconnected', () => this.readList().then(() => { if (this.name && !this.found) this.choose(this.name); }).catch((error) => say(error.message, 'bad')));
    for (const type of ['dragover', 'drop']) {
      section.addEventListener(type, (event) => {
        event.preventDefault();
        section.classList.toggle('dropping', type === 'dragover');
        if (type === 'drop') this.take([...event.dataTransfer.files]);
      });
    }
    section.addEventListener('dragleave', (event) => { if (!section.contains(event.relatedTarget)) section.classList.remove('dropping'); });
  }

  makeLeft() {
    this.list = h('div', { class: 'experiments' });
    this.about = h('div', { class: 'about' });
    this.ladder = h('div', { class: 'card ladder' });
    this.examples = h('select', { 'aria-label': 'copy an example into this folder', title: 'Copy an example into this folder', onchange: () => { const name = this.examples.value; this.examples.value = ''; if (name) this.copy(name); } });
    fill(this.left,
      h('div', { class: 'head' }, h('h2', {}, 'Experiments'), h('span', { class: 'space' }),
        this.examples),
      h('div', { class: 'scroll' }, this.list, newExperimentPlace((files) => this.take(files)), this.ladder, this.about));
  }

  makeMiddle() {
    this.overlay = new Overlay();
    this.sliders = new ModelSliders((body) => predictor(path(this.name))(body), this.overlay);
    this.overlay.onview = () => this.link();
    this.overlay.onchoose = () => { if (Object.keys(this.sliders.values ?? {}).length) this.sliders.ask(); };
    this.maps = h('div', { class: 'maps', tabindex: '0', role: 'region', 'aria-label': 'residual over each coordinate' });
    this.mapOf = h('select', { 'aria-label': 'model whose residual is shown', onchange: () => this.choosePreview(this.mapOf.value || null) });
    this.mapBox = h('div', { class: 'map-box' }, h('div', { class: 'plot-head' }, h('b', {}, 'Residual'), 'of', this.mapOf, h('span', { class: 'dim', title: 'in standard deviations of the noise' }, 'over each coordinate, × noise'), h('span', { class: 'legend' }, h('span', {}, swatch('var(--map-forward)'), 'forward'), h('span', {}, swatch('var(--map-backward)'), 'backward'))), this.maps);
    this.statement = h('p', { class: 'statement' }, 'Choose an experiment, or drop record files on the page.');
    this.warnings = h('ul', { class: 'warnings warn' });
    this.raw = h('details', { class: 'raw', hidden: true }, h('summary', {}, 'Channels as logged'), this.picture = h('img', { alt: 'every channel over time, with its faults marked' }));
    fill(this.middle, h('div', { class: 'finding', tabindex: '0', role: 'region', 'aria-label': 'finding' }, this.statement, this.warnings), this.raw, this.overlay.element, this.mapBox);
    movable(this.mapBox, 'top', 'maps', 'border between curves and maps');
  }

  makeRight() {
    this.diagnose = h('button', { class: 'main', title: 'Which effect is missing? (D)', disabled: true, onclick: () => this.start('diagnose', { all_effects: false }) }, 'Diagnose');
    this.suggest = h('button', { disabled: true, title: 'The measurement that would best separate the rivals', onclick: () => this.start('suggest') }, 'Next measurement');
    this.undo = h('button', { disabled: true, title: 'Back to the rung before', onclick: () => this.start('undo') }, 'Undo');
    this.report = h('a', { class: 'report', target: '_blank', hidden: true }, 'Report');
    this.json = h('a', { class: 'report', target: '_blank', hidden: true }, 'JSON');
    this.language = h('select', { class: 'small', hidden: true, 'aria-label': 'export the fitted model', title: 'Write the fitted model in another language', onchange: () => { const to = this.language.value; this.language.value = ''; if (to) this.start('export', { to }); } },
      h('option', { value: '' }, 'Export model'), Object.entries(LANGUAGES).map(([value, text]) => h('option', { value }, text)));
    this.progress = h('div', { class: 'search' });
    this.ranking = h('div', { class: 'scroll' });
    fill(this.right, h('div', { class: 'head' }, this.diagnose, this.suggest, h('span', { class: 'space' }), this.undo), this.progress, this.ranking,
      h('div', { class: 'foot' }, this.report, this.json, h('span', { class: 'space' }), this.language));
  }

  async start_() {
    [this.available, this.loose] = await Promise.all([get('/api/examples'), get('/api/records'), this.readList()]);
    fill(this.examples, h('option', { value: '' }, 'Examples'), this.available.map(({ name, meaning }) => h('option', { value: name, title: meaning }, words(name))));
    this.offer();
  }

  /** The experiment that was worked on last, or the first. */
  get usual() {
    const last = [...jobs.values()].filter((job) => TASKS.has(job.task)).at(-1)?.subject;
    return this.experiments.find((one) => one.name === last) ?? this.experiments[0];
  }

  async readList() {
    const current = this.turn.list();
    const found = await get('/api/experiments');
    if (!current()) return;
    this.experiments = found;
    fill(this.list, this.experiments.map(({ name, rungs }) => h('button', { class: 'experiment', dataset: { name }, 'aria-pressed': String(name === this.name), onclick: () => this.choose(name) },
      h('span', {}, name), h('span', { class: 'dim' }, rungs ? `${rungs} added` : ''))),
    );
    this.offer();
  }

  /** With no experiment in the folder, the examples are what there is to begin with. */
  offer() {
    if (this.experiments.length || !this.available) return;
    const found = this.loose.map((name) => ({ name }));
    fill(this.list, h('p', { class: 'empty' }, 'No folder with an experiment.toml here yet.'),
      found.length ? h('button', { class: 'offer', onclick: () => this.take(found) }, h('b', {}, `Make an experiment of ${found.length === 1 ? 'the record' : `${found.length} records`} in this folder`), h('span', { class: 'dim' }, this.loose.join(', '))) : null,
      h('p', { class: 'empty' }, 'Drop record files below, or begin with an example:'),
      this.available.map(({ name, meaning }) => h('button', { class: 'offer', onclick: () => this.copy(name) }, h('b', {}, words(name)), h('span', { class: 'dim' }, meaning))));
  }

  /** `#measurement/NAME?with=MODELS&of=MODEL&record=...`: an experiment, the models over its record, and what is seen. */
  async shown(parts, values = {}) {
    const name = parts.join('/');
    if (!name) {
      if (!this.name && this.usual) await this.choose(this.usual.name); else this.link();
      return;
    }
    this.wanted = values;
    if (!this.experiments?.some((one) => one.name === name)) await this.readList();
    if (name === this.name) this.see(); else if (this.experiments.some((one) => one.name === name)) await this.choose(name); else say(`${name}: no such experiment in this folder`, 'bad');
  }

  /** Show what the address asks for, once the model is there. */
  see() {
    const { wanted } = this;
    if (!wanted || !this.found) return;
    this.wanted = null;
    if ('with' in wanted) this.drawn = new Set((wanted.with ?? '').split(',').filter((one) => this.models.has(one)));
    if (this.models.has(wanted.of) || wanted.of === FITTED) this.chosen = wanted.of === FITTED ? null : wanted.of;
    this.overlay.view = wanted;
    this.drawModels();
  }

  /** The address names what is shown, so that it can be kept or sent. */
  link() {
    if (!this.name || this.wanted) return;
    setAddress(this.section, this.name.split('/'), { with: [...this.drawn].join(','), of: this.chosen ?? (this.candidates.size ? FITTED : ''), ...this.overlay.view });
  }

  async choose(name) {
    const current = this.turn.choice();
    if (name !== this.name) { this.drawn.clear(); this.chosen = null; }
    this.name = name;
    for (const one of this.list.querySelectorAll('.experiment')) one.setAttribute('aria-pressed', String(one.dataset.name === name));
    // Until the ladder is read, and the last result, there is nothing to act on.
    for (const button of [this.diagnose, this.suggest, this.undo]) button.disabled = true;
    fill(this.ranking, '');
    fill(this.progress, '');
    this.sliders.clear();
    this.found = this.shownJob = null;
    this.models = new Map();
    this.middle.classList.add('blank');
    fill(this.statement, '');
    this.warnings.hidden = this.report.hidden = this.json.hidden = this.raw.hidden = this.language.hidden = true;
    this.link();
    try {
      await this.readLadder();
    } catch (error) {
      if (!current()) return;
      fill(this.statement, h('span', { class: 'bad' }, error.message));
      await this.askConsent(name).catch(() => {});
      return;
    }
    if (!current()) return;
    this.look(name).catch((error) => say(error.message, 'bad'));
    const mine = [...jobs.values()].filter((job) => job.subject === name && TASKS.has(job.task));
    const active = mine.filter((job) => job.state === 'running' || job.state === 'waiting').at(-1);
    const done = mine.filter((job) => job.state === 'done' && job.task !== 'suggest' && job.task !== 'export').at(-1);
    // What was found before a reload is shown again, as long as the file of the experiment is the same.
    if (done) {
      const found = await result(done).catch(() => null);
      if (!current()) return;
      if (found && (found.comparison ?? found).text === this.text) this.show(done, found);
    }
    this.showProgress(null);
    if (active) this.follow(active); else if (!this.found) this.start('compare');
  }

  /** The channels as they are logged, and what is wrong in them: seen before any fit. */
  async look(name) {
    const { warnings, figure } = await get(`/api/experiment/${path(name)}/look`);
    if (this.name !== name) return;
    this.picture.src = `data:image/svg+xml,${encodeURIComponent(figure)}`;
    this.raw.hidden = false;
    this.raw.open = !this.found;
    if (!this.found) this.warn(warnings);
  }

  warn(texts) {
    fill(this.warnings, texts.map((text) => h('li', {}, text)));
    this.warnings.hidden = !texts.length;
  }

  /** The Python files of an experiment that may not run yet: their text, and the consent where the server takes one. */
  async askConsent(name) {
    const { offered, files } = await get(`/api/experiment/${path(name)}/code`);
    const waiting = files.filter((file) => !file.consented);
    if (this.name !== name || !files.length || (offered && !waiting.length)) return;
    const agree = async () => {
      try {
        await post(`/api/experiment/${path(name)}/consent`, { files: Object.fromEntries(waiting.map((file) => [file.name, file.sha256])) });
        say('');
        if (this.name === name) this.choose(name);
      } catch (error) { say(error.message, 'bad'); }
    };
    fill(this.statement, 'This experiment runs Python code, which wants your consent.');
    fill(this.ladder, '');
    fill(this.ranking, h('div', { class: 'card consent' },
      h('h3', {}, 'This experiment runs Python code'),
      h('p', {}, offered ? 'It runs with your rights. Read it before you agree; the consent holds for this content alone.' : 'This server was started without it. To be asked here: stagecad workbench --trust'),
      waiting.map((file) => [h('h3', {}, file.name), h('pre', {}, file.text)]),
      offered ? h('div', { class: 'actions' }, h('button', { class: 'main', onclick: agree }, `Run ${waiting.map((file) => file.name).join(', ')}`)) : null));
  }

  async readLadder() {
    const current = this.turn.ladder();
    try {
      const found = await get(`/api/experiment/${path(this.name)}/ladder`);
      if (!current()) return;
      this.text = found.text;
      this.rungs = found.rungs;
      this.undo.disabled = found.rungs.length < 2;
      this.edited = found.edited;
      this.stated = found.effects;
      this.drawRungs();
      fill(this.about, h('details', { class: 'card' }, h('summary', {}, 'experiment.toml'), h('pre', {}, found.text)));
    } catch (error) {
      if (!current()) throw error;
      this.text = null;
      fill(this.ladder, h('p', { class: 'bad' }, error.message));
      fill(this.about, '');
      throw error;
    }
  }

  async start(task, body = {}) {
    const { name } = this;
    // A second click does not start a second job.
    this.setBusy(true);
    try {
      say('');
      this.follow(await post(`/api/experiment/${path(name)}/${task}`, body));
    } catch (error) {
      say(error.message, 'bad');
      if (this.name === name) this.showProgress(null);
    }
  }

  async follow(job) {
    const name = job.subject;
    if (this.name === name) this.showProgress(jobs.get(job.number) ?? job);
    try {
      const found = await result(job);
      if (job.task === 'add' || job.task === 'undo') { await this.readList(); if (this.name === name) await this.readLadder(); }
      if (this.name === name && job.number >= (this.shownJob ?? 0)) this.show(job, found);
    } catch (error) {
      const cancelled = error.name === 'Cancelled';
      const text = cancelled ? `${job.title}: ${error.message}` : error.message;
      say(this.name === name ? text : `${name}: ${text}`, cancelled ? '' : 'bad');
      // Without a model that was fitted there is nothing to see: the fit can be begun again.
      if (this.name === name && !this.found) fill(this.statement, h('span', { class: cancelled ? '' : 'bad' }, text), ' ', h('button', { class: 'small', onclick: () => { fill(this.statement, ''); this.start('compare'); } }, 'Compare'));
    }
    if (this.name === name) this.showProgress(this.active(name));
  }

  /** The job of an experiment that is running or waiting, the last one; null when there is none. */
  active(name) { return [...jobs.values()].filter((job) => job.subject === name && TASKS.has(job.task) && !job.passing && (job.state === 'running' || job.state === 'waiting')).at(-1) ?? null; }

  jobChanged(job) { if (!job.passing && job.subject === this.name && TASKS.has(job.task) && (job.state === 'running' || job.state === 'waiting')) this.showProgress(job); }

  showProgress(job) {
    const busy = job !== null;
    this.setBusy(busy);
    if (!busy) { fill(this.progress, ''); this.line = null; return; }
    // The elements of a job stay: a button that is made anew at each step cannot be clicked.
    if (this.line?.number !== job.number || !this.line.bar.isConnected) {
      this.line = { number: job.number, step: h('span', { class: 'dim step' }), bar: h('progress', { 'aria-label': job.title }) };
      fill(this.progress, h('b', {}, job.title), this.line.step, this.line.bar, h('button', { class: 'small', onclick: () => cancel(job) }, 'Cancel'));
    }
    const { step, bar } = this.line;
    step.textContent = words(job.step || 'waiting');
    if (job.total > 0) { bar.max = job.total; bar.value = job.done; } else bar.removeAttribute('value');
  }

  setBusy(busy) {
    for (const button of [this.diagnose, this.suggest]) button.disabled = busy;
    this.undo.disabled = busy || (this.rungs?.length ?? 0) < 2;
    for (const button of this.ranking.querySelectorAll('button.add')) button.disabled = busy;
    this.sliders.busy = busy;
  }

  // Results -----------------------------------------------------------------------------------------------------------

  show(job, found) {
    if (job.task === 'suggest') { this.showSuggestion(found); return; }
    if (job.task === 'export') { this.showExport(found); return; }
    const view = found.comparison ?? found;
    this.found = found;
    this.shownJob = job.number;
    // Values that were changed belong to the model before.
    this.sliders.clear();
    this.middle.classList.remove('blank');
    this.job = job;
    this.mapsOf = { model: view.maps, ...view.maps_of };
    this.models = new Map((view.overlays[0]?.models ?? []).filter((name) => name !== 'model').map((name) => [name, this.labelOf(name, view.document)]));
    for (const name of this.drawn) if (!this.models.has(name)) this.drawn.delete(name);
    if (!this.models.has(this.chosen)) this.chosen = null;
    this.overlay.show(job.number, view.overlays);
    this.drawRungs();
    fill(this.statement, view.statement);
    this.warn(view.document.warnings ?? []);
    this.raw.open = false;
    if (job.task === 'diagnose') this.showDiagnosis(found); else this.showComparison(view);
    this.report.hidden = this.json.hidden = this.language.hidden = false;
    this.report.href = `/api/experiment/${path(this.name)}/report`;
    this.json.href = `/api/jobs/${job.number}/result`;
    this.drawModels();
    this.see();
  }

  /** A model in words, with its error over the noise: of a candidate, or of a rung of the ladder. */
  labelOf(name, document) {
    const rung = name.startsWith('rung ') ? this.rungs?.[Number(name.slice(5))] : null;
    const row = document.ranking?.find((one) => one.effect === name);
    const over = rung ? worst(rung.before) : row?.over_noise ?? null;
    return `${rung ? name : `with ${words(name)}`}${over === null ? '' : ` ${times(over)}`}`;
  }

  drawRungs() { drawLadder(this.ladder, this.rungs ?? [], this.stated ?? [], this.edited, (name) => (this.models?.has(name) ? this.tick(name) : null)); }

  /** A box that draws a model over the record, beside the others that are drawn. */
  tick(name) {
    return h('input', { type: 'checkbox', class: 'tick', checked: this.drawn.has(name), dataset: { model: name }, 'aria-label': `draw ${this.models.get(name)}`, title: 'Draw over the record, beside the others', onclick: (event) => event.stopPropagation(), onkeydown: (event) => event.stopPropagation(), onchange: (event) => { if (event.target.checked) this.drawn.add(name); else this.drawn.delete(name); this.drawModels(); } });
  }

  /** Choose the model whose residual maps are shown, which is drawn as well; null: the fitted one. */
  choosePreview(name) {
    this.chosen = name;
    this.drawModels();
  }

  /** Draw the models that are ticked and the one that is chosen, and the maps of the latter. */
  drawModels() {
    const shown = [...this.drawn, ...(this.chosen && !this.drawn.has(this.chosen) ? [this.chosen] : [])];
    this.overlay.compareWith(shown.map((name) => [name, this.models.get(name)]));
    for (const box of this.section.querySelectorAll('input.tick')) box.checked = this.drawn.has(box.dataset.model);
    for (const [name, element] of this.candidates) {
      element.classList.toggle('chosen', name === this.chosen);
      element.querySelector('button.name').setAttribute('aria-pressed', String(name === this.chosen));
    }
    fill(this.mapOf, h('option', { value: '' }, 'the model'), [...this.models].map(([name, label]) => h('option', { value: name }, label)));
    this.mapOf.value = this.chosen ?? '';
    const maps = this.mapsOf[this.chosen ?? 'model'] ?? [];
    if (maps !== this.mapsShown) drawMaps(this.maps, maps);
    this.mapsShown = maps;
    this.link();
  }

  showComparison(found) {
    const { document } = found;
    this.candidates = new Map();
    fill(this.ranking,
      found.adequate ? h('div', { class: 'card verdict good' }, h('b', {}, 'The residual is at the noise level.')) : h('div', { class: 'card dim' }, h('p', {}, 'Diagnose looks for the effect that is missing: each effect of the library is fitted, and judged on the held-out records.')),
      errorTable(document.before), this.sliders.card(document, found.sliders ?? []), this.records(found));
  }

  showDiagnosis(found) {
    const { document } = found;
    const best = Math.max(...document.ranking.map((row) => row.reduction ?? row.expected_reduction ?? 0), 1e-9);
    this.candidates = new Map();
    fill(this.ranking,
      h('div', { class: `card verdict ${document.verdict}` }, h('b', {}, words(found.title ?? '')),
        document.indistinguishable.length ? h('p', { class: 'warn' }, found.ties) : null,
        document.unexplained_share > 0.05 ? h('p', { class: 'dim' }, `${Math.round(100 * document.unexplained_share)} % of the misfit stays unexplained`) : null,
        found.remarks.map((text) => h('p', { class: 'dim' }, text)),
        document.swaps.map((swap) => this.replacement(swap)), this.addAll(document)),
      h('div', { class: 'ranking' },
        h('div', { class: 'rank-head dim' }, h('span', {}), h('span', {}, 'candidate'), h('span', { title: 'share of the error on the held-out records that it removes' }, 'removed'), h('span', { class: 'num' }, '× noise'), h('span', {})),
        inOrder(document.ranking).map((row) => this.candidate(row, best, document))),
      errorTable(document.before, 'Error of the present model'), this.sliders.card(document, [], document.effect ? `Fitted values with ${words(document.effect)}` : 'Fitted values'), this.records(found));
    const first = document.effect ?? document.ranking[0]?.effect;
    if (this.models.has(first) && document.verdict !== 'adequate') this.chosen = first;
  }

  addAll({ ledger }) {
    const certain = ledger.filter((row) => row.state === 'established');
    if (certain.length < 2) return null;
    return h('button', { class: 'small add', title: 'stagecad add --all', onclick: () => this.start('add', { every: true }) }, `Add all ${certain.length}: ${certain.map((row) => words(row.effect)).join(', ')}`);
  }

  replacement({ instead_of: old, effect }) {
    const command = `stagecad add ${effect ? `${effect} ` : ''}--drop ${old}`;
    const title = effect ? `Replace ${words(old)} by ${words(effect)}` : `Remove ${words(old)}`;
    return h('button', { class: 'small add', title: command, onclick: () => this.start('add', { effects: effect ? [effect] : [], drop: [old] }) }, title);
  }

  candidate(row, best, document) {
    const share = row.reduction ?? row.expected_reduction ?? 0;
    const bar = h('i', { class: 'fill' });
    bar.style.width = `${Math.max(0, Math.min(1, share)) * 100}%`;
    const fitted = row.reduction !== undefined;
    const tie = document.indistinguishable.includes(row.effect);
    const certain = row.effect === document.effect || document.ledger.some((one) => one.effect === row.effect && one.state === 'established');
    const add = h('button', { class: `small add${certain ? ' main' : ''}`, title: `stagecad add ${row.effect}`, onclick: (event) => { event.stopPropagation(); this.start('add', { effects: [row.effect] }); } }, 'Add');
    const details = h('div', { class: 'values dim' }, Object.entries(row.parameters ?? {}).map(([key, value]) => h('span', {}, `${words(key.split('.').at(-1))} ${quantity(value)}`)), row.implausible ? h('span', { class: 'warn' }, row.implausible) : null);
    const element = h('div', {
      class: `candidate${row.effect === document.effect ? ' named' : ''}${tie ? ' tie' : ''}${fitted ? '' : ' estimated'}`, dataset: { effect: row.effect },
      onclick: () => { if (fitted) this.choosePreview(this.chosen === row.effect ? null : row.effect); },
    }, this.models.has(row.effect) ? this.tick(row.effect) : h('span', {}),
    h('button', { class: 'name', disabled: !fitted, title: fitted ? `${words(row.effect)}: show its prediction, and what it leaves` : `${words(row.effect)}: estimated from the sensitivity, not fitted in full` }, words(row.effect), tie ? h('em', {}, ' tie') : null), h('span', { class: 'track', title: `${fitted ? '' : 'about '}${Math.round(100 * share)} % of the error removed` }, bar), h('span', { class: 'num' }, fitted ? times(row.over_noise) : '–'), add, details);
    this.candidates.set(row.effect, element);
    return element;
  }

  records(found) {
    return h('div', { class: 'card' }, h('h3', {}, 'Records'), h('table', {}, found.records.map((record) => h('tr', { title: record.notes.join('\n') },
      h('td', {}, record.name), h('td', { class: 'dim' }, record.role === 'fit' ? 'fit' : 'held out'), h('td', { class: 'num' }, `${record.rows} rows`), h('td', { class: 'num' }, `${number(record.seconds, 3)} s`)))),
    h('p', { class: 'dim' }, `${words(found.rig.kind)}${found.rig.rotary ? ', rotary' : ''}. Noise: ${found.noise}`));
  }

  showSuggestion(found) {
    this.ranking.querySelector('.suggestion')?.remove();
    const best = found.document.slice(0, 6);
    this.ranking.prepend(h('div', { class: 'card suggestion' }, h('h3', {}, 'Next measurement'), found.statements.map((text) => h('p', {}, text)),
      h('table', {}, h('thead', {}, h('tr', {}, h('th', {}, 'motion'), h('th', { class: 'num' }, 'time'), h('th', { class: 'num' }, 'separates'))),
        h('tbody', {}, best.map((row) => h('tr', { title: `${row.reason}\n${row.file}` }, h('td', {}, row.motion), h('td', { class: 'num' }, `${number(row.seconds, 3)} s`), h('td', { class: 'num' }, row.deviations ? `${number(row.deviations, 3)} σ` : '–'))))),
      h('p', { class: 'dim', title: best[0]?.file }, `Written as CSV files to ${best[0]?.file.split(/[\\/]/).slice(-4, -1).join('/')}`)));
    this.ranking.scrollTop = 0;
  }

  showExport(found) {
    this.ranking.querySelector('.exported')?.remove();
    const file = (name) => h('p', {}, h('a', { class: 'report', href: `/api/experiment/${path(this.name)}/export/${name}`, download: name }, name));
    this.ranking.prepend(h('div', { class: 'card exported' }, h('h3', {}, 'Exported model'), found.names.map(file), found.left_out.map((text) => h('p', { class: 'dim' }, `left out: ${text}`))));
    this.ranking.scrollTop = 0;
  }

  async copy(example) {
    try {
      const { name } = await post(`/api/examples/${encodeURIComponent(example)}`);
      await this.readList();
      await this.choose(name);
    } catch (error) { say(error.message, 'bad'); }
  }

  async take(files) {
    this.section.classList.remove('dropping');
    if (!files.length) return;
    const name = await importFiles(files).catch((error) => { say(error.message, 'bad'); return null; });
    if (name) { await this.readList(); this.choose(name); }
  }

  key(event) {
    if (this.section.hidden || document.querySelector('dialog[open]') || event.target.closest?.('input, select, textarea') || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === 'd' && !this.diagnose.disabled) this.start('diagnose', { all_effects: false });
  }
}

/** The candidates fitted in full as they are ranked, then the others by what they are estimated to remove. */
const inOrder = (ranking) => [...ranking.filter((row) => row.reduction !== undefined), ...ranking.filter((row) => row.reduction === undefined).sort((a, b) => (b.expected_reduction ?? 0) - (a.expected_reduction ?? 0))];

const path = (name) => name.split('/').map(encodeURIComponent).join('/');

function errorTable(errors, title = 'Error of the model') {
  const rows = [['fit', 'fit'], ['validate', 'held out']].flatMap(([role, name]) => Object.entries(errors[role] ?? {}).map(([channel, m]) => [name, channel, m]));
  return h('div', { class: 'card' }, h('h3', {}, title), h('table', { class: 'errors' },
    h('thead', {}, h('tr', {}, h('th', {}, 'records'), h('th', {}, 'channel'), h('th', { class: 'num' }, 'rms'), h('th', { class: 'num' }, '× noise'))),
    h('tbody', {}, rows.map(([name, channel, m]) => h('tr', { title: m.fit_percent === null ? '' : `fit ${m.fit_percent.toFixed(1)} %` }, h('td', {}, name), h('td', {}, words(channel)), h('td', { class: 'num' }, quantity(m.rms)), h('td', { class: 'num' }, times(m.over_noise)))))));
}


export async function open(section) {
  const measurement = new Measurement(section);
  await measurement.start_();
  return measurement;
}
