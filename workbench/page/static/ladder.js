// The ladder: error over noise after each effect, on a logarithmic axis with the noise at one.
import { h, fill, times, words } from './dom.js';

const largest = (errors) => Math.max(...Object.values(errors ?? {}).map((m) => m.over_noise ?? -Infinity), -Infinity);

/** The largest error over the noise of a rung, on the held-out records where there are any. */
export const worst = ({ fit, validate }) => (Number.isFinite(largest(validate)) ? largest(validate) : largest(fit));

/**
 * @param {(name: string) => HTMLElement|null} draw  gives the control that draws the model of a rung, where there is one
 */
export function drawLadder(place, rungs, effects, edited, draw = () => null) {
  const values = rungs.map((rung) => worst(rung.before));
  const top = Math.max(...values, 10);
  const length = (v) => Math.max(0.02, Math.min(1, Math.log10(Math.max(v, 1) * 1.06) / Math.log10(top * 1.06)));
  fill(place, h('h3', {}, 'Ladder'), edited ? h('p', { class: 'warn' }, '[model] was edited by hand since the last rung') : null,
    rungs.length === 0 ? h('p', { class: 'dim' }, `Model: ${effects.map(words).join(', ') || 'no effects'}. Nothing added yet.`) : null,
    rungs.map((rung, k) => {
      const bar = h('i', { class: values[k] <= 1.5 ? 'fill done' : 'fill' });
      bar.style.width = `${100 * length(values[k])}%`;
      const text = rung.number === 0 || k === 0 ? rung.effects.map(words).join(', ') : [...rung.added.map((name) => `+ ${words(name)}`), ...rung.removed.map((name) => `− ${words(name)}`)].join(', ');
      return h('div', { class: 'rung', title: rung.effects.map(words).join(', ') }, h('span', { class: 'name' }, draw(`rung ${k}`), text || words(rung.effects.at(-1) ?? '')), h('span', { class: 'track' }, bar), h('span', { class: 'num' }, times(values[k])));
    }),
    rungs.length ? h('p', { class: 'dim small' }, 'error over noise on the held-out records, logarithmic; 1 is noise alone') : null);
}
