// The machine in three dimensions: parts as meshes from the server, drawn only when something changed.
import * as THREE from './vendor/three.min.js';
import { h, fill, colour, eachFrame, newest, number, words } from './dom.js';
import { Edges } from './snap.js';

const UP = new THREE.Vector3(0, 0, 1);
const VIEWS = { front: [0, -1, 0], right: [1, 0, 0], top: [0, -0.001, 1], oblique: [1, -1.25, 0.8] };
const AXES = { x: new THREE.Vector3(-1, 0, 0), y: new THREE.Vector3(0, 1, 0), z: new THREE.Vector3(0, 0, -1) };

/** Order of painting: the sections below the solids, the marks above them. */
const [SOLIDS, MARKS] = [1000, 1001];

/** Pixels within which a measurement takes a corner or an edge. */
const REACH = 9;

/** A length in mm, to the micrometre. */
const length = (mm) => number(Math.round(mm * 1000) / 1000 || 0, 6);

export class View3d {
  /**
   * @param {HTMLElement} place
   * @param {(name: string|null) => void} onselect  called with the part selected
   * @param {() => void} onmark  called when another part is under the pointer, hidden or selected
   */
  constructor(place, onselect, onmark = () => {}) {
    Object.assign(this, { place, onselect, onmark });
    this.renderer = new THREE.WebGLRenderer({ antialias: true, stencil: true });
    this.renderer.localClippingEnabled = true;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'machine, three-dimensional');
    this.canvas.setAttribute('role', 'img');
    this.label = h('div', { class: 'measured', role: 'status', hidden: true });
    this.tag = h('div', { class: 'hovered-part', hidden: true });
    place.append(this.canvas, this.label, this.tag);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(24, 1, 1, 20000);
    this.camera.up.copy(UP);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.machine = new THREE.Group();
    this.marks = new THREE.Group();
    // Where the next point of a measurement would be.
    this.aim = new THREE.Points(new THREE.BufferGeometry().setFromPoints([new THREE.Vector3()]), new THREE.PointsMaterial({ sizeAttenuation: false, depthTest: false, transparent: true }));
    this.aim.visible = this.aim.frustumCulled = false;
    this.aim.renderOrder = MARKS;
    this.scene.add(this.machine, this.marks, this.aim);
    this.sky = new THREE.HemisphereLight(0xffffff, 0x8899a6, 1.5);
    this.key = new THREE.DirectionalLight(0xffffff, 2.2);
    this.fillLight = new THREE.DirectionalLight(0xffffff, 0.7);
    this.scene.add(this.sky, this.key, this.fillLight);
    this.plane = new THREE.Plane(AXES.y.clone(), 0);
    this.sheet = new THREE.PlaneGeometry(4000, 4000);
    this.axis = null;
    this.share = 0.5;
    this.explosion = 0;
    this.loader = new THREE.GLTFLoader();
    this.shapes = new Map();
    this.turn = newest();
    this.materials = new Map();
    this.instances = [];
    this.selected = this.hovered = null;
    this.measuring = false;
    this.inset = 0;
    this.picked = [];
    this.hidden = new Set();
    this.ray = new THREE.Raycaster();
    let down = null;
    this.canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    this.canvas.addEventListener('pointerup', (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4 && event.button === 0) this.click(event);
      down = null;
    });
    const look = eachFrame((event) => this.lookAt(event));
    this.canvas.addEventListener('pointermove', (event) => { if (!event.buttons) look(event); });
    this.canvas.addEventListener('pointerleave', () => this.leave());
    new ResizeObserver(() => this.resize()).observe(place);
    addEventListener('themechange', () => this.paint());
    this.paint();
  }

  /** Show the result of a job `solids`; resolves when all parts are drawn, to false when a newer one took its place. */
  async show(result) {
    const current = this.turn();
    const shapes = await Promise.all(Object.entries(result.parts).map(async ([name, { key }]) => [name, await this.load(name, key)]));
    if (!current()) return false;
    const first = this.instances.length === 0;
    const former = this.shapes;
    this.shapes = new Map(shapes);
    for (const [name, shape] of former) if (this.shapes.get(name) !== shape) { shape.geometry.dispose(); shape.edges.dispose(); }
    this.result = result;
    this.machine.clear();
    this.instances = result.instances.map((one, order) => {
      const shape = this.shapes.get(one.part);
      const group = new THREE.Group();
      const mesh = new THREE.Mesh(shape.geometry, this.material(shape.base));
      const caps = this.caps(shape, order);
      const edges = new THREE.LineSegments(shape.edges, this.edgeMaterial());
      mesh.userData = one;
      mesh.renderOrder = edges.renderOrder = SOLIDS;
      group.add(mesh, edges, ...caps.counters);
      group.matrixAutoUpdate = false;
      this.machine.add(group, caps.cap);
      return { ...one, group, mesh, ...caps, seated: matrix(one.frame), apart: matrix(one.exploded) };
    });
    this.explode(this.explosion);
    this.box = this.extent();
    this.section(this.axis, this.share);
    this.select(this.selected, false);
    if (first) this.look('oblique');
    this.draw();
    return true;
  }

  async load(name, key) {
    if (this.shapes.get(name)?.key === key) return this.shapes.get(name);
    const file = await this.loader.loadAsync(`/api/machine/artefacts/${key}/${name}.glb`);
    const geometries = [];
    let base = new THREE.Color(0x999999);
    file.scene.updateMatrixWorld(true);
    file.scene.traverse((node) => {
      if (!node.isMesh) return;
      base = node.material.color;
      // glTF has metres with y up; the machine has millimetres with z up.
      geometries.push(node.geometry.applyMatrix4(node.matrixWorld).rotateX(Math.PI / 2).scale(1000, 1000, 1000));
    });
    const geometry = geometries[0];
    return { key, geometry, base, edges: new THREE.EdgesGeometry(geometry, 28) };
  }

  material(base) {
    const name = base.getHexString();
    if (!this.materials.has(name)) {
      this.materials.set(name, new THREE.MeshStandardMaterial({ color: base, roughness: 0.62, metalness: 0.05, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 }));
    }
    return this.materials.get(name);
  }

  /** The faces of a solid that the plane opens: its surfaces are counted in the stencil, then the plane is filled. */
  caps(shape, order) {
    this._counting ??= [[THREE.BackSide, THREE.IncrementWrapStencilOp], [THREE.FrontSide, THREE.DecrementWrapStencilOp]].map(([side, op]) =>
      new THREE.MeshBasicMaterial({ side, depthWrite: false, depthTest: false, colorWrite: false, stencilWrite: true, stencilFunc: THREE.AlwaysStencilFunc, stencilFail: op, stencilZFail: op, stencilZPass: op }));
    const counters = this._counting.map((material) => new THREE.Mesh(shape.geometry, material));
    const colour_ = shape.base.clone().lerp(new THREE.Color(0xe69f00), 0.3);
    const cap = new THREE.Mesh(this.sheet, new THREE.MeshBasicMaterial({ color: colour_, stencilWrite: true, stencilRef: 0, stencilFunc: THREE.NotEqualStencilFunc, stencilFail: THREE.ReplaceStencilOp, stencilZFail: THREE.ReplaceStencilOp, stencilZPass: THREE.ReplaceStencilOp }));
    cap.onAfterRender = (renderer) => renderer.clearStencil();
    for (const mesh of counters) mesh.renderOrder = order + 1.1;
    cap.renderOrder = order + 1.2;
    return { counters, cap };
  }

  edgeMaterial() {
    this._edge ??= new THREE.LineBasicMaterial({ color: 0x000000, transparent: true, opacity: 0.55 });
    return this._edge;
  }

  highlight() {
    this._highlight ??= new THREE.MeshStandardMaterial({ color: 0x56b4e9, roughness: 0.5, polygonOffset: true, polygonOffsetFactor: 1, polygonOffsetUnits: 1 });
    return this._highlight;
  }

  paint() {
    this.scene.background = new THREE.Color(colour('scene'));
    this.edgeMaterial().color.set(colour('edge'));
    this.draw();
  }

  explode(share) {
    this.explosion = share;
    for (const one of this.instances) {
      const m = one.group.matrix.copy(one.seated);
      for (const k of [12, 13, 14]) m.elements[k] += share * (one.apart.elements[k] - one.seated.elements[k]);
      one.group.matrixWorldNeedsUpdate = true;
    }
    this.draw();
  }

  /** Cut by a plane normal to an axis (`x`, `y`, `z`, or null for none) at a share of the machine's size. */
  section(axis, share) {
    this.axis = axis;
    this.share = share;
    const planes = [];
    let at = 0;
    if (axis && this.box) {
      at = this.box.min[axis] + share * (this.box.max[axis] - this.box.min[axis]);
      this.plane.normal.copy(AXES[axis]);
      this.plane.constant = -this.plane.normal[axis] * at;
      planes.push(this.plane);
    }
    for (const material of [...this.materials.values(), ...(this._counting ?? []), this.edgeMaterial(), this.highlight()]) {
      material.clippingPlanes = planes;
    }
    for (const one of this.instances) {
      one.cap.visible = axis !== null && one.group.visible;
      for (const mesh of one.counters) mesh.visible = axis !== null;
      if (axis) {
        this.plane.coplanarPoint(one.cap.position);
        one.cap.lookAt(one.cap.position.clone().sub(this.plane.normal));
      }
    }
    this.draw();
    return at;
  }

  select(name, tell = true) {
    this.selected = name;
    for (const one of this.instances) {
      const { base } = this.shapes.get(one.part);
      one.mesh.material = one.part === name ? this.highlight() : this.material(one.part === this.hovered ? base.clone().lerp(new THREE.Color(0x56b4e9), 0.45) : base);
      one.group.visible = !this.hidden.has(one.part);
      one.cap.visible = one.group.visible && this.axis !== null;
    }
    if (this.axis) this.section(this.axis, this.share);
    if (tell) this.onselect(name);
    this.onmark();
    this.draw();
  }

  /** Show a part in another colour while it is under the pointer, here or in the tree. */
  hover(name) {
    if (name === this.hovered) return;
    this.hovered = name;
    this.select(this.selected, false);
  }

  hide(name) {
    if (this.hidden.has(name)) this.hidden.delete(name); else this.hidden.add(name);
    this.select(this.selected);
  }

  /** Hide all parts but one; null: show all. */
  showOnly(name) {
    this.hidden = new Set(name === null ? [] : this.instances.map((one) => one.part).filter((one) => one !== name));
    this.select(name ?? this.selected);
  }

  /** What is under the pointer: the part, or the place that a measurement would take. */
  lookAt(event) {
    const hit = this.hit(event);
    const box = this.place.getBoundingClientRect();
    this.tag.style.left = `${event.clientX - box.left + 14}px`;
    this.tag.style.top = `${event.clientY - box.top + 14}px`;
    this.tag.hidden = !hit;
    if (!this.measuring) {
      this.hover(hit?.object.userData.part ?? null);
      if (hit) this.tag.textContent = words(hit.object.userData.part);
      return;
    }
    const found = hit && this.snap(hit, event.shiftKey);
    if (found) {
      this.tag.textContent = found.kind;
      this.aim.position.copy(found.point);
      this.aim.material.color.set(colour('good'));
      // Smaller than a mark, which stays visible around it.
      this.aim.material.size = 5 * this.renderer.getPixelRatio();
    }
    this.aim.visible = Boolean(found);
    this.draw();
  }

  leave() {
    this.tag.hidden = true;
    this.aim.visible = false;
    this.hover(null);
    this.draw();
  }

  /**
   * The place that a measurement takes at a hit: a corner, the centre of a round edge, an edge, or the face itself.
   * @param {boolean} plain  the point of the edge, not the centre of a round one
   */
  snap(hit, plain = false) {
    const { matrixWorld } = hit.object;
    const shape = this.shapes.get(hit.object.userData.part);
    shape.snaps ??= new Edges(shape.edges);
    const local = hit.object.worldToLocal(hit.point.clone());
    const pixel = (2 * hit.distance * Math.tan((this.camera.fov * Math.PI) / 360)) / this.place.clientHeight;
    const found = shape.snaps.nearest(local, REACH * pixel);
    const normal = hit.face.normal.clone().transformDirection(matrixWorld);
    if (!found) return { kind: 'face', point: hit.point.clone(), normal };
    const round = shape.snaps.circle(found.segment);
    if (round && !plain) return { kind: `centre of ⌀ ${length(2 * round.radius)} mm`, point: round.centre.clone().applyMatrix4(matrixWorld) };
    if (found.corner && !round) return { kind: 'corner', point: found.corner.clone().applyMatrix4(matrixWorld) };
    return { kind: round ? 'round edge' : 'edge', point: found.point.applyMatrix4(matrixWorld) };
  }

  click(event) {
    const hit = this.hit(event);
    if (!this.measuring) {
      this.select(hit ? hit.object.userData.part : null);
      return;
    }
    if (hit) this.measure(this.snap(hit, event.shiftKey));
  }

  hit(event) {
    const box = this.canvas.getBoundingClientRect();
    const at = new THREE.Vector2(((event.clientX - box.left) / box.width) * 2 - 1, 1 - ((event.clientY - box.top) / box.height) * 2);
    this.ray.setFromCamera(at, this.camera);
    const meshes = this.instances.filter((one) => one.group.visible).map((one) => one.mesh);
    return this.ray.intersectObjects(meshes, false).find((one) => !this.axis || this.plane.distanceToPoint(one.point) >= 0);
  }

  setMeasuring(on) {
    this.measuring = on;
    this.canvas.style.cursor = on ? 'crosshair' : '';
    this.picked = [];
    this.marks.clear();
    fill(this.label, on ? 'click two points: corners, edges, centres of round edges (with Shift: the edge itself), faces' : '');
    this.label.hidden = !on;
    if (on) this.hover(null); else this.aim.visible = false;
    this.draw();
  }

  /** Take a place as the next point of a measurement, and write the distance of two. */
  measure(place) {
    if (this.picked.length === 2) this.picked = [];
    this.picked.push(place);
    this.marks.clear();
    const ink = new THREE.Color(colour('bad'));
    const points = new THREE.BufferGeometry().setFromPoints(this.picked.map(({ point }) => point));
    this.marks.add(new THREE.Points(points, new THREE.PointsMaterial({ color: ink, size: 8 * this.renderer.getPixelRatio(), sizeAttenuation: false, depthTest: false, transparent: true })));
    const [first, second] = this.picked;
    const [a, b] = this.picked.map(({ point }) => point);
    if (b) {
      this.marks.add(new THREE.Line(points, new THREE.LineBasicMaterial({ color: ink, depthTest: false, transparent: true })));
      const d = ['x', 'y', 'z'].map((axis) => `Δ${axis} ${length(b[axis] - a[axis])}`);
      const parallel = first.normal && second.normal && Math.abs(first.normal.dot(second.normal)) > 0.99999;
      const apart = parallel ? `  parallel faces ${length(Math.abs(b.clone().sub(a).dot(first.normal)))} mm apart` : '';
      fill(this.label, h('b', {}, `${length(a.distanceTo(b))} mm`), `  ${d.join('  ')} mm${apart}`, h('span', { class: 'dim' }, `  ${first.kind} to ${second.kind}`));
    } else {
      fill(this.label, `${first.kind} (${['x', 'y', 'z'].map((axis) => length(a[axis])).join(', ')}) mm; click the second point`);
    }
    // After the solids, which are painted last of the machine.
    for (const mark of this.marks.children) mark.renderOrder = MARKS;
    this.draw();
  }

  /** Box around the parts, without the sheets of the section. */
  extent() {
    const box = new THREE.Box3();
    for (const one of this.instances) box.expandByObject(one.group);
    return box;
  }

  look(view) {
    if (!this.box || this.box.isEmpty()) return;
    // A hidden view has no size, hence no distance: it is taken when the view is shown.
    if (!this.place.clientHeight) { this.awaited = view || this.awaited || ''; return; }
    const sphere = this.extent().getBoundingSphere(new THREE.Sphere());
    const half = (this.camera.fov / 2) * Math.PI / 180;
    const across = 2 * Math.min(half, Math.atan((Math.tan(half) * (this.place.clientWidth - this.inset)) / this.place.clientHeight));
    const distance = sphere.radius / Math.sin(across / 2);
    const from = VIEWS[view] ? new THREE.Vector3(...VIEWS[view]) : this.camera.position.clone().sub(this.controls.target);
    this.controls.target.copy(sphere.center);
    this.camera.position.copy(sphere.center).addScaledVector(from.normalize(), distance);
    this.camera.near = distance / 100;
    this.camera.far = distance * 10;
    this.camera.updateProjectionMatrix();
    this.controls.update();
    this.draw();
  }

  resize() {
    const { clientWidth: width, clientHeight: height } = this.place;
    if (!width || !height) return;
    this.renderer.setPixelRatio(Math.min(devicePixelRatio, 2));
    this.renderer.setSize(width, height, false);
    this.camera.aspect = width / height;
    this.camera.setViewOffset(width, height, -this.inset / 2, 0, width, height);
    if (this.awaited !== undefined) {
      const view = this.awaited;
      this.awaited = undefined;
      this.look(view);
    }
    this.render();
  }

  /** Keep so many pixels on the left free of the machine, for what stands there. */
  keepFree(pixels) {
    if (pixels === this.inset) return;
    this.inset = pixels;
    this.resize();
    if (this.box) this.look('');
  }

  draw() {
    if (this._asked) return;
    this._asked = true;
    requestAnimationFrame(() => { this._asked = false; this.render(); });
  }

  render() {
    // The lights move with the observer, so that no side is ever black.
    const right = new THREE.Vector3().setFromMatrixColumn(this.camera.matrixWorld, 0);
    this.key.position.copy(this.camera.position).addScaledVector(right, -0.5 * this.camera.position.length()).addScaledVector(UP, 0.6 * this.camera.position.length());
    this.fillLight.position.copy(this.camera.position).addScaledVector(right, 0.9 * this.camera.position.length());
    this.renderer.render(this.scene, this.camera);
  }
}

function matrix(rows) {
  return new THREE.Matrix4().set(...rows[0], ...rows[1], ...rows[2], 0, 0, 0, 1);
}
