// Residual maps: mean residual, in deviations of the noise, over each coordinate.
import { h, fill, number, scaleOf, words } from './dom.js';
import { XyPlot } from './plot.js';

let plots = [];
let redraw = () => {};
addEventListener('themechange', () => redraw());

/** Draw the maps of one model: the fitted one, or the one that was chosen. */
export function drawMaps(place, maps) {
  redraw = () => drawMaps(place, maps);
  for (const plot of plots) plot.destroy();
  plots = [];
  fill(place, maps.map((map) => {
    const share = Math.round(100 * map.share);
    return h('figure', { class: 'map' },
      h('figcaption', { title: `explains ${share} % of the residual's variance; p ${map.p_value <= 0.0015 ? '< 0.001' : `= ${number(map.p_value, 2)}`}` },
        h('span', {}, words(map.coordinate)), h('span', { class: share >= 10 ? 'bad' : 'dim' }, `${share} %`)),
      h('div', { class: 'plot' }));
  }));
  maps.forEach((map, k) => {
    const { factor, unit } = scaleOf(Math.max(...map.centres.map(Math.abs)), map.unit);
    const plot = new XyPlot(place.children[k].lastChild, { x: unit, y: '', title: `residual over ${words(map.coordinate)}`, xFactor: factor });
    if (map.coordinate === 'frequency') {
      plot.set([{ x: map.centres, y: map.forward.map((v) => v ?? 0), ink: 'accent', label: 'residual', width: 1.2 }]);
    } else {
      const sets = [['backward', 'map-backward'], ['forward', 'map-forward']].flatMap(([side, ink]) => {
        const kept = map.centres.map((x, i) => [x, map[side][i], map[`${side}_error`][i]]).filter(([, y]) => y !== null);
        const bars = kept.flatMap(([x, y, e]) => (e ? [{ x: [x, x], y: [y - 2 * e, y + 2 * e], ink, width: 1 }] : []));
        return [...bars, { x: kept.map(([x]) => x), y: kept.map(([, y]) => y), ink, label: side, width: 1.4 }, { x: kept.map(([x]) => x), y: kept.map(([, y]) => y), ink, points: true, width: 4 }];
      });
      plot.set(sets);
    }
    plots.push(plot);
  });
}
