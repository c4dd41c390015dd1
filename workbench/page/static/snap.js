// Where a measurement holds: corners, edges, centres of round edges, and faces of a part. All in its coordinates, mm.
import * as THREE from './vendor/three.min.js';

/** Two ends are the same point within this distance, and points lie on one circle. */
const SAME = 1e-3;
const LEAST_POINTS = 5;
/** Largest angle between neighbouring chords of a round edge: a hexagon has 60 degrees. */
const MOST_TURN = (36 * Math.PI) / 180;
/** Distance from the circle up to which a point lies on it, in lengths of its chord. */
const OFF = 0.02;
/** Least angle over which an arc is taken for a round edge. */
const LEAST_TURN = (30 * Math.PI) / 180;

/** The feature edges of a part as segments, with the segments that meet in each point. */
export class Edges {
  constructor(geometry) {
    const at = geometry.getAttribute('position');
    this.ends = Array.from({ length: at.count }, (_, k) => new THREE.Vector3().fromBufferAttribute(at, k));
    this.meeting = new Map();
    this.ends.forEach((end, k) => { const key = name(end); this.meeting.set(key, [...(this.meeting.get(key) ?? []), k]); });
  }

  /** The nearest point on an edge within a reach of a point: `{point, corner, segment}`, or null. */
  nearest(point, reach) {
    const [along, on] = [new THREE.Vector3(), new THREE.Vector3()];
    let best = null;
    let least = reach;
    for (let k = 0; k < this.ends.length; k += 2) {
      along.subVectors(this.ends[k + 1], this.ends[k]);
      const share = on.subVectors(point, this.ends[k]).dot(along) / (along.lengthSq() || 1);
      const far = on.copy(this.ends[k]).addScaledVector(along, Math.min(Math.max(share, 0), 1)).distanceTo(point);
      if (far < least) { least = far; best = { point: on.clone(), segment: k }; }
    }
    if (!best) return null;
    const corner = [best.segment, best.segment + 1].map((k) => this.ends[k]).find((end) => end.distanceTo(point) < reach) ?? null;
    return { ...best, corner };
  }

  /** The end of the other segment that alone meets a segment in its end `k`: `[next end, its index]`, or null. */
  beyond(k) {
    const others = this.meeting.get(name(this.ends[k])).filter((one) => one !== k);
    return others.length === 1 ? others[0] ^ 1 : null;
  }

  /** The circle that a segment lies on with its neighbours: `{centre, radius, axis}`, or null for a straight edge. */
  circle(segment) {
    const [before, after] = [this.beyond(segment), this.beyond(segment + 1)];
    if (before === null || after === null) return null;
    const round = through(this.ends[before], this.ends[segment], this.ends[segment + 1]);
    if (!round) return null;
    // The points of the arc in their order, from the segment to both sides.
    const sides = [segment, segment + 1].map((first) => {
      const points = [this.ends[first]];
      let [from, k] = [this.ends[first ^ 1], first];
      while (points.length < this.ends.length) {
        const next = this.beyond(k);
        if (next === null || next >> 1 === segment >> 1) break;
        const [here, there] = [this.ends[k], this.ends[next]];
        const turn = here.clone().sub(from).angleTo(there.clone().sub(here));
        const off = Math.abs(there.distanceTo(round.centre) - round.radius) + Math.abs(there.clone().sub(round.centre).dot(round.axis));
        if (turn > MOST_TURN || off > SAME + OFF * there.distanceTo(here)) break;
        points.push(there);
        [from, k] = [here, next];
        if (next >> 1 === (segment + 1) >> 1) break;
      }
      return points;
    });
    // On a closed edge either side goes all the way round.
    const closed = sides[0].length > 2 && name(sides[0].at(-1)) === name(this.ends[segment + 1]);
    const arc = closed ? sides[0].slice(0, -1) : [...sides[0].reverse(), ...sides[1]];
    const chords = arc.slice(1).map((point, k) => point.clone().sub(arc[k]));
    const turned = chords.slice(1).reduce((sum, chord, k) => sum + chord.angleTo(chords[k]), 0);
    // A straight edge of many segments turns by next to nothing.
    if (arc.length < LEAST_POINTS || turned < LEAST_TURN) return null;
    const third = Math.floor(arc.length / 3);
    return through(arc[0], arc[third], arc[2 * third]);
  }
}

const name = (point) => point.toArray().map((v) => Math.round(v / SAME)).join();

/** The circle through three points, or null where they lie on a line. */
function through(a, b, c) {
  const [ab, ac] = [b.clone().sub(a), c.clone().sub(a)];
  const axis = ab.clone().cross(ac);
  const square = axis.lengthSq();
  if (square < 1e-12 * ab.lengthSq() * ac.lengthSq() || square === 0) return null;
  const out = axis.clone().cross(ab).multiplyScalar(ac.lengthSq()).add(ac.clone().cross(axis).multiplyScalar(ab.lengthSq())).divideScalar(2 * square);
  return { centre: a.clone().add(out), radius: out.length(), axis: axis.normalize() };
}
