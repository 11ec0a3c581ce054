// SPDX-License-Identifier: GPL-3.0-or-later
// Touch without a device: mouse, fingers or keys lead where the simulated hand means to go, and with
// Shift how it means to hold the tool.

const kPeriod = 1000 / 60; // [ms] between two `lead`
const kKeySpeed = 0.35; // of the scene's size in a second
const kWheel = 0.0006; // of the scene's size for a pixel of the wheel
const kPinch = 0.004; // the same for a pixel between two fingers
const kKeyTurn = 1; // [rad/s]
const kDragTurn = 0.008; // [rad] for a pixel
const kWheelTurn = 0.001; // [rad] for a pixel of the wheel

/** Direction in the picture: [right, up, forward]. */
const kKeys = {
  ArrowLeft: [-1, 0, 0],
  ArrowRight: [1, 0, 0],
  ArrowUp: [0, 1, 0],
  ArrowDown: [0, -1, 0],
  a: [-1, 0, 0],
  d: [1, 0, 0],
  w: [0, 1, 0],
  s: [0, -1, 0],
  PageUp: [0, 0, 1],
  PageDown: [0, 0, -1],
  e: [0, 0, 1],
  q: [0, 0, -1],
};

/** Product of quaternions [w, x, y, z], normalised. */
function product(a, b) {
  const q = [
    a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
    a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
    a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
    a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
  ];
  const length = Math.hypot(...q);
  return q.map((part) => part / length);
}

const key_of = (event) => (event.key.length === 1 ? event.key.toLowerCase() : event.key);

/**
 * Leads while a pointer is down, a movement key is pressed, or "hold" is on. `hand()` gives the
 * tool's pose now, `send(message)` sends, `changed()` is called when intent or state changes.
 */
export class Touch {
  constructor(canvas, stage, { hand, send, changed }) {
    Object.assign(this, { canvas, stage, hand, send, changed });
    this.on = false;
    this.hold = false;
    this.intent = null;
    this.orientation = null; // [w, x, y, z] of the tool in W
    this.turning = false; // Shift is pressed
    this.pointers = new Map();
    this.keys = new Set();
    this.sent = 0;
    this.timer = null;
    this.listen();
  }

  get leading() {
    return this.intent !== null;
  }

  set_on(on) {
    this.on = on;
    this.stage.orbit.enabled = !on;
    if (!on) this.end();
    this.changed();
  }

  set_hold(hold) {
    this.hold = hold && this.begin();
    if (!this.hold) this.end_if_idle();
    this.changed();
  }

  listen() {
    const { canvas } = this;
    canvas.addEventListener("pointerdown", (event) => this.down(event));
    canvas.addEventListener("pointermove", (event) => this.moved(event));
    for (const name of ["pointerup", "pointercancel", "lostpointercapture"]) {
      canvas.addEventListener(name, (event) => this.up(event));
    }
    canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    canvas.addEventListener("keydown", (event) => this.key_down(event));
    canvas.addEventListener("keyup", (event) => this.key_up(event));
    canvas.addEventListener("blur", () => this.end());
    window.addEventListener("blur", () => this.end());
    window.addEventListener("pagehide", () => this.end());
    document.addEventListener("visibilitychange", () => {
      if (document.hidden) this.end();
    });
  }

  /** The intent begins at the hand; without a finite pose of it nothing is led. */
  begin() {
    if (this.intent !== null) return true;
    const pose = this.hand();
    if (!this.on || !pose || !Array.from(pose).every(Number.isFinite)) return false;
    this.intent = [pose[0], pose[1], pose[2]];
    this.orientation = product([1, 0, 0, 0], Array.from(pose.slice(3, 7)));
    this.last = performance.now();
    this.timer = setInterval(() => this.tick(), kPeriod);
    this.changed();
    return true;
  }

  end() {
    this.pointers.clear();
    this.keys.clear();
    this.hold = false;
    if (this.intent === null) return;
    clearInterval(this.timer);
    this.intent = null;
    this.send({ type: "release" });
    this.changed();
  }

