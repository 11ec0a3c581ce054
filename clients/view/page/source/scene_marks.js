// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the marks beside the meshes: arrows of force and torque, contacts, the trail of the tool.

import * as THREE from "three";
import { css } from "./dom.js";

const kUp = new THREE.Vector3(0, 1, 0);
const kShortest = 1e-3; // [N, N·m] below it there is no arrow

/** An arrow of a shaft and a head; the torque has two heads. */
export class Arrow {
  constructor(name, low) {
    this.name = name;
    this.group = new THREE.Group();
    this.material = low
      ? new THREE.MeshLambertMaterial()
      : new THREE.MeshStandardMaterial({ roughness: 0.5 });
    // once more, faint, through what hides it: it begins at a hand that may be inside an object
    this.faint = new THREE.MeshBasicMaterial({
      transparent: true,
      opacity: 0.35,
      depthTest: false,
      depthWrite: false,
    });
    const sides = low ? 8 : 16;
    this.shaft = this.part(new THREE.CylinderGeometry(1, 1, 1, sides));
    this.heads = Array.from({ length: name === "torque" ? 2 : 1 }, () =>
      this.part(new THREE.ConeGeometry(1, 1, sides)),
    );
    this.group.add(this.shaft, ...this.heads);
    this.thickness = 1e-3;
  }

  part(geometry) {
    return new THREE.Group().add(
      new THREE.Mesh(geometry, this.material),
      new THREE.Mesh(geometry, this.faint),
    );
  }

  theme() {
    this.material.color.set(css(this.name));
    this.faint.color.set(css(this.name));
  }

  /** From a pose's position along `vector`, scaled by `scale` metres per unit. */
  point(pose, vector, scale) {
    const size = Math.hypot(...vector);
    const length = size * scale;
    this.group.visible = Number.isFinite(length) && size > kShortest && pose.every(Number.isFinite);
    if (!this.group.visible) return;
    this.group.position.set(pose[0], pose[1], pose[2]);
    this.group.quaternion.setFromUnitVectors(kUp, new THREE.Vector3(...vector).divideScalar(size));
    const thick = this.thickness;
    const head = Math.min(6 * thick, (0.5 * length) / this.heads.length);
    const shaft = Math.max(length - head * this.heads.length, 1e-6);
    this.shaft.scale.set(thick, shaft, thick);
    this.shaft.position.y = shaft / 2;
    this.heads.forEach((cone, index) => {
      cone.scale.set(2.6 * thick, head, 2.6 * thick);
      cone.position.y = shaft + head * (index + 0.5);
    });
  }
}

const kMostContacts = 64; // kMaxContacts of a set
const kGuide = 3; // kind of a row that holds both ways

/**
 * Contact points with normals, and discs of their extent; inactive ones are faint. What is held is
 * a cross of lines through the points of its rows, since these pull as well as push.
 */
export class Contacts {
  constructor() {
    this.group = new THREE.Group();
    this.items = [];
    this.materials = Object.fromEntries(
      ["active", "near", "held"].map((name) => [
        name,
        {
          dot: new THREE.MeshBasicMaterial(),
          line: new THREE.LineBasicMaterial(),
          disc: new THREE.MeshBasicMaterial({
            transparent: true,
            opacity: 0.22,
            side: THREE.DoubleSide,
            depthWrite: false,
          }),
        },
      ]),
    );
    this.shapes = {
      dot: new THREE.SphereGeometry(1, 10, 8),
      disc: new THREE.CircleGeometry(1, 32),
      line: new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), kUp]),
    };
  }

  set_size(size) {
    this.size = size;
  }

  theme() {
    for (const [name, set] of Object.entries(this.materials)) {
      for (const part of Object.values(set)) part.color.set(css(`contact-${name}`));
    }
  }

  item(index) {
    while (this.items.length <= index) {
      const group = new THREE.Group();
      const dot = new THREE.Mesh(this.shapes.dot);
      const line = new THREE.Line(this.shapes.line);
      const disc = new THREE.Mesh(this.shapes.disc);
      disc.rotation.x = -Math.PI / 2; // its face is turned along the normal
      group.add(dot, line, disc);
      this.group.add(group);
      this.items.push({ group, dot, line, disc });
    }
    return this.items[index];
  }

  show(contacts) {
    const shown = contacts.slice(0, kMostContacts);
    shown.forEach((contact, index) => this.show_one(this.item(index), contact));
    this.items.forEach(({ group }, index) => {
      if (index >= shown.length) group.visible = false;
    });
  }

  show_one({ group, dot, line, disc }, { point, normal, extent, active, kind }) {
    group.visible = point.every(Number.isFinite) && normal.every(Number.isFinite);
    if (!group.visible) return;
    const holds = kind === kGuide;
    const set = this.materials[holds ? "held" : active ? "active" : "near"];
    [dot.material, line.material, disc.material] = [set.dot, set.line, set.disc];
    group.position.set(...point);
    group.quaternion.setFromUnitVectors(kUp, new THREE.Vector3(...normal).normalize());
    dot.scale.setScalar(this.size * (active || holds ? 0.007 : 0.005));
    // a line to both sides of the point is no arrow
    line.scale.setScalar(this.size * (holds ? 0.05 : 0.09));
    line.position.y = holds ? -this.size * 0.025 : 0;
    disc.visible = !holds;
    // 0 or infinite: a plane without bound; its disc shows only the direction
    const bounded = extent > 0 && extent < this.size;
    disc.scale.setScalar(bounded ? extent : this.size * 0.05);
  }
}

