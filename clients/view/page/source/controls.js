// SPDX-License-Identifier: GPL-3.0-or-later
// The controls of a session: what they may, what they send, and the answers beside them.

import { announce, by_id, make, write } from "./dom.js";
import { shown_troubles } from "./words.js";

const kNoToken =
  "Watching only. To control, open the address with the token that hapt view printed.";
const kAnswerShown = 12000; // [ms]

/** Why the controls do nothing; null: they may be used. */
export function reason_for_none({ connected, source, control }) {
  if (source === "log") return "This is a recording: there is nothing to control.";
  if (!connected) return "Not connected to the bridge.";
  if (control?.allowed) return null;
  return control?.reason || kNoToken;
}

/** Why nothing can be led by touch; null: it can. */
export function reason_for_no_touch(state) {
  const none = reason_for_none(state);
  if (none !== null) return none;
  if (!state.device) return "The bridge does not say whether the hand is simulated.";
  if (!state.device.simulated) {
    return "The hand is a real device (or a recorded one): only a simulated hand can be led.";
  }
  return null;
}

/** Why no solver can be chosen; null: one can. */
export function reason_for_no_solver({ renderers = [], solvers = [] }, frame) {
  const renderer = renderers[frame?.renderer];
  if (solvers.length < 2) return "The bridge names no solvers.";
  if (renderer?.has_solver !== false) return null;
  const names = renderers.filter(({ has_solver }) => has_solver).map(({ name }) => name);
  return `${renderer.name} has no solver to choose; ${names.join(" and ")} have.`;
}

function fill(select, options, chosen) {
  const signature = JSON.stringify(options);
  if (select.dataset.signature !== signature) {
    select.dataset.signature = signature;
    select.replaceChildren(
      ...options.map(({ value, text, disabled }) =>
        make("option", { value, disabled: Boolean(disabled), title: text }, text),
      ),
    );
  }
  if (!select.dataset.chosen && chosen !== undefined) select.value = chosen;
}

export class Controls {
  /** command(line) sends a line and gives {ok, text}. */
  constructor(command) {
    this.command = command;
    this.scene = null;
    this.frame = null;
    this.listen();
  }

  listen() {
    const on = (id, event, action) => by_id(id).addEventListener(event, action);
    for (const [key, unit] of [
      ["renderer", ""],
      ["solver", ""],
      ["stiffness", " N/m"],
    ]) {
      // what is being chosen stays until it has been set; the frames say what holds
      on(key, "input", () => (by_id(key).dataset.chosen = "yes"));
      on(`${key}-form`, "submit", (event) => {
        event.preventDefault();
        this.set(key, unit);
      });
    }
    on("pause", "click", () => this.give(this.frame?.paused ? "resume" : "pause"));
    on("arm", "click", () => this.give(this.frame?.armed ? "disarm" : "arm"));
    on("clear-fault", "click", () => this.give("clear-fault"));
  }

  async set(key, unit) {
    const field = by_id(key);
    await this.give(`set ${key} ${key === "stiffness" ? Number(field.value) : field.value}${unit}`);
    delete field.dataset.chosen;
  }

  async give(line) {
    this.answer(`${line} …`, null);
    const { ok, text } = await this.command(line);
    this.answer(`${line}: ${text || (ok ? "done" : "refused")}`, ok);
  }

  answer(text, ok) {
    const place = by_id("answer");
    write(place, text);
    place.dataset.ok = ok === null ? "" : String(ok);
    if (ok !== null) announce(text);
    clearTimeout(this.timer);
    if (ok) this.timer = setTimeout(() => write(place, ""), kAnswerShown);
  }

  set_scene(scene) {
    this.scene = scene;
    this.show_choices();
  }

  /** Opens or closes all of them, with the reason. */
  permit(reason) {
    by_id("control-set").disabled = reason !== null;
    by_id("control-reason").hidden = reason === null;
    write(by_id("control-reason"), reason ?? "");
    by_id("control-set").setAttribute("aria-describedby", "control-reason");
  }

  show(frame, status, of_log) {
    this.frame = frame;
    this.show_choices();
    write(by_id("pause"), frame.paused ? "Resume" : "Pause");
    write(by_id("arm"), frame.armed ? "Disarm" : "Arm");
    const faulted = frame.fault > 0;
    by_id("clear-fault").disabled = !faulted;
    const stiffness = by_id("stiffness");
    if (!stiffness.dataset.chosen) {
      stiffness.value = Math.round(frame.stiffness);
    }
    const troubles = shown_troubles(status, frame);
    // in a recording nothing can be mended any more
    this.show_troubles(of_log ? troubles.map((trouble) => ({ ...trouble, remedy: "" })) : troubles);
  }

  show_choices() {
    if (!this.scene) return;
    const renderers = this.scene.renderers ?? [];
    const chosen = renderers[this.frame?.renderer]?.name ?? this.scene.renderer;
    fill(
      by_id("renderer"),
      renderers.map(({ name, available, lack }) => ({
        value: name,
        disabled: !available,
        text: available ? name : `${name}: ${lack || "not available"}`,
      })),
      chosen,
    );
    const solvers = this.scene.solvers ?? [];
    fill(
      by_id("solver"),
      solvers.map((name) => ({ value: name, text: name })),
      solvers[this.frame?.solver],
    );
    const no_solver = reason_for_no_solver(this.scene, this.frame);
    by_id("solver").disabled = by_id("solver-set").disabled = no_solver !== null;
    by_id("solver").title = by_id("solver-set").title = no_solver ?? "";
    by_id("solver-reason").hidden = no_solver === null;
    write(by_id("solver-reason"), no_solver ?? "");
  }

  show_troubles(list) {
    const signature = JSON.stringify(list);
    if (this.told === signature) return;
    this.told = signature;
    by_id("troubles").replaceChildren(
      ...list.map(({ text, remedy, level }) =>
        make("li", { className: level }, make("strong", {}, text), remedy ? ` ${remedy}` : ""),
      ),
    );
    by_id("trouble-section").hidden = list.length === 0;
    if (list.length > 0) announce(`${list[0].text} ${list[0].remedy}`);
  }
}
