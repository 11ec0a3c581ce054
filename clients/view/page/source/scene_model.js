// SPDX-License-Identifier: GPL-3.0-or-later
// The pictures of one column: objects, the tool at the hand and at its proxy, contacts, arrows.

import * as THREE from "three";
import { toCreasedNormals } from "three/examples/jsm/utils/BufferGeometryUtils.js";
import { css } from "./dom.js";
import { Arrow, Contacts, Tightest, Trail } from "./scene_marks.js";
import { SceneDrawings } from "./scene_drawings.js";
import { piece_colours } from "./scene_pieces.js";

const kCrease = 0.7; // [rad]: sides that meet in a sharper edge are shaded apart
const kFine = 1e6; // toCreasedNormals takes vertices within 0.01 for one: that must be less than 1 µm
const kLeastTool = 6; // [px], radius that a tool has in the picture at least

/** Position and quaternion (w x y z) of a pose of seven numbers. */
export function place(object, pose) {
  const valid = pose.every(Number.isFinite);
  object.visible = valid;
  if (!valid) return;
  object.position.set(pose[0], pose[1], pose[2]);
  object.quaternion.set(pose[4], pose[5], pose[6], pose[3]);
}

function geometry_of(eye, colours = null) {
  const geometry = new THREE.BufferGeometry();
  const fine = eye.vertices.map((metres) => kFine * metres);
  geometry.setAttribute("position", new THREE.BufferAttribute(fine, 3));
  geometry.setAttribute("normal", new THREE.BufferAttribute(eye.normals, 3));
  if (colours) geometry.setAttribute("color", new THREE.BufferAttribute(colours, 3));
  geometry.setIndex(new THREE.BufferAttribute(eye.triangles, 1));
  // an eye file has one normal for each vertex; the sides of a block meet in an edge all the same
  const creased = toCreasedNormals(geometry, kCrease).scale(1 / kFine, 1 / kFine, 1 / kFine);
  creased.computeBoundingSphere();
  return creased;
}

/** Dull in low quality: a software renderer pays three times as much for the other. */
function material(low, options) {
  return low
    ? new THREE.MeshLambertMaterial(options)
    : new THREE.MeshStandardMaterial({ roughness: 0.62, metalness: 0.05, ...options });
}

export class Model {
  constructor(low) {
    this.low = low;
    this.scene = new THREE.Scene();
    this.objects = [];
    this.add_lights();
    this.hand = new THREE.Group();
    this.proxy = new THREE.Group();
    this.force = new Arrow("force", low);
    this.torque = new Arrow("torque", low);
    this.contacts = new Contacts();
    this.trail = new Trail();
    this.tightest = new Tightest();
    this.drawings = new SceneDrawings(low);
    this.link = line_of("hand");
    this.intent = new THREE.Mesh(
      new THREE.OctahedronGeometry(1),
      new THREE.MeshBasicMaterial({ wireframe: true, depthTest: false, transparent: true }),
    );
    this.intent_line = line_of("intent");
    this.scene.add(
      this.hand,
      this.proxy,
      this.force.group,
      this.torque.group,
      this.contacts.group,
      this.trail.line,
      this.tightest.group,
      this.drawings.group,
      this.link,
      this.intent,
      this.intent_line,
    );
    this.intent.visible = false;
    this.intent_line.visible = false;
    this.shell_visible = false;
    this.pieces_visible = false;
  }

  add_lights() {
    this.scene.add(new THREE.HemisphereLight(0xffffff, 0x8a93a0, 1.6));
    this.sun = new THREE.DirectionalLight(0xffffff, 1.9);
    this.scene.add(this.sun, this.sun.target);
  }

  /** The sun stands over the viewer's left shoulder, wherever he goes. */
  light_from(camera, target) {
    this.sun.position.copy(camera.position);
    this.sun.position.addScaledVector(
      new THREE.Vector3(-1, 1, 0).applyQuaternion(camera.quaternion),
      camera.position.distanceTo(target) * 0.5,
    );
    this.sun.target.position.copy(target);
  }

  /** Takes the eyes {objects: [eye or null], tool: eye or null}; `radius` of a tool without one. */
  set_eyes(eyes, radius, size) {
    for (const group of [...this.objects, this.hand, this.proxy]) forget(group);
    this.scene.remove(...this.objects);
    this.objects = eyes.objects.map((eye) => this.add_object(eye));
    this.set_tool(eyes.tool, radius > 0 ? radius : size * 0.012);
    this.tightest.set_shape(this.proxy.children[0].geometry, size);
    this.intent.scale.setScalar(size * 0.035);
    this.contacts.set_size(size);
    this.trail.clear();
    this.theme();
  }

  add_object(eye) {
    const group = new THREE.Group();
    this.scene.add(group);
    if (!eye) return group;
    const [r, g, b, a] = eye.colour;
    const colour = new THREE.Color().setRGB(r, g, b, THREE.SRGBColorSpace);
    const see_through = a < 1 ? { transparent: true, opacity: a } : {};
    group.add(
      new THREE.Mesh(
        geometry_of(eye),
        material(this.low, { color: colour, side: THREE.DoubleSide, ...see_through }),
      ),
    );
    this.add_shell(group, eye);
    return group;
  }

