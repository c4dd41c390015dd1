// The page of an empty folder: three ways to begin.
import { post } from './api.js';
import { fill, h } from './dom.js';

export async function open(section) {
  const demo = async () => {
    const { name } = await post('/api/examples/demo');
    location.hash = `measurement/${encodeURIComponent(name)}`;
  };
  const card = (title, text, ...actions) => h('div', { class: 'door' }, h('h2', {}, title), h('p', {}, text), h('p', { class: 'actions' }, actions));
  const link = (view, text) => h('a', { class: 'go', href: `#${view}` }, text);
  fill(section, h('div', { class: 'doors' },
    card('I measure a rig', 'Drop files of a logger, and see which physical effect the model misses.', link('measurement', 'Measurement'), h('button', { class: 'main', onclick: demo }, 'Try the demo')),
    card('I design a stage', 'Change a dimension, and see parts, drawings and the margin of every check.', link('machine', 'Machine')),
    card('I study friction', 'Compare friction models in the experiments that tell them apart.', link('simulation', 'Simulation'))));
  return {};
}