/** The tool where it came nearest to an object: a ghost, the two points and the line between. */
export class Tightest {
  constructor() {
    this.group = new THREE.Group();
    this.group.visible = false;
    this.surface = new THREE.MeshBasicMaterial({
      transparent: true,
      opacity: 0.3,
      depthWrite: false,
    });
    // over all else: the two points are mostly hidden by what they lie on
    this.mark = new THREE.MeshBasicMaterial({ depthTest: false, transparent: true });
    this.ghost = new THREE.Mesh(new THREE.BufferGeometry(), this.surface);
    const dot = new THREE.SphereGeometry(1, 12, 8);
    this.dots = [new THREE.Mesh(dot, this.mark), new THREE.Mesh(dot, this.mark)];
    this.line = new THREE.Mesh(new THREE.CylinderGeometry(1, 1, 1, 8), this.mark);
    for (const mark of [this.line, ...this.dots]) mark.renderOrder = 1;
    this.group.add(this.ghost, this.line, ...this.dots);
  }

  theme() {
    this.surface.color.set(css("tightest"));
    this.mark.color.set(css("tightest"));
  }

  /** Takes the shape of the tool, and the size of the scene [m]. */
  set_shape(shape, size) {
    this.ghost.geometry = shape;
    this.size = size;
  }

  /** Takes `clearance` of the scene; null: nothing was measured. */
  show(clearance) {
    this.group.visible = clearance !== null;
    if (clearance === null) return;
    const { tool, tool_point, object_point } = clearance;
    this.ghost.position.set(tool[0], tool[1], tool[2]);
    this.ghost.quaternion.set(tool[4], tool[5], tool[6], tool[3]);
    const [from, to] = [tool_point, object_point].map((p) => new THREE.Vector3(...p));
    const way = to.clone().sub(from);
    const thick = this.size * 0.004; // two points that are nearer than this are one dot
    [from, to].forEach((p, i) => {
      this.dots[i].position.copy(p);
      this.dots[i].scale.setScalar(1.5 * thick);
    });
    this.line.visible = way.length() > 0;
    if (!this.line.visible) return;
    this.line.position.copy(from).addScaledVector(way, 0.5);
    this.line.scale.set(thick * 0.4, way.length(), thick * 0.4);
    this.line.quaternion.setFromUnitVectors(kUp, way.normalize());
  }
}

const kTrailPoints = 600; // ten seconds at 60 frames a second

export class Trail {
  constructor() {
    const geometry = new THREE.BufferGeometry();
    this.numbers = new THREE.BufferAttribute(new Float32Array(3 * kTrailPoints), 3);
    geometry.setAttribute("position", this.numbers);
    this.line = new THREE.Line(geometry, new THREE.LineBasicMaterial());
    this.line.frustumCulled = false;
    this.clear();
  }

  clear() {
    this.count = 0;
    this.line.geometry.setDrawRange(0, 0);
  }

  theme() {
    this.line.material.color.set(css("trail"));
  }

  add([x, y, z]) {
    if (![x, y, z].every(Number.isFinite)) return;
    const { array } = this.numbers;
    if (this.count === kTrailPoints) {
      array.copyWithin(0, 3);
      this.count -= 1;
    }
    array.set([x, y, z], 3 * this.count);
    this.count += 1;
    this.numbers.needsUpdate = true;
    this.line.geometry.setDrawRange(0, this.count);
  }
}
