// SPDX-License-Identifier: GPL-3.0-or-later
// The picture of the scene: one canvas, a viewport for each column, one camera for all of them.

import * as THREE from "three";
import { OrbitControls } from "three/examples/jsm/controls/OrbitControls.js";
import { Model } from "./scene_model.js";
import { arrow_scales, bounds_of, Rule } from "./scene_rule.js";

const kNoPose = [0, 0, 0, 1, 0, 0, 0];
const kJump = 0.5; // [s] of session time: a longer step than that begins a new trail
const kViews = { front: [0, 0, 1], side: [1, 0, 0], top: [0, 1, 0.001], start: [0.62, 0.5, 1] };

/** null where the browser has no WebGL: then all but the picture works. */
function renderer_of(canvas, low) {
  try {
    return new THREE.WebGLRenderer({ canvas, antialias: !low, powerPreference: "low-power" });
  } catch {
    return null;
  }
}

export class Stage {
  constructor(canvas, { low }) {
    this.canvas = canvas;
    this.low = low;
    this.renderer = renderer_of(canvas, low);
    this.camera = new THREE.PerspectiveCamera(38, 1, 0.001, 100);
    this.orbit = new OrbitControls(this.camera, canvas);
    this.orbit.addEventListener("change", () => {
      this.dirty = true;
    });
    this.models = [];
    this.rules = [];
    this.last_time = [];
    this.eyes = { objects: [], tool: null };
    this.pieces = null;
    this.clearance = null; // the tightest place of a recording
    this.box = bounds_of([], []);
    this.size = 0.1;
    this.scales = arrow_scales(this.size, null);
    this.on_draw = () => {};
    this.newest = []; // the newest frame of each column
    this.dirty = true;
    this.placed = false;
    this.set_columns(1);
    new ResizeObserver(() => this.resize()).observe(canvas.parentElement);
    this.resize();
  }

  set_columns(count) {
    if (count === this.models.length) return;
    this.newest = [];
    this.models = Array.from({ length: count }, () => new Model(this.low));
    this.rules = this.models.map((model) => {
      const rule = new Rule();
      model.scene.add(rule.group);
      return rule;
    });
    this.apply_eyes();
    this.resize();
  }

  /** Takes the meshes and what the scene says of tool and limits; the camera waits for a pose. */
  set_scene(eyes, radius, limits, keep_view) {
    this.eyes = eyes;
    this.pieces = null; // those of another scene
    this.radius = radius;
    this.limits = limits;
    const frames = this.newest.filter(Boolean);
    this.placed = frames.length > 0;
    this.measure(frames[0]);
    if (!keep_view) this.view("start");
    for (const frame of frames) this.show(frame, null);
  }

  /** Objects and tool where a frame has them. */
  measure(frame) {
    this.box = bounds_of(
      [...this.eyes.objects, frame && this.eyes.tool],
      [...this.eyes.objects.map((_, i) => frame?.objects[i]?.pose ?? kNoPose), frame?.tool],
    );
    this.size = Math.max(this.box.getSize(new THREE.Vector3()).length() * 0.7, 1e-4);
    this.scales = arrow_scales(this.size, this.limits);
    this.apply_eyes();
  }

  apply_eyes() {
    for (const [index, model] of this.models.entries()) {
      model.set_eyes(this.eyes, this.radius, this.size);
      if (this.pieces) model.set_pieces(this.pieces);
      model.tightest.show(this.clearance);
      model.force.thickness = model.torque.thickness = this.size * 0.006;
      this.rules[index].build(this.box, this.size);
    }
    this.dirty = true;
  }

  theme() {
    this.models.forEach((model, index) => {
      model.theme();
      this.rules[index].build(this.box, this.size);
    });
    this.dirty = true;
  }

  /** Takes the eyes of the convex pieces of the scene that is shown. */
  set_pieces(eyes) {
    this.pieces = eyes;
    for (const model of this.models) model.set_pieces(eyes);
    this.dirty = true;
  }

  set_clearance(clearance) {
    this.clearance = clearance;
    for (const model of this.models) model.tightest.show(clearance);
    this.dirty = true;
  }

  /** Shows what a client draws; null: nothing any more. */
  set_drawing(client, drawing) {
    for (const model of this.models) model.drawings.show(client, drawing);
    this.dirty = true;
  }

  show_pieces(on) {
    for (const model of this.models) model.show_pieces(on);
    this.dirty = true;
  }

  show_shell(on) {
    for (const model of this.models) model.show_shell(on);
    this.dirty = true;
  }