  end_if_idle() {
    if (this.pointers.size === 0 && this.keys.size === 0 && !this.hold) this.end();
  }

  tick() {
    const now = performance.now();
    const dt = Math.min((now - this.last) / 1000, 0.1);
    this.last = now;
    const step = this.turning ? kKeyTurn * dt : kKeySpeed * this.stage.size * dt;
    for (const key of this.keys) {
      const way = kKeys[key].map((part) => part * step);
      if (this.turning) this.turn(...way);
      else this.shift(...way);
    }
    const { intent: position, orientation } = this;
    if (this.send({ type: "lead", position, orientation })) this.sent += 1;
    this.changed();
  }

  /** The vector in W with these parts to the right, up and away in the picture. */
  in_scene(right, up, forward) {
    const plane = this.stage.plane();
    return [0, 1, 2].map(
      (axis) =>
        right * plane.right.getComponent(axis) +
        up * plane.up.getComponent(axis) +
        forward * plane.forward.getComponent(axis),
    );
  }

  /** Moves the intent by metres to the right, up and away in the picture. */
  shift(right, up, forward) {
    if (this.intent === null) return;
    const way = this.in_scene(right, up, forward);
    this.intent = this.intent.map((value, axis) => value + way[axis]);
  }

  /** Turns the tool such that its near side goes to the right and up, and clockwise [rad]. */
  turn(right, up, clockwise) {
    if (this.intent === null) return;
    const axis = this.in_scene(-up, right, clockwise);
    const angle = Math.hypot(...axis);
    if (!(angle > 0)) return;
    const share = Math.sin(angle / 2) / angle;
    const by = [Math.cos(angle / 2), ...axis.map((part) => share * part)];
    this.orientation = product(by, this.orientation);
  }

  down(event) {
    if (!this.on || (event.pointerType === "mouse" && event.button !== 0)) return;
    event.preventDefault();
    this.canvas.focus({ preventScroll: true });
    this.canvas.setPointerCapture(event.pointerId);
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (!this.begin()) this.pointers.clear();
  }

  moved(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before || this.intent === null) return undefined;
    const apart = this.distance();
    const now = [event.clientX, event.clientY];
    this.pointers.set(event.pointerId, now);
    if (this.pointers.size >= 2) {
      return this.shift(0, 0, (this.distance() - apart) * kPinch * this.stage.size);
    }
    const [right, up] = [now[0] - before[0], before[1] - now[1]];
    if (event.shiftKey) return this.turn(right * kDragTurn, up * kDragTurn, 0);
    const scale = this.stage.metres_per_pixel(this.intent);
    return this.shift(right * scale, up * scale, 0);
  }

  distance() {
    const [a, b] = [...this.pointers.values()];
    return a && b ? Math.hypot(a[0] - b[0], a[1] - b[1]) : 0;
  }

  up(event) {
    if (!this.pointers.delete(event.pointerId)) return;
    this.end_if_idle();
  }

  wheel(event) {
    if (!this.on || this.intent === null) return;
    event.preventDefault();
    // with Shift some browsers turn the wheel sideways
    const turned = event.deltaY || event.deltaX;
    const pixels = event.deltaMode === 1 ? turned * 16 : turned;
    if (event.shiftKey) this.turn(0, 0, pixels * kWheelTurn);
    else this.shift(0, 0, -pixels * kWheel * this.stage.size);
  }

  key_down(event) {
    if (!this.on || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape") return this.set_on(false);
    if (event.key === " ") {
      event.preventDefault();
      return event.repeat ? undefined : this.set_hold(!this.hold);
    }
    this.turning = event.shiftKey;
    const key = key_of(event);
    if (!(key in kKeys)) return undefined;
    event.preventDefault();
    if (this.begin()) this.keys.add(key);
    return undefined;
  }

  key_up(event) {
    this.turning = event.shiftKey;
    if (this.keys.delete(key_of(event))) this.end_if_idle();
  }
}
