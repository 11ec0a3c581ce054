// SPDX-License-Identifier: GPL-3.0-or-later
// Touch without a device: mouse, fingers or keys lead where the simulated hand means to go.

const kPeriod = 1000 / 60; // [ms] between two `lead`
const kKeySpeed = 0.35; // of the scene's size in a second
const kWheel = 0.0006; // of the scene's size for a pixel of the wheel
const kPinch = 0.004; // the same for a pixel between two fingers

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
    if (!this.on || !pose || !Array.from(pose.slice(0, 3)).every(Number.isFinite)) return false;
    this.intent = [pose[0], pose[1], pose[2]];
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
    const step = kKeySpeed * this.stage.size * dt;
    for (const key of this.keys) this.shift(...kKeys[key].map((part) => part * step));
    if (this.send({ type: "lead", position: this.intent })) this.sent += 1;
    this.changed();
  }

  /** Moves the intent by metres to the right, up and away in the picture. */
  shift(right, up, forward) {
    if (this.intent === null) return;
    const plane = this.stage.plane();
    const parts = [
      [plane.right, right],
      [plane.up, up],
      [plane.forward, forward],
    ];
    this.intent = this.intent.map(
      (value, axis) =>
        value +
        parts.reduce((sum, [direction, size]) => sum + size * direction.getComponent(axis), 0),
    );
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
    if (!before || this.intent === null) return;
    const apart = this.distance();
    const now = [event.clientX, event.clientY];
    this.pointers.set(event.pointerId, now);
    if (this.pointers.size >= 2) {
      this.shift(0, 0, (this.distance() - apart) * kPinch * this.stage.size);
      return;
    }
    const scale = this.stage.metres_per_pixel(this.intent);
    this.shift((now[0] - before[0]) * scale, (before[1] - now[1]) * scale, 0);
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
    const pixels = event.deltaMode === 1 ? event.deltaY * 16 : event.deltaY;
    this.shift(0, 0, -pixels * kWheel * this.stage.size);
  }

  key_down(event) {
    if (!this.on || event.ctrlKey || event.metaKey || event.altKey) return;
    if (event.key === "Escape") return this.set_on(false);
    if (event.key === " ") {
      event.preventDefault();
      return event.repeat ? undefined : this.set_hold(!this.hold);
    }
    const key = key_of(event);
    if (!(key in kKeys)) return undefined;
    event.preventDefault();
    if (this.begin()) this.keys.add(key);
    return undefined;
  }

  key_up(event) {
    if (this.keys.delete(key_of(event))) this.end_if_idle();
  }
}
