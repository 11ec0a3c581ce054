// SPDX-License-Identifier: GPL-3.0-or-later
// Draws the points and lines of clients: a dot of its radius and colour for each point.

import * as THREE from "three";

const kLeast = 2; // [px] of a dot: a smaller one would flicker
// all dots of a drawing together may cover so many pixels: large dots of many points, one behind the
// other, would stop the graphics card, and software is slower yet
const kMostCovered = 4e8;
const kMostCoveredLow = 3e7;

const kHead = `
precision highp float;
uniform mat4 modelViewMatrix;
uniform mat4 projectionMatrix;
attribute vec4 colour;
varying vec3 shade;`;

const kDotVertex = `${kHead}
uniform float height;
uniform float most;
attribute vec4 place;
void main() {
  shade = colour.rgb;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(place.xyz, 1.0);
  float size = place.w * height * projectionMatrix[1][1] / gl_Position.w;
  gl_PointSize = clamp(size, ${kLeast.toFixed(1)}, most);
}`;

const kDotFragment = `
precision highp float;
varying vec3 shade;
void main() {
  vec2 off = 2.0 * gl_PointCoord - 1.0;
  float away = dot(off, off);
  if (away > 1.0) discard;
  gl_FragColor = vec4(shade * (0.55 + 0.45 * sqrt(1.0 - away)), 1.0);
}`;

const kLineVertex = `${kHead}
attribute vec3 position;
void main() {
  shade = colour.rgb;
  gl_Position = projectionMatrix * modelViewMatrix * vec4(position, 1.0);
}`;

const kLineFragment = `
precision highp float;
varying vec3 shade;
void main() {
  gl_FragColor = vec4(shade, 1.0);
}`;

/** Sets an attribute, in the same memory of the graphics card where the length is the same. */
function set_numbers(geometry, name, array, size, normalised = false) {
  const former = geometry.getAttribute(name);
  if (former?.array.length === array.length) {
    former.array = array;
    former.needsUpdate = true;
    return;
  }
  geometry.setAttribute(name, new THREE.BufferAttribute(array, size, normalised));
}

/** The drawing of one client. */
class Drawn {
  constructor(low) {
    this.covered = low ? kMostCoveredLow : kMostCovered;
    this.dots = new THREE.Points(
      new THREE.BufferGeometry(),
      new THREE.RawShaderMaterial({
        vertexShader: kDotVertex,
        fragmentShader: kDotFragment,
        uniforms: { height: { value: 1 }, most: { value: 1 } },
      }),
    );
    this.lines = new THREE.LineSegments(
      new THREE.BufferGeometry(),
      new THREE.RawShaderMaterial({ vertexShader: kLineVertex, fragmentShader: kLineFragment }),
    );
    const viewport = new THREE.Vector4();
    this.dots.onBeforeRender = (renderer) => {
      this.dots.material.uniforms.height.value = renderer.getCurrentViewport(viewport).w;
      this.dots.material.uniformsNeedUpdate = true;
    };
    this.group = new THREE.Group().add(this.dots, this.lines);
    for (const node of this.group.children) node.frustumCulled = false;
  }

  take({ places, colours, lines, line_colours }) {
    const n_points = places.length / 4;
    for (const [node, count] of [
      [this.dots, n_points],
      [this.lines, lines.length / 3],
    ]) {
      node.visible = count > 0;
      // another number of points is other memory
      if (node.geometry.drawRange.count !== count) {
        node.geometry.dispose();
        node.geometry = new THREE.BufferGeometry();
        node.geometry.setDrawRange(0, count);
      }
    }
    set_numbers(this.dots.geometry, "place", places, 4);
    set_numbers(this.dots.geometry, "colour", colours, 4, true);
    set_numbers(this.lines.geometry, "position", lines, 3);
    set_numbers(this.lines.geometry, "colour", line_colours, 4, true);
    const most = Math.sqrt(this.covered / Math.max(n_points, 1));
    this.dots.material.uniforms.most.value = Math.max(most, kLeast);
  }

  dispose() {
    for (const node of this.group.children) {
      node.geometry.dispose();
      node.material.dispose();
    }
  }
}

export class SceneDrawings {
  constructor(low) {
    this.low = low;
    this.group = new THREE.Group();
    this.of_client = new Map();
  }

  /** `drawing` as read_drawing() gives it; null: the client shows nothing any more. */
  show(client, drawing) {
    let drawn = this.of_client.get(client);
    if (drawing === null) {
      if (!drawn) return;
      this.group.remove(drawn.group);
      drawn.dispose();
      this.of_client.delete(client);
      return;
    }
    if (!drawn) {
      drawn = new Drawn(this.low);
      this.group.add(drawn.group);
      this.of_client.set(client, drawn);
    }
    drawn.take(drawing);
  }
}
