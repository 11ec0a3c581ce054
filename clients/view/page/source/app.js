// SPDX-License-Identifier: GPL-3.0-or-later
// Puts the page together: what comes from the bridge goes to the parts, what people do goes back.

import { Connection, take_token } from "./connection.js";
import { Controls, reason_for_no_touch, reason_for_none } from "./controls.js";
import { announce, by_id, write } from "./dom.js";
import { Drawings } from "./drawings.js";
import { follow, judge, kNothingYet, kWell } from "./health.js";
import { History } from "./history.js";
import { Joints } from "./joints.js";
import { each_sample, kQuantities } from "./layout.js";
import { has_pieces, load_eyes, load_pieces, picture_key } from "./loader.js";
import { Banner, note_event, Processes, Readings } from "./panels.js";
import { Player } from "./player.js";
import { kWindow, Plots } from "./plots.js";
import { Stage } from "./stage.js";
import { set_up_stage_tools, show_labels, show_legend } from "./stage_tools.js";
import { set_up_theme } from "./theme.js";
import { Touch } from "./touch.js";

const query = new URLSearchParams(location.search);
const low = query.get("quality") === "low";
const kKept = Number(query.get("keep")); // newest frames that are kept for a test to look at
const kPlotPeriod = low ? 200 : 60; // [ms] between two drawings of the plots
const kTextPeriod = 100; // [ms] of numbers, which nobody reads faster
const kLongestDraw = 50; // [ms] after which the next frame is asked for all the same
const now_s = () => performance.now() / 1000;

const stats = {
  frames_received: 0,
  frames_drawn: 0,
  sequence_gaps: 0,
  samples: 0,
  missing: 0,
  lost: 0,
  reconnects: 0,
  errors: 0,
  leads: 0,
  drawings: 0,
};
const state = {
  ...kNothingYet,
  control: null,
  device: null,
  columns: [],
  scene: null,
  status: null,
};
const kept = []; // as they were decoded
const frames = []; // the newest of each column
let waiting = []; // not drawn yet
let histories = [];
let story = kWell;

const stage = new Stage(by_id("stage"), { low });
const readings = new Readings();
const joints = new Joints();
const processes = new Processes();
const banner = new Banner(announce);
const plots = new Plots(by_id("plots"), {
  on_zoom: () => {
    if (state.source === "log") player.fetch_later();
  },
  on_pick: (time) => player.seek(player.tick_of(time)),
  on_pause: (paused) => {
    write(by_id("plot-pause"), paused ? "Go on" : "Freeze");
    by_id("plot-pause").setAttribute("aria-pressed", String(paused));
  },
  say: announce,
});

const connection = new Connection(
  take_token(),
  {
    heard: () => {
      state.last_message = now_s();
    },
    opened: () => {
      Object.assign(state, { connected: true, opened_once: true, gone: null, last_frame: now_s() });
    },
    closed: () => {
      state.connected = false;
      state.control = null;
      touch.end();
      permit();
    },
    trouble: (text) => note_event(text),
    hello: take_hello,
    scene: take_scene,
    status: (status) => {
      state.status = status;
      processes.take(status, now_s());
    },
    gone: ({ text }) => {
      state.gone = text;
      touch.end();
    },
    control: (control) => {
      state.control = control;
      permit();
    },
    frame: take_frame,
    drawings: (message) => drawings.take(message),
  },
  stats,
);

const drawings = new Drawings({
  show: (client, drawing) => {
    stage.set_drawing(client, drawing);
    stats.drawings += 1;
  },
  trouble: note_event,
});
const controls = new Controls((line) => connection.command(line));
const player = new Player({ send: (message) => connection.send(message), plots, say: announce });
const touch = new Touch(by_id("stage"), stage, {
  hand: () => frames[0]?.tool,
  send: (message) => connection.send(message),
  changed: show_touch,
});

