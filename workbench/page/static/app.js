// The page: views, theme, keyboard, connection.
import { get, listen } from './api.js';
import { h, fill, say } from './dom.js';

const VIEWS = { start: () => import('./start.js'), machine: () => import('./machine.js'), simulation: () => import('./simulation.js'), measurement: () => import('./measurement.js') };
const opened = new Map();

/** Show the view of the address, or what the folder holds: `#VIEW/PATH?QUERY`. */
async function show() {
  const [place, values] = location.hash.slice(1).split('?');
  const [name, ...path] = place.split('/').map(decodeURIComponent);
  const view = name in VIEWS ? name : about.begins_with || 'start';
  for (const section of document.querySelectorAll('.view')) section.hidden = section.id !== view;
  for (const tab of document.querySelectorAll('nav [data-view]')) tab.setAttribute('aria-selected', String(tab.dataset.view === view));
  if (!opened.has(view)) {
    opened.set(view, VIEWS[view]().then((module) => module.open(document.getElementById(view))));
  }
  try {
    const shown = await opened.get(view);
    if (!location.hash) history.replaceState(null, '', `#${view}`);
    await shown.shown?.(path, Object.fromEntries(new URLSearchParams(values)));
  } catch (error) {
    opened.delete(view);
    say(error.message, 'bad');
  }
}

function toggleTheme() {
  const theme = document.documentElement.dataset.theme === 'dark' ? 'light' : 'dark';
  document.documentElement.dataset.theme = theme;
  localStorage.setItem('theme', theme);
  dispatchEvent(new Event('themechange'));
}

const KEYS = [
  ['g m · g s · g e', 'Machine, Simulation, Measurement'], ['T', 'light or dark'], ['/', 'search parameters'],
  ['Ctrl Z · Ctrl Shift Z', 'undo, redo a change of the machine'],
  ['1 2 3 4', 'view from front, right, top, oblique'], ['F', 'fit the view'], ['E', 'exploded view'], ['S', 'section'],
  ['M · P', 'measure between two points, tree of parts'], ['Esc', 'end measuring, clear the selection'],
  ['F6', 'the next panel'],
  ['↑ ↓ on a value', 'change it by a hundredth of its range'], ['D', 'diagnose (Measurement)'], ['double click in a curve', 'whole record'],
  ['?', 'this list'],
];

function showKeys() {
  const dialog = document.getElementById('keys');
  fill(dialog, h('h2', {}, 'Keyboard'),
    h('dl', {}, KEYS.map(([key, meaning]) => [h('dt', {}, key), h('dd', {}, meaning)])),
    h('form', { method: 'dialog' }, h('button', {}, 'Close')));
  dialog.showModal();
}

/** Bring the focus to the first control of the next panel, as a skip link does. */
function nextPanel() {
  const panels = [...document.querySelectorAll('.view:not([hidden]) > .panel')];
  const present = panels.findIndex((one) => one.contains(document.activeElement));
  panels[(present + 1) % panels.length]?.querySelector('button:not(:disabled), input:not(:disabled), select, a[href], [tabindex="0"]')?.focus();
}

let before = '';
addEventListener('keydown', (event) => {
  if (event.key === 'F6') { event.preventDefault(); nextPanel(); return; }
  if (event.target.closest?.('input, select, textarea') || event.ctrlKey || event.metaKey || event.altKey) return;
  if (before === 'g' && 'mse'.includes(event.key)) {
    location.hash = { m: 'machine', s: 'simulation', e: 'measurement' }[event.key];
    event.stopImmediatePropagation();
  } else if (event.key === 't' || event.key === 'T') toggleTheme();
  else if (event.key === '?') showKeys();
  before = event.key;
}, true);

document.getElementById('theme').addEventListener('click', toggleTheme);
document.getElementById('help').addEventListener('click', showKeys);
addEventListener('hashchange', show);
// A refused request says why; what was shown before stays.
addEventListener('unhandledrejection', (event) => { say(event.reason?.message ?? String(event.reason), 'bad'); event.preventDefault(); });

let about = { begins_with: '' };
try {
  about = await get('/api/about');
  document.getElementById('folder').textContent = about.folder.split(/[\\/]/).filter(Boolean).at(-1);
  document.getElementById('folder').title = `stagecad ${about.version}, working in ${about.folder}`;
} catch (error) { say(error.message, 'bad'); }
const connected = listen().catch((error) => say(error.message, 'bad'));
await connected;
show();