  add_shell(group, eye) {
    if (eye.points.length === 0) return;
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(eye.points, 3));
    const points = new THREE.Points(
      geometry,
      new THREE.PointsMaterial({ size: 3, sizeAttenuation: false }),
    );
    points.visible = this.shell_visible;
    points.name = "shell";
    group.add(points);
  }

  set_tool(eye, radius) {
    const shape =
      eye && eye.triangles.length > 0 ? geometry_of(eye) : new THREE.SphereGeometry(radius, 24, 16);
    shape.computeBoundingSphere();
    this.tool_radius = shape.boundingSphere.radius;
    this.hand.clear();
    this.proxy.clear();
    const ghost = material(this.low, {
      transparent: true,
      opacity: 0.42,
      depthWrite: false,
      depthTest: false,
    }); // seen through objects: a hand inside one is what matters
    ghost.name = "hand";
    const solid = material(this.low, {});
    solid.name = "proxy";
    this.hand.add(new THREE.Mesh(shape, ghost));
    this.proxy.add(new THREE.Mesh(shape, solid));
    if (eye) this.add_shell(this.proxy, eye);
  }

  /** Takes the eyes of the convex pieces, as set_eyes takes those of the meshes. */
  set_pieces(eyes) {
    eyes.objects.forEach((eye, index) => this.add_pieces(this.objects[index], eye));
    this.add_pieces(this.proxy, eyes.tool);
    this.show_pieces(this.pieces_visible);
  }

  add_pieces(group, eye) {
    if (!group || !eye) return;
    const surface = material(this.low, { vertexColors: true, side: THREE.DoubleSide });
    const pieces = new THREE.Mesh(geometry_of(eye, piece_colours(eye)), surface);
    pieces.name = "pieces";
    group.add(pieces);
  }

  /** Pieces instead of the mesh, where there are some. */
  show_pieces(on) {
    this.pieces_visible = on;
    for (const group of [...this.objects, this.proxy]) {
      const pieces = group.getObjectByName("pieces");
      for (const node of pieces ? group.children : []) {
        if (node.isMesh) node.visible = (node === pieces) === on;
      }
    }
  }

  show_shell(on) {
    this.shell_visible = on;
    this.scene.traverse((node) => {
      if (node.name === "shell") node.visible = on;
    });
  }

  theme() {
    this.scene.background = new THREE.Color(css("stage"));
    this.scene.traverse((node) => {
      const name = node.material?.name;
      if (name === "hand" || name === "proxy") node.material.color.set(css(name));
      if (node.name === "shell") node.material.color.set(css("shell"));
    });
    this.force.theme();
    this.torque.theme();
    this.contacts.theme();
    this.trail.theme();
    this.tightest.theme();
    for (const line of [this.link, this.intent_line]) line.material.color.set(css(line.name));
    this.intent.material.color.set(css("intent"));
  }

  /** Shows a frame; `scales` {force, torque} in metres per newton and per newton metre. */
  show(frame, scales) {
    this.objects.forEach((group, index) => {
      const object = frame.objects[index];
      if (object) place(group, object.pose);
    });
    place(this.hand, frame.tool);
    place(this.proxy, frame.proxy);
    this.force.point(frame.tool, frame.force, scales.force);
    this.torque.point(frame.tool, frame.torque, scales.torque);
    this.contacts.show(frame.contacts);
    this.trail.add(frame.tool);
    join_points(this.link, frame.tool, frame.proxy);
  }

  /** Draws tool and proxy larger where they would be lost; `metres_per_pixel(point)`. */
  keep_seen(metres_per_pixel) {
    for (const tool of [this.hand, this.proxy]) {
      const least = kLeastTool * metres_per_pixel(tool.position.toArray());
      tool.scale.setScalar(Math.max(1, least / this.tool_radius));
    }
  }

  show_intent(intent, hand) {
    const valid = intent !== null && Array.from(intent).every(Number.isFinite);
    this.intent.visible = valid;
    this.intent_line.visible = valid;
    if (!valid) return;
    this.intent.position.set(...intent);
    join_points(this.intent_line, intent, hand);
  }
}

/** Frees what the graphics card holds of a group's meshes. */
function forget(group) {
  group.traverse(({ geometry, material: surface }) => {
    geometry?.dispose();
    surface?.dispose();
  });
}

function line_of(name) {
  const geometry = new THREE.BufferGeometry();
  geometry.setAttribute("position", new THREE.BufferAttribute(new Float32Array(6), 3));
  const line = new THREE.Line(
    geometry,
    new THREE.LineBasicMaterial({ depthTest: false, transparent: true }),
  );
  line.name = name;
  line.frustumCulled = false;
  return line;
}

function join_points(line, from, to) {
  const numbers = line.geometry.attributes.position;
  numbers.setXYZ(0, from[0], from[1], from[2]);
  numbers.setXYZ(1, to[0], to[1], to[2]);
  numbers.needsUpdate = true;
}