function take_hello(hello) {
  Object.assign(state, {
    source: hello.source,
    gone: null,
    columns: hello.columns,
    last_frame: now_s(),
  });
  if (hello.missed > 0) note_event(`hapticd was away; ${hello.missed.toFixed(1)} s are missing.`);
  if (hello.control) state.control = { allowed: true };
  document.body.dataset.source = hello.source;
  document.body.dataset.several = String(hello.columns.length > 1);
  document.title = `${hello.session} – hapticd`;
  write(by_id("session"), hello.session);
  write(by_id("source"), hello.source === "log" ? "recording" : "live");
  state.picture = null; // a session that began anew may have other meshes
  stage.set_columns(hello.columns.length);
  readings.set_columns(hello.columns);
  plots.set_columns(hello.columns, hello.source === "session");
  if (histories.length !== hello.columns.length) {
    histories = hello.columns.map(() => new History(kQuantities.length, kWindow));
  }
  frames.length = 0;
  state.first_seen = undefined;
  show_labels(stage, hello.columns);
  permit();
}

async function take_scene(scene) {
  state.scene = scene;
  state.device = scene.device;
  write(by_id("device"), scene.device?.description ?? "");
  controls.set_scene(scene);
  joints.set_scene(scene);
  permit();
  if (state.source === "log") player.set_scene(scene);
  const key = picture_key(scene);
  if (key === state.picture) return;
  state.picture = key;
  const { troubles, ...eyes } = await load_eyes(scene);
  if (state.picture !== key) return; // another scene has come meanwhile
  troubles.forEach(note_event);
  if (scene.notice) note_event(scene.notice);
  if (scene.clearance) note_event(scene.clearance.text);
  // who has turned the camera finds it so after the bridge was away
  stage.set_scene(eyes, scene.tool?.radius, scene.limits, key === state.pictured);
  stage.set_clearance(scene.clearance ?? null);
  write(by_id("legend-tightest"), scene.clearance?.text ?? "");
  by_id("legend-tightest").parentElement.hidden = !scene.clearance;
  state.pictured = key;
  by_id("shell").disabled = !stage.has_shell;
  by_id("pieces").disabled = !has_pieces(scene);
  await show_pieces();
  window.hapticd.ready = true;
}

/** The convex pieces instead of the meshes, or no longer; fetched where they are first shown. */
async function show_pieces() {
  const on = by_id("pieces").checked && !by_id("pieces").disabled;
  const { picture } = state;
  if (on && !stage.pieces) {
    const { troubles, ...eyes } = await load_pieces(state.scene);
    if (state.picture !== picture) return; // another scene has come meanwhile
    troubles.forEach(note_event);
    stage.set_pieces(eyes);
  }
  stage.show_pieces(by_id("pieces").checked && on);
}

function permit() {
  const reason = reason_for_none(state);
  controls.permit(reason);
  const no_touch = reason_for_no_touch(state);
  by_id("touch").disabled = no_touch !== null;
  by_id("touch").title = no_touch ?? "";
  write(by_id("touch-reason"), state.source === "log" ? "" : (no_touch ?? ""));
  if (no_touch !== null && touch.on) touch.set_on(false);
}

function show_touch() {
  const button = by_id("touch");
  button.setAttribute("aria-pressed", String(touch.on));
  by_id("hold").hidden = !touch.on;
  by_id("hold").setAttribute("aria-pressed", String(touch.hold));
  by_id("stage").dataset.touch = touch.leading ? "leading" : touch.on ? "on" : "";
  by_id("touch-hint").hidden = !touch.on;
  stats.leads = touch.sent;
  if (frames[0])
    stage.models[0].show_intent(
      touch.intent ?? (frames[0].leading ? frames[0].intent : null),
      frames[0].tool,
    );
  stage.dirty = true;
}

function take_frame(frame) {
  state.last_frame = now_s();
  if (frame.column === 0)
    Object.assign(state, { age_servo: frame.age_servo, age_contact: frame.age_contact });
  frames[frame.column] = frame;
  waiting = [...waiting.filter(({ column }) => column !== frame.column), frame];
  // of the ticks since the last frame those without a sample; the frame shows the newest of them
  const missing = frame.unseen > 0 ? Math.max(frame.unseen + 1 - frame.samples.count, 0) : 0;
  stats.missing += missing;
  stats.lost += frame.lost;
  owed = frame.sequence;
  kept.push(frame);
  if (kept.length > kKept) kept.shift();
  asking ??= setTimeout(ask_on, kLongestDraw);
  const history = histories[frame.column];
  if (state.source !== "session" || !history) return;
  if (missing > 0) history.leave_gap();
  each_sample(frame.samples, connection.layout.sample, (time, values) =>
    history.push(time, values),
  );
  stats.samples += frame.samples.count;
}

let asking = null;
let owed = null; // sequence of the newest frame, until the bridge is told that it is here