  get has_shell() {
    return (
      this.eyes.objects.some((eye) => eye && eye.points.length > 0) ||
      (this.eyes.tool?.points.length ?? 0) > 0
    );
  }

  /** Looks from a named side at the whole scene and the tool. */
  view(name) {
    const centre = this.box.getCenter(new THREE.Vector3());
    const distance = this.size * 2.2 * Math.max(1, 1 / this.aspect());
    const from = new THREE.Vector3(...kViews[name]).normalize();
    this.camera.position.copy(centre).addScaledVector(from, distance);
    this.camera.near = this.size / 200;
    this.camera.far = this.size * 60;
    this.orbit.target.copy(centre);
    this.orbit.minDistance = this.size / 20;
    this.orbit.maxDistance = this.size * 20;
    this.camera.updateProjectionMatrix();
    this.orbit.update();
    this.dirty = true;
  }

  /** Turns by angles [rad], shifts by shares of the picture, comes nearer by a factor. */
  move({ turn = [0, 0], shift = [0, 0], nearer = 1 }) {
    const arm = this.camera.position.clone().sub(this.orbit.target);
    const ball = new THREE.Spherical().setFromVector3(arm);
    ball.theta -= turn[0];
    ball.phi = THREE.MathUtils.clamp(ball.phi - turn[1], 0.01, Math.PI - 0.01);
    ball.radius /= nearer;
    const width = ball.radius * 2 * Math.tan((this.camera.fov * Math.PI) / 360);
    const { right, up } = this.plane();
    this.orbit.target
      .addScaledVector(right, shift[0] * width)
      .addScaledVector(up, shift[1] * width);
    this.camera.position.setFromSpherical(ball).add(this.orbit.target);
    this.orbit.update();
    this.dirty = true;
  }

  /** Directions of the picture in W: right, up, and forward, away from the viewer. */
  plane() {
    this.camera.updateMatrixWorld();
    const of = (x, y, z) => new THREE.Vector3(x, y, z).applyQuaternion(this.camera.quaternion);
    return { right: of(1, 0, 0), up: of(0, 1, 0), forward: of(0, 0, -1) };
  }

  /** Metres in W that one pixel of the picture is wide, as far away as `point`. */
  metres_per_pixel(point) {
    const { forward } = this.plane();
    const away = new THREE.Vector3(...point).sub(this.camera.position).dot(forward);
    return (
      (2 * Math.max(away, this.camera.near) * Math.tan((this.camera.fov * Math.PI) / 360)) /
      this.cell(0).height
    );
  }

  show(frame, intent) {
    const index = Math.min(frame.column, this.models.length - 1);
    const model = this.models[index];
    this.newest[index] = frame;
    if (!this.placed && frame.objects.length > 0) {
      this.placed = true;
      this.measure(frame);
      this.view("start");
    }
    const step = frame.time - this.last_time[index];
    if (!(step >= 0 && step < kJump)) model.trail.clear();
    this.last_time[index] = frame.time;
    model.show(frame, this.scales);
    model.show_intent(intent ?? (frame.leading ? frame.intent : null), frame.tool);
    this.dirty = true;
  }

  // on a narrow picture the columns lie one below the other
  aspect() {
    return this.cell(0).width / this.cell(0).height;
  }

  /** Place of a column's picture in the canvas, in CSS pixels from the upper left corner. */
  cell(index) {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const count = this.models.length;
    const across =
      width >= height ? (count <= 3 ? count : Math.ceil(count / 2)) : count > 3 ? 2 : 1;
    const down = Math.ceil(count / across);
    const [w, h] = [Math.max(width / across, 1), Math.max(height / down, 1)];
    return { x: (index % across) * w, y: Math.floor(index / across) * h, width: w, height: h };
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (clientWidth === 0 || clientHeight === 0) return;
    this.renderer?.setPixelRatio(this.low ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer?.setSize(clientWidth, clientHeight, true);
    this.camera.aspect = this.aspect();
    this.camera.updateProjectionMatrix();
    this.on_resize?.();
    this.dirty = true;
  }

  draw() {
    if (!this.dirty) return false;
    this.dirty = false;
    if (this.renderer === null) return false;
    this.renderer.setScissorTest(this.models.length > 1);
    this.models.forEach((model, index) => {
      const { x, y, width, height } = this.cell(index);
      const from_below = this.canvas.clientHeight - y - height;
      this.renderer.setViewport(x, from_below, width, height);
      this.renderer.setScissor(x, from_below, width, height);
      model.light_from(this.camera, this.orbit.target);
      model.keep_seen((point) => this.metres_per_pixel(point));
      this.renderer.render(model.scene, this.camera);
    });
    this.on_draw(this);
    return true;
  }
}
