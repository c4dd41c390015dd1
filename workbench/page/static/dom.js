// Small helpers to make elements. Text is always set as text, never as HTML.

/** An element with properties (class, dataset, aria, on* listeners) and children (elements, text, or nothing). */
export function h(tag, properties = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (name.startsWith('on')) element.addEventListener(name.slice(2), value);
    else if (name === 'class') element.className = value;
    else if (name === 'dataset') Object.assign(element.dataset, value);
    else if (name in element && typeof value !== 'string') element[name] = value;
    else element.setAttribute(name, value === true ? '' : value);
  }
  element.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** Replace the children of an element. */
export function fill(element, ...children) {
  element.replaceChildren(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return element;
}

/** `distance_since_reversal` as words. */
export const words = (key) => String(key).replaceAll('_', ' ');

const PREFIXES = [[1e9, 'G'], [1e6, 'M'], [1e3, 'k'], [1, ''], [1e-3, 'm'], [1e-6, 'µ'], [1e-9, 'n'], [1e-12, 'p']];
const PREFIXED = new Set(['m', 'N', 's', 'V', 'rad', 'Hz', 'm/s', 'N/m', 'N*s/m', 'Pa', 'J', 'W', 'N*m', 'm/s^2', 'rad/s']);

/** A unit as it is printed: `N·s/m²`. */
export const unitText = (unit) => (unit === '1' || !unit ? '' : unit.replaceAll('*', '·').replaceAll('^2', '²').replaceAll('^3', '³').replace('degC', '°C'));

/** Factor and unit that bring SI values of a size into a readable range. */
export function scaleOf(size, unit) {
  if (unit === 'kg') return Math.abs(size) < 0.1 && size ? { factor: 1e3, unit: 'g' } : { factor: 1, unit: 'kg' };
  if (!PREFIXED.has(unit) || !Number.isFinite(size) || size === 0) return { factor: 1, unit: unitText(unit) };
  const a = Math.abs(size) * 1.0000001;
  const [value, prefix] = PREFIXES.find(([v]) => a >= v) ?? PREFIXES.at(-1);
  return { factor: 1 / value, unit: prefix + unitText(unit) };
}

/** A number with so many significant digits, without an exponent where that is readable. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return '–';
  const a = Math.abs(value);
  if (a !== 0 && (a >= 1e6 || a < 1e-4)) return value.toExponential(digits - 1).replace('e+', 'e').replace('-', '−');
  return String(Number(value.toPrecision(digits))).replace('-', '−');
}

/** An SI quantity `{value, unit}` with a prefix. */
export function quantity(q, digits = 4) {
  if (!q || q.value === null || q.value === undefined) return '–';
  const { factor, unit } = scaleOf(q.value, q.unit);
  return `${number(q.value * factor, digits)}${unit ? ' ' + unit : ''}`;
}

/** `23 ×`: an error over the noise. */
export function times(value) {
  if (value === null || value === undefined) return '–';
  return `${value < 10 ? value.toPrecision(2) : value < 1e4 ? Math.round(value) : value.toExponential(1)} ×`;
}

/** Call `f` at most once per animation frame, with the last arguments. */
export function eachFrame(f) {
  let asked = false;
  let last;
  return (...args) => {
    last = args;
    if (asked) return;
    asked = true;
    requestAnimationFrame(() => { asked = false; f(...last); });
  };
}

/**
 * Counts requests, so that a late answer does not replace that of a newer one: `const current = turn();` before the
 * request, and after it `if (!current()) return;`.
 */
export function newest() {
  let last = 0;
  return () => { const mine = ++last; return () => mine === last; };
}

/** Value of a colour of the theme. */
export const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();

/** A line in the status bar; errors stay until the next message. */
export function say(text, kind = '') {
  const place = document.getElementById('message');
  place.textContent = text;
  place.className = kind;
  place.title = text;
}

/** Clear the message if it is still this text: another one may have been shown since. */
export function withdraw(text) { if (document.getElementById('message').textContent === text) say(''); }

/** The query of an address of the page: names and values that are not empty. */
export const query = (values) => new URLSearchParams(Object.entries(values).filter(([, value]) => value !== null && value !== undefined && value !== '')).toString();

/** Write the address of what is shown, so that it can be kept or sent: `#VIEW/PATH?QUERY`. */
export function setAddress(section, path, values = {}) {
  if (section.hidden) return;
  const text = query(values);
  history.replaceState(null, '', `#${[section.id, ...path].map(encodeURIComponent).join('/')}${text ? `?${text}` : ''}`);
}

/** A short line in a colour, for a legend. */
export const swatch = (ink) => { const s = h('i', { class: 'swatch' }); s.style.background = ink; return s; };

/** An entry of a legend that switches its curve: `hidden` is the set of the labels that are not drawn. */
export function legendItem(ink, label, hidden, redraw) {
  return h('button', { 'aria-pressed': String(!hidden.has(label)), title: `show or hide: ${label}`, onclick: () => { if (!hidden.delete(label)) hidden.add(label); redraw(); } },
    swatch(ink.startsWith('#') ? ink : `var(--${ink})`), label);
}
