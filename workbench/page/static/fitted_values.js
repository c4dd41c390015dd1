// Fitted values of a model, each with a slider: the prediction with other values is drawn over the record.
import { post, result } from './api.js';
import { h, fill, number, quantity, say, scaleOf, times, words } from './dom.js';

const STEPS = 200;

export class ModelSliders {
  /**
   * @param {(body: object) => Promise<object>} predict  asks for a prediction, and gives its job
   * @param {import('./overlay.js').Overlay} overlay
   */
  constructor(predict, overlay) {
    this.predict = predict;
    this.overlay = overlay;
    this.model = 0;
    this.clear();
  }

  /** Forget the changed values: another model is shown. An answer that is still under way is not drawn. */
  clear() {
    this.model += 1;
    this.values = {};
    this.rows = [];
  }

  /** The card with the values of a document; parameters of `sliders` can be moved. */
  card(document, sliders, title = 'Fitted values') {
    this.clear();
    const movable = new Map(sliders.map((one) => [one.name, one]));
    this.note = h('p', { class: 'dim moved' }, sliders.length ? 'Move a slider to see what the parameter does; a double click brings the fitted value back.' : '');
    return h('div', { class: 'card fitted-card' },
      h('h3', {}, title),
      h('div', { class: 'fitted' }, Object.entries(document.parameters).filter(([, q]) => !q.nuisance).map(([key, q]) => this.row(key, q, movable.get(key)))),
      this.note,
      (document.not_identifiable ?? []).map((text) => h('p', { class: 'dim' }, text)));
  }

  row(key, q, slider) {
    const value = h('span', { class: 'num' }, quantity(q));
    const interval = q.at_bound ? 'at its bound' : q.std === null || q.std === undefined ? 'not determined' : `± ${quantity({ value: 1.96 * q.std, unit: q.unit }, 2)}`;
    const name = h('span', { class: 'name', title: words(key).replace('.', ' · ') }, words(key).replace('.', ' · '));
    if (!slider) return h('div', { class: 'fit-row' }, name, value, h('span', {}), h('span', { class: 'num dim' }, interval));
    const { factor, unit } = scaleOf(slider.value, slider.unit);
    const input = h('input', { type: 'range', min: 0, max: STEPS, step: 1, 'aria-label': `${key}, slider` });
    const place = (v) => Math.round(((v - slider.low) / (slider.high - slider.low)) * STEPS);
    const row = h('div', { class: 'fit-row', dataset: { key: slider.key } }, name, value, input, h('span', { class: 'num dim' }, interval));
    const set = (v) => {
      if (v === null) delete this.values[slider.key]; else this.values[slider.key] = v;
      value.textContent = `${number((v ?? slider.value) * factor)}${unit ? ` ${unit}` : ''}`;
      row.classList.toggle('set', v !== null);
      this.ask();
    };
    input.value = String(place(slider.value));
    input.addEventListener('input', () => set(slider.low + (input.valueAsNumber / STEPS) * (slider.high - slider.low)));
    input.addEventListener('dblclick', () => { input.value = String(place(slider.value)); set(null); });
    this.rows.push(input);
    return row;
  }

  set busy(busy) { for (const input of this.rows) input.disabled = busy; }

  /** One request at a time, the last values always. */
  async ask() {
    if (this.asking) { this.again = true; return; }
    this.asking = true;
    let model;
    try {
      do {
        this.again = false;
        ({ model } = this);
        if (!Object.keys(this.values).length) { this.overlay.moved(null); this.note.textContent = 'The fitted values.'; continue; }
        const { one, one: { record, channel } } = this.overlay;
        const job = await this.predict({ values: this.values, record, channel });
        const found = await result(job);
        // By now another model, or another record, may be shown, or the slider be back at the fitted value.
        if (model !== this.model || one !== this.overlay.one || !Object.keys(this.values).length) continue;
        await this.overlay.moved(job.number, found.overlays[0]);
        const over = Object.entries(found.over_noise.validate)[0] ?? Object.entries(found.over_noise.fit)[0];
        if (over) this.note.textContent = `With these values the error of ${words(over[0])} is ${times(over[1])} the noise.`;
      } while (this.again);
    } catch (error) {
      if (error.name !== 'Cancelled' && model === this.model) say(error.message, 'bad');
    } finally { this.asking = false; }
  }
}

export const predictor = (path) => (body) => post(`/api/experiment/${path}/predict`, body);
