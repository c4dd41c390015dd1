// A record before any fit: each column as a small curve, and a strip of all channels on which a part is chosen.
import { colour, h } from './dom.js';

const LANE = 26;

/** A canvas as large as it is shown, and its context in CSS pixels; null while it is not shown. */
function prepared(canvas) {
  const { clientWidth: width, clientHeight: height } = canvas;
  if (!width || !height) return null;
  const ratio = Math.min(devicePixelRatio, 2);
  Object.assign(canvas, { width: Math.round(width * ratio), height: Math.round(height * ratio) });
  const c = canvas.getContext('2d');
  c.setTransform(ratio, 0, 0, ratio, 0, 0);
  c.clearRect(0, 0, width, height);
  return { c, width, height };
}

/** Draw extremes of stretches (least, largest, least, ...) from `top` on; null: no number. */
function drawExtremes(c, values, width, top, height, ink) {
  const numbers = values.filter((v) => v !== null);
  if (!numbers.length) return;
  const [low, high] = [Math.min(...numbers), Math.max(...numbers)];
  const y = (v) => top + height - 2 - ((v - low) / (high - low || 1)) * (height - 4);
  c.strokeStyle = ink;
  c.lineWidth = 1;
  c.beginPath();
  let pen = false;
  values.forEach((v, k) => {
    if (v === null) { pen = false; return; }
    const x = (k / Math.max(values.length - 1, 1)) * width;
    if (pen) c.lineTo(x, y(v)); else c.moveTo(x, y(v));
    pen = true;
  });
  c.stroke();
}

export function drawSpark(canvas, values) {
  const drawn = values && prepared(canvas);
  if (drawn) drawExtremes(drawn.c, values, drawn.width, 0, drawn.height, colour('accent'));
}

export class RecordStrip {
  /** @param {{file: string, rows: number, columns: Record<string, (number|null)[]>}} preview */
  constructor(preview) {
    this.preview = preview;
    this.from = this.field('from');
    this.to = this.field('to');
    this.ends = h('span', { class: 'ends' }, 'from', this.from, 'to', this.to);
    this.element = h('canvas', { class: 'strip', role: 'img', 'aria-label': `channels of ${preview.file}` });
    let begin = null;
    const share = (event) => { const box = this.element.getBoundingClientRect(); return Math.min(Math.max((event.clientX - box.left) / box.width, 0), 1); };
    this.element.addEventListener('pointerdown', (event) => { if (this.time) { begin = share(event); this.element.setPointerCapture(event.pointerId); } });
    this.element.addEventListener('pointermove', (event) => { if (begin !== null) this.choose(begin, share(event)); });
    this.element.addEventListener('pointerup', () => { begin = null; });
    this.element.addEventListener('dblclick', () => { this.from.value = this.to.value = ''; this.draw(); });
  }

  field(end) {
    return h('input', { type: 'text', spellcheck: 'false', placeholder: end === 'from' ? 'its first row' : 'its last row', 'aria-label': `${end}: time in ${this.preview.file}`, title: 'A time with its unit; with + it counts from the first row', onchange: () => this.draw() });
  }

  /** The window of time as `experiment.toml` has it. */
  get range() {
    const [from, to] = [this.from.value.trim(), this.to.value.trim()];
    return { ...(from ? { from } : {}), ...(to ? { to } : {}) };
  }

  /**
   * @param {[string, string][]} channels  label of the column, and name of the channel
   * @param {{label: string, unit: string}|undefined} time
   */
  show(channels, time) {
    this.channels = channels.filter(([label]) => this.preview.columns[label]);
    this.time = time && this.preview.columns[time.label]?.every((v) => v !== null) ? { ...time, values: this.preview.columns[time.label] } : null;
    this.from.disabled = this.to.disabled = !this.time;
    this.element.style.height = `${Math.max(this.channels.length, 1) * LANE}px`;
    this.draw();
  }

  /** Take the part between two shares of the rows. */
  choose(one, other) {
    const at = (share) => {
      const { values, unit } = this.time;
      const place = share * (values.length - 1);
      const k = Math.min(Math.floor(place), values.length - 2);
      const value = values[k] + (place - k) * (values[k + 1] - values[k]) - values[0];
      return `+${Number(value.toPrecision(4))} ${unit}`;
    };
    const [first, last] = [Math.min(one, other), Math.max(one, other)];
    if (last - first < 0.005) return;
    this.from.value = first > 0.002 ? at(first) : '';
    this.to.value = last < 0.998 ? at(last) : '';
    this.draw();
  }

  /** Share of the rows before a time that a field names; `usual` where it names none. */
  shareOf(text, usual) {
    const value = Number.parseFloat(text);
    if (!Number.isFinite(value) || !this.time) return usual;
    const { values } = this.time;
    const wanted = text.trim().startsWith('+') ? value + values[0] : value;
    return values.filter((v) => v < wanted).length / values.length;
  }

  draw() {
    const drawn = prepared(this.element);
    if (!drawn || !this.channels) return;
    const { c, width, height } = drawn;
    const ground = colour('text');
    c.font = '11px system-ui, sans-serif';
    this.channels.forEach(([label, name], k) => {
      drawExtremes(c, this.preview.columns[label], width, k * LANE, LANE, colour('accent'));
      c.fillStyle = ground;
      c.fillText(name, 4, k * LANE + 11);
    });
    c.fillStyle = colour('panel');
    c.globalAlpha = 0.75;
    const [from, to] = [this.shareOf(this.from.value, 0) * width, this.shareOf(this.to.value, 1) * width];
    c.fillRect(0, 0, from, height);
    c.fillRect(to, 0, width - to, height);
    c.globalAlpha = 1;
  }
}
