// A plot as a file: its picture (PNG), or the numbers that it draws (CSV).
import { colour, h } from './dom.js';

function download(content, name) {
  const link = h('a', { href: URL.createObjectURL(content), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

/** Name of a file: letters, digits and `_` of a text. */
const fileName = (text) => text.replace(/[^\p{L}\p{N}]+/gu, '_').replace(/^_|_$/g, '') || 'plot';

/** Canvas of a plot with its legend above, on the ground of the page. */
function picture({ canvas, legend, title }) {
  const size = parseFloat(getComputedStyle(document.documentElement).fontSize) * (canvas.width / canvas.clientWidth);
  const whole = h('canvas', { width: canvas.width, height: canvas.height + Math.round(2 * size) });
  const c = whole.getContext('2d');
  c.fillStyle = colour('panel');
  c.fillRect(0, 0, whole.width, whole.height);
  c.font = `${size}px system-ui, "DejaVu Sans", sans-serif`;
  c.textBaseline = 'middle';
  let x = size;
  const write = (text, ink) => { c.fillStyle = ink; c.fillText(text, x, size); x += c.measureText(text).width + size; };
  write(title, colour('text'));
  for (const { label, ink } of legend) {
    c.fillStyle = ink.startsWith('#') ? ink : colour(ink);
    c.fillRect(x, size - size / 8, 1.2 * size, size / 4);
    x += 1.6 * size;
    write(label, colour('text'));
  }
  c.drawImage(canvas, 0, Math.round(2 * size));
  return whole;
}

const cell = (value) => (value === null || value === undefined || Number.isNaN(value) ? '' : typeof value === 'number' ? String(value) : `"${value.replaceAll('"', '""')}"`);

/** Columns `[name, values]` of any lengths as comma-separated values. */
export function csvText(columns) {
  const rows = Math.max(0, ...columns.map(([, values]) => values.length));
  const lines = [columns.map(([name]) => cell(name))];
  for (let k = 0; k < rows; k++) lines.push(columns.map(([, values]) => cell(values[k])));
  return `${lines.map((line) => line.join(',')).join('\n')}\n`;
}

/**
 * Buttons over a plot that are seen under the pointer or the focus.
 * @param {() => {title: string, canvas: HTMLCanvasElement, legend: {label: string, ink: string}[], columns: [string, ArrayLike<number>][]}} drawn
 */
export function saveButtons(drawn) {
  const button = (kind, title, act) => h('button', { class: 'small', title, 'aria-label': `${title}: ${drawn().title}`, onclick: (event) => { event.stopPropagation(); act(drawn()); } }, kind);
  return h('span', { class: 'save' },
    button('PNG', 'Picture of this plot', (one) => picture(one).toBlob((content) => download(content, `${fileName(one.title)}.png`))),
    button('CSV', 'The numbers drawn here; zoom in for every sample', (one) => download(new Blob([csvText(one.columns)], { type: 'text/csv' }), `${fileName(one.title)}.csv`)));
}
