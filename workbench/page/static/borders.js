// Borders between panels that are moved by the mouse, or by the arrow keys; a double click brings the usual place back.
import { h } from './dom.js';

const KEPT = 'borders';
const LEAST = 120;

const sizes = (() => { try { return JSON.parse(localStorage.getItem(KEPT)) ?? {}; } catch { return {}; } })();
const root = document.documentElement.style;

/** The size as a CSS length, and `--NAME-grow` for elements that share what room there is as long as it is not set. */
function apply(name, size) {
  root.setProperty(`--${name}`, `${size}px`);
  root.setProperty(`--${name}-grow`, '0');
}

function set(name, size) {
  if (size === null) {
    delete sizes[name];
    for (const one of [`--${name}`, `--${name}-grow`]) root.removeProperty(one);
  } else apply(name, sizes[name] = Math.round(size));
  localStorage.setItem(KEPT, JSON.stringify(sizes));
  // Plots and the machine are drawn anew for their new size.
  dispatchEvent(new Event('resize'));
}

for (const [name, size] of Object.entries(sizes)) if (Number.isFinite(size)) apply(name, size);

/**
 * Put a border on an edge of an element, whose size is then kept in the CSS variable `--NAME`.
 * @param {HTMLElement} element  is resized
 * @param {'left'|'right'|'top'|'bottom'} edge
 * @param {string} name
 * @param {string} label  for readers of the screen
 */
export function movable(element, edge, name, label) {
  const upright = edge === 'left' || edge === 'right';
  const sign = edge === 'right' || edge === 'bottom' ? 1 : -1;
  const present = () => (upright ? element.offsetWidth : element.offsetHeight);
  const most = () => 0.7 * (upright ? innerWidth : innerHeight);
  const move = (size) => { set(name, Math.min(Math.max(size, LEAST), most())); tell(); };
  const tell = () => { bar.setAttribute('aria-valuenow', String(present())); bar.setAttribute('aria-valuemax', String(Math.round(most()))); };
  let from = null;
  const bar = h('div', {
    class: `border ${edge}`, role: 'separator', tabindex: '0', 'aria-label': label, 'aria-orientation': upright ? 'vertical' : 'horizontal', 'aria-valuemin': String(LEAST), title: 'Drag to move; a double click brings it back',
    onpointerdown: (event) => { from = [upright ? event.clientX : event.clientY, present()]; bar.setPointerCapture(event.pointerId); event.preventDefault(); },
    onpointermove: (event) => { if (from) move(from[1] + sign * ((upright ? event.clientX : event.clientY) - from[0])); },
    onpointerup: () => { from = null; },
    ondblclick: () => { set(name, null); tell(); },
    onkeydown: (event) => {
      const step = { ArrowRight: 1, ArrowLeft: -1, ArrowDown: 1, ArrowUp: -1 }[event.key];
      if (!step || upright !== /Left|Right/.test(event.key)) return;
      event.preventDefault();
      move(present() + sign * step * 16);
    },
    onfocus: () => tell(),
  });
  element.append(bar);
  requestAnimationFrame(tell);
}

/** Borders of the three panels of a view: beside each other in a wide window, the third below in a narrower one. */
export function movablePanels(view, left, right) {
  movable(left, 'right', `${view}-left`, 'border of the left panel');
  movable(right, 'left', `${view}-right`, 'border of the right panel');
  movable(right, 'top', `${view}-below`, 'border above the lower panel');
}