/** Tells the bridge that it may send; at the latest a moment after a frame, so that no sample is lost
 *  where drawing is slow. A hidden page asks for nothing. */
function ask_on() {
  clearTimeout(asking);
  asking = null;
  if (document.hidden || owed === null) return;
  state.asked = now_s();
  connection.send({ type: "shown", sequence: owed });
  owed = null;
}

let text_due = 0;
let plots_due = 0;

const kSlowPicture = 40; // [ms] of a picture, beyond which pictures are drawn less often
const kLongestRest = 250; // [ms] after a picture: the first one waits long for its shaders
let drawn_at = null; // when the last picture was begun, until its duration is known
let picture_due = 0;

/** Where pictures are slow they take at most half of the time: samples must not wait for them. */
function draw_picture(time) {
  const took = drawn_at === null ? 0 : time - drawn_at;
  if (took > kSlowPicture) picture_due = time + Math.min(took, kLongestRest);
  drawn_at = null;
  if (time < picture_due || !stage.draw()) return;
  drawn_at = time;
  window.hapticd.drawn ||= window.hapticd.ready && stage.newest[0] !== undefined;
}

/** Once for each picture of the display: draws what is new and tells the bridge. */
function draw(time) {
  requestAnimationFrame(draw);
  const drawn = waiting;
  waiting = [];
  for (const frame of drawn) stage.show(frame, frame.column === 0 ? touch.intent : null);
  draw_picture(time);
  if (drawn.length > 0) {
    stats.frames_drawn += drawn.length;
    ask_on();
    window.hapticd.latest = frames[0];
  }
  if (state.source === "session" && time >= plots_due && drawn.length > 0) {
    plots_due = time + kPlotPeriod;
    plots.take(histories);
  }
  if (time >= text_due) {
    text_due = time + kTextPeriod;
    show_texts();
  }
}

/** When the session or the recording began, on its clock [s]; where the bridge does not say it, the
 *  first frame that this page has seen. */
function began() {
  state.first_seen ??= frames[0].time;
  return state.scene?.started ?? state.scene?.first_time ?? state.first_seen;
}

function show_texts() {
  if (!frames[0]) return;
  const origin = began();
  plots.set_origin(origin);
  for (const frame of frames) if (frame) readings.show(frame, origin);
  joints.show(frames[0]);
  controls.show(frames[0], state.status, state.source === "log");
  if (state.source === "log") player.show(frames[0]);
  const now = now_s();
  processes.show(
    state.source === "session" ? frames[0] : null,
    now - Math.max(state.last_frame, state.asked),
    now,
  );
}

const kStoodStill = 0.4; // [s] between two looks, which are 0.1 s apart
let watched_at = 0;

function link_text(bad) {
  if (bad) return "not current";
  if (!state.connected) return "connecting";
  return state.source === "log" ? "connected" : "current";
}

/** By a timer and not with the pictures: it must speak up where no picture is drawn any more. */
function watch_health() {
  const now = now_s();
  // a page that stood still itself has messages waiting: it gives them their second
  if (now - watched_at > kStoodStill) state.asked = state.last_message = now;
  watched_at = now;
  const step = follow(story, judge(state, now), now, stats.missing);
  story = step.story;
  banner.show(step.alerts, step.recovered);
  const bad = step.alerts.some(({ level }) => level === "bad");
  document.body.dataset.health = bad ? "bad" : state.connected ? "good" : "none";
  write(by_id("link"), link_text(bad));
}

document.addEventListener("visibilitychange", () => {
  state.visible = !document.hidden;
  state.asked = now_s();
  if (!document.hidden) ask_on();
  drawings.load();
});

window.hapticd = {
  stats,
  latest: null,
  ready: false, // the meshes are loaded
  drawn: false, // and a frame has been drawn with them
  kept,
  frames,
  state,
  stage,
  plots,
  touch,
};
stage.on_draw = show_legend;
set_up_stage_tools({ stage, plots, player, touch, state, show_pieces });
set_up_theme(() => {
  stage.theme();
  plots.redraw();
  player.draw_marks();
});
permit();
if (stage.renderer === null) {
  note_event(
    "This browser has no WebGL, so there is no picture. Numbers, plots and controls work.",
  );
  by_id("no-picture").hidden = false;
}
setInterval(watch_health, 100);
requestAnimationFrame(draw);
