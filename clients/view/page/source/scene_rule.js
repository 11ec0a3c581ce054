// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the measures of the scene: the grid, the axes with their letters, scales of the arrows.

import * as THREE from "three";
import { css } from "./dom.js";
import { length, round_down } from "./format.js";

const kCells = 20; // along each side of the grid

/** Bounding box [min, max] of everything in the scene at rest, never without a size. */
export function bounds_of(eyes, poses) {
  const box = new THREE.Box3();
  const corner = new THREE.Vector3();
  eyes.forEach((eye, index) => {
    if (!eye || eye.vertices.length === 0) return;
    const own = new THREE.Box3().setFromArray(eye.vertices);
    const pose = poses[index];
    if (!pose || !Array.from(pose).every(Number.isFinite)) return;
    const turn = new THREE.Quaternion(pose[4], pose[5], pose[6], pose[3]);
    for (let i = 0; i < 8; i += 1) {
      corner.set(...["x", "y", "z"].map((axis, k) => ((i >> k) & 1 ? own.max : own.min)[axis]));
      box.expandByPoint(
        corner.applyQuaternion(turn).add(new THREE.Vector3(pose[0], pose[1], pose[2])),
      );
    }
  });
  if (box.isEmpty())
    box.setFromCenterAndSize(new THREE.Vector3(), new THREE.Vector3(0.1, 0.1, 0.1));
  return box;
}

/** Lengths of the arrows: the limit of the force is two fifths of the scene. */
export function arrow_scales(size, limits) {
  const of = (limit, usual) => (0.4 * size) / (limit > 0 && Number.isFinite(limit) ? limit : usual);
  return { force: of(limits?.max_force, 10), torque: of(limits?.max_torque, 0.5) };
}

function letter(text, colour) {
  const canvas = document.createElement("canvas");
  canvas.width = canvas.height = 64;
  const pen = canvas.getContext("2d");
  pen.font = "600 44px system-ui, sans-serif";
  pen.textAlign = "center";
  pen.textBaseline = "middle";
  pen.fillStyle = colour;
  pen.fillText(text, 32, 34);
  const map = new THREE.CanvasTexture(canvas);
  map.colorSpace = THREE.SRGBColorSpace;
  return new THREE.Sprite(
    new THREE.SpriteMaterial({ map, alphaTest: 0.3, sizeAttenuation: false }), // hidden with its axis
  );
}

/** Grid below the scene and axes at its near corner. */
export class Rule {
  constructor() {
    this.group = new THREE.Group();
    this.cell = 0.01;
  }

  build(box, size) {
    this.group.clear();
    this.cell = round_down(size / 8);
    const floor = Math.floor(box.min.y / this.cell) * this.cell;
    const snap = (value) => Math.round(value / this.cell) * this.cell;
    const centre = box.getCenter(new THREE.Vector3());
    const grid = new THREE.GridHelper(kCells * this.cell, kCells, css("grid-axis"), css("grid"));
    grid.position.set(snap(centre.x), floor, snap(centre.z));
    grid.material.transparent = true;
    grid.material.opacity = 0.8;
    this.group.add(
      grid,
      this.axes(new THREE.Vector3(snap(box.min.x) - this.cell, floor, snap(box.max.z) + this.cell)),
    );
  }

  axes(origin) {
    const axes = new THREE.Group();
    axes.position.copy(origin);
    axes.position.y += 0.02 * this.cell; // or the grid would show through
    ["x", "y", "z"].forEach((name, index) => {
      const end = new THREE.Vector3().setComponent(index, 2 * this.cell);
      const geometry = new THREE.BufferGeometry().setFromPoints([new THREE.Vector3(), end]);
      axes.add(new THREE.Line(geometry, new THREE.LineBasicMaterial({ color: css(name) })));
      const sprite = letter(name, css(name));
      sprite.scale.setScalar(0.045);
      sprite.position.copy(end).multiplyScalar(1.15);
      axes.add(sprite);
    });
    return axes;
  }

  get text() {
    return `grid ${length(this.cell)}`;
  }
}
