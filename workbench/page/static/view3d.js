// The machine in three dimensions: parts as meshes from the server, drawn only when something changed.
import * as THREE from './vendor/three.min.js';
import { h, fill, colour, newest, number } from './dom.js';

const UP = new THREE.Vector3(0, 0, 1);
const VIEWS = { front: [0, -1, 0], right: [1, 0, 0], top: [0, -0.001, 1], oblique: [1, -1.25, 0.8] };
const AXES = { x: new THREE.Vector3(-1, 0, 0), y: new THREE.Vector3(0, 1, 0), z: new THREE.Vector3(0, 0, -1) };

/** Order of painting: the sections below the solids, the marks above them. */
const [SOLIDS, MARKS] = [1000, 1001];

/** A length in mm, to the micrometre. */
const length = (mm) => number(Math.round(mm * 1000) / 1000 || 0, 6);

export class View3d {
  /** @param {HTMLElement} place  @param {(name: string|null) => void} onselect  called with the part selected */
  constructor(place, onselect) {
    this.place = place;
    this.onselect = onselect;
    this.renderer = new THREE.WebGLRenderer({ antialias: true, stencil: true });
    this.renderer.localClippingEnabled = true;
    this.canvas = this.renderer.domElement;
    this.canvas.tabIndex = 0;
    this.canvas.setAttribute('aria-label', 'machine, three-dimensional');
    this.label = h('div', { class: 'measured', hidden: true });
    place.append(this.canvas, this.label);
    this.scene = new THREE.Scene();
    this.camera = new THREE.PerspectiveCamera(24, 1, 1, 20000);
    this.camera.up.copy(UP);
    this.controls = new THREE.OrbitControls(this.camera, this.canvas);
    this.controls.addEventListener('change', () => this.draw());
    this.machine = new THREE.Group();
    this.marks = new THREE.Group();
    this.scene.add(this.machine, this.marks);
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
    this.selected = null;
    this.measuring = false;
    this.picked = [];
    this.hidden = new Set();
    this.ray = new THREE.Raycaster();
    let down = null;
    this.canvas.addEventListener('pointerdown', (event) => { down = [event.clientX, event.clientY]; });
    this.canvas.addEventListener('pointerup', (event) => {
      if (down && Math.hypot(event.clientX - down[0], event.clientY - down[1]) < 4 && event.button === 0) this.click(event);
      down = null;
    });
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
      one.mesh.material = one.part === name ? this.highlight() : this.material(this.shapes.get(one.part).base);
      one.group.visible = !this.hidden.has(one.part);
      one.cap.visible = one.group.visible && this.axis !== null;
    }
    if (tell) this.onselect(name);
    this.draw();
  }

  hide(name) {
    if (this.hidden.has(name)) this.hidden.delete(name); else this.hidden.add(name);
    this.select(this.selected, false);
  }

  click(event) {
    const hit = this.hit(event);
    if (!this.measuring) {
      this.select(hit ? hit.object.userData.part : null);
      return;
    }
    if (hit) this.measure(hit.point.clone());
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
    fill(this.label, on ? 'click two points' : '');
    this.label.hidden = !on;
    this.draw();
  }

  measure(point) {
    if (this.picked.length === 2) this.picked = [];
    this.picked.push(point);
    this.marks.clear();
    const ink = new THREE.Color(colour('bad'));
    const points = new THREE.BufferGeometry().setFromPoints(this.picked);
    this.marks.add(new THREE.Points(points, new THREE.PointsMaterial({ color: ink, size: 8 * this.renderer.getPixelRatio(), sizeAttenuation: false, depthTest: false, transparent: true })));
    const [a, b] = this.picked;
    if (b) {
      this.marks.add(new THREE.Line(points, new THREE.LineBasicMaterial({ color: ink, depthTest: false, transparent: true })));
      const d = ['x', 'y', 'z'].map((axis) => `Δ${axis} ${length(b[axis] - a[axis])}`);
      fill(this.label, h('b', {}, `${length(a.distanceTo(b))} mm`), `  ${d.join('  ')} mm`);
    } else {
      fill(this.label, `(${['x', 'y', 'z'].map((axis) => length(a[axis])).join(', ')}) mm; click the second point`);
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
    const sphere = this.extent().getBoundingSphere(new THREE.Sphere());
    const half = (this.camera.fov / 2) * Math.PI / 180;
    const across = 2 * Math.min(half, Math.atan(Math.tan(half) * this.camera.aspect));
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
    this.camera.updateProjectionMatrix();
    this.render();
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
