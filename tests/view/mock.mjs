// SPDX-License-Identifier: GPL-3.0-or-later
// A bridge without a session: serves the built page and synthetic frames after docs/view-protocol.md.
// By hand: node mock.mjs --view FOLDER [--port 8871] [--log] [--columns 4] [--growing]
import { createServer } from "node:http";
import { readFile } from "node:fs/promises";
import { extname, join } from "node:path";
import { fileURLToPath } from "node:url";
import { WebSocketServer } from "ws";
import { ball, encode, encode_drawing, make_layout, octants } from "./mock_layout.mjs";
import { Recording } from "./mock_recording.mjs";
import { frame_at, kPeriod, kRadius } from "./mock_session.mjs";

export const kToken = "a-token-of-the-mock";
const kTypes = {
  ".html": "text/html; charset=utf-8",
  ".js": "text/javascript",
  ".css": "text/css",
  ".svg": "image/svg+xml",
  ".txt": "text/plain; charset=utf-8",
};
const kHeaders = {
  "Cache-Control": "no-store",
  "Content-Security-Policy": "default-src 'self'",
  "X-Content-Type-Options": "nosniff",
};
const kNames = ["god-object3", "virtual-proxy3", "penalty3", "voxel"];

/** What the tests change while it runs: `trouble` is null, "servo", "contact", "silent" or "gone". */
export class Mock {
  constructor({
    view,
    log = false,
    columns = 1,
    growing = false,
    simulated = true,
    pieces = false,
  }) {
    this.layout = make_layout();
    this.view = view;
    this.columns = columns === 1 ? ["session"] : kNames.slice(0, columns);
    this.recording = log ? new Recording(columns, growing) : null;
    this.simulated = simulated;
    this.pieces = pieces; // whether there are convex pieces of the ball
    this.trouble = null;
    this.faults = [];
    this.giving = []; // {name, text, well}
    this.fault = 0;
    this.paused = false;
    this.stiffness = 600;
    this.renderer = 0;
    this.received = []; // every message of a page
    this.led = null;
    this.intent = null;
    this.drawn = new Map(); // by client: {number, points, lines, bytes}
    this.began = performance.now() - 20000;
    this.meshes = {
      "/mesh/0.bin": ball("ball", 0, [0.62, 0.68, 0.75, 1], kRadius, 32, 1500),
      "/mesh/1.bin": ball("bead", 1, [0.85, 0.72, 0.35, 1], 0.009, 16),
      "/pieces/0.bin": octants("ball", 0, kRadius),
    };
  }

  get tick() {
    return Math.floor((performance.now() - this.began) / 1000 / kPeriod);
  }

  scene() {
    const renderers = [
      ["god-object3"],
      ["penalty3"],
      ["virtual-proxy3"],
      ["direct6", "needs a [tool]"],
      ["voxel", "needs a [tool]"],
      ["god-object6", "needs a [tool]"],
      ["constrained6", "needs a [tool]"],
      ["localized", "needs a [tool]"],
      ["sensation", "needs a [tool]"],
    ];
    return {
      session: this.recording ? "run.mcap" : "demo",
      objects: [
        { index: 0, name: "ball", mesh: "/mesh/0.bin", pieces: this.pieces && "/pieces/0.bin" },
        { index: 1, name: "bead", mesh: "/mesh/1.bin", pieces: null },
      ],
      tool: { radius: 0.0015 },
      renderers: renderers.map(([name, lack]) => ({
        name,
        available: !lack,
        lack: lack ?? "",
        has_solver: ["virtual-proxy3", "direct6", "voxel", "localized", "sensation"].includes(name), // one that can be chosen too
      })),
      renderer: "god-object3",
      solvers: ["direct", "penalty-dynamics", "quasi-static"],
      device: {
        description: this.simulated ? "simulated hand" : "WoodenHaptics",
        simulated: this.simulated,
        max_force: 8,
        max_torque: 0.2,
      },
      limits: { max_force: 6, max_torque: 0.2, stiffness: 600 },
      config: "",
      ...this.recording?.scene(),
    };
  }

  async answer(request, response) {
    const url = new URL(request.url, "http://localhost");
    const made = {
      "/layout.json": () => this.layout,
      "/scene.json": () => this.scene(),
      "/overview.json": () => this.recording?.overview(url.searchParams),
    }[url.pathname];
    const send = (code, type, body) =>
      response.writeHead(code, { ...kHeaders, "Content-Type": type }).end(body);
    if (made) return send(200, "application/json", JSON.stringify(made()));
    if (this.meshes[url.pathname])
      return send(200, "application/octet-stream", this.meshes[url.pathname]);
    const drawn = this.drawn.get(Number(/^\/drawn\/(\d)\.bin$/.exec(url.pathname)?.[1]));
    if (drawn) return send(200, "application/octet-stream", drawn.bytes);
    if (url.pathname === "/export.csv")
      return send(200, "text/csv", `tick\n${url.searchParams.get("from")}\n`);
    const file = url.pathname === "/" ? "/index.html" : url.pathname;
    try {
      return send(
        200,
        kTypes[extname(file)] ?? "application/octet-stream",
        await readFile(join(this.view, file)),
      );
    } catch {
      return send(404, "text/plain", "not found");
    }
  }

  listen(port = 0) {
    this.server = createServer((request, response) => this.answer(request, response));
    this.sockets = new WebSocketServer({
      server: this.server,
      path: "/view",
      handleProtocols: (offered) => (offered.has("hapticd.view.v1") ? "hapticd.view.v1" : false),
    });
    this.sockets.on("connection", (socket) => new Viewer(this, socket));
    this.status_timer = setInterval(() => this.each((viewer) => viewer.status()), 1000);
    this.lead_timer = setInterval(() => this.lead_on(), 5);
    return new Promise((ready) => {
      this.server.listen(port, "127.0.0.1", () =>
        ready(`http://127.0.0.1:${this.server.address().port}/`),
      );
    });
  }

  // the simulated hand follows its intent with a lag and stays on the ball, as a spring would hold it
  lead_on() {
    if (!this.intent) return;
    const hand = this.led ?? this.intent;
    const next = hand.map((value, i) => value + 0.06 * (this.intent[i] - value));
    const far = Math.hypot(...next);
    const shallow = Math.max(far, kRadius - 0.004);
    this.led = next.map((value) => (value * shallow) / far);
  }

  each(action) {
    for (const socket of this.sockets.clients) if (socket.viewer) action(socket.viewer);
  }

  set_trouble(trouble) {
    this.trouble = trouble;
    if (trouble === "gone")
      this.each((viewer) => viewer.say({ type: "gone", text: "hapticd has ended." }));
    if (trouble === null) this.each((viewer) => viewer.greet(0));
  }

  drawings() {
    const drawings = Array.from(this.drawn, ([client, { number, points, lines }]) => ({
      client,
      number: String(number),
      points,
      lines,
      path: `/drawn/${client}.bin`,
    }));
    return { type: "drawings", drawings };
  }

  /** A client draws {points, lines} (encode_drawing), or leaves: null. */
  draw(client, drawing) {
    const { points = [], lines = [] } = drawing ?? {};
    const number = (this.drawn.get(client)?.number ?? 0) + 1;
    const bytes = encode_drawing({ points, lines });
    if (drawing) this.drawn.set(client, { number, points: points.length, lines: lines.length, bytes });
    else this.drawn.delete(client);
    this.each((viewer) => viewer.say(this.drawings()));
  }

  drop_sockets() {
    for (const socket of this.sockets.clients) socket.terminate();
  }

  /** Grows the recording, and says so. */
  grow(ticks) {
    this.recording.last_tick += ticks;
    this.each((viewer) => viewer.say({ type: "scene", ...this.scene() }));
  }

  close() {
    clearInterval(this.status_timer);
    clearInterval(this.lead_timer);
    this.drop_sockets();
    return new Promise((done) => {
      this.server.close(done);
      this.server.closeAllConnections?.();
    });
  }
}

/** One page: a frame in flight, the newest wins. */
class Viewer {
  constructor(mock, socket) {
    Object.assign(this, {
      mock,
      socket,
      sequence: 0,
      in_flight: false,
      since: mock.tick - 1,
      control: false,
    });
    socket.viewer = this;
    this.player = mock.recording?.player();
    socket.on("message", (text) => this.take(JSON.parse(text)));
    const timer = setInterval(() => this.send_frames(), 1000 / 60);
    socket.on("close", () => clearInterval(timer));
    this.greet();
  }

  say(message) {
    if (this.mock.trouble !== "silent") this.socket.send(JSON.stringify(message));
  }

  greet(missed) {
    const { mock } = this;
    this.say({
      type: "hello",
      version: 1,
      source: mock.recording ? "log" : "session",
      session: mock.recording ? "run.mcap" : "demo",
      columns: mock.columns,
      control: this.control,
      missed,
    });
    this.say({ type: "scene", ...mock.scene() });
    if (mock.drawn.size > 0) this.say(mock.drawings());
    this.status();
  }

  status() {
    const { mock } = this;
    if (mock.recording || mock.trouble === "gone") return;
    const row = (name, pid, rate, age) => ({ name, pid, generation: 1, runs: true, age, rate });
    this.say({
      type: "status",
      processes: [
        row("hapticd", 400, 0, 0.1),
        row("servo0", 401, 1000, 0.001),
        row("contact0", 402, 950, 0.002),
        row("sim", 403, 120, 0.005),
      ],
      clients: 1,
      viewers: mock.sockets.clients.size,
      missed: 0,
      giving: mock.giving,
      faults: mock.faults,
      warnings: [],
    });
  }

  send_frames() {
    const { mock } = this;
    if (this.in_flight || mock.trouble === "silent" || mock.trouble === "gone") return;
    const tick = this.player ? this.player.advance() : mock.tick;
    if (this.player && tick === this.since && this.sequence > 0) return;
    mock.columns.forEach((_, column) => this.send_frame(tick, column));
    this.since = tick;
    this.in_flight = true;
  }

  send_frame(tick, column) {
    const { mock } = this;
    const options = { led: mock.led, stiffness: mock.stiffness, faults: Boolean(mock.recording) };
    const stopped = mock.trouble === "servo";
    const frame = frame_at(stopped ? this.since : tick, this.since, column, options);
    if (stopped)
      Object.assign(frame, { age_servo: (tick - this.since) * kPeriod + 0.5, samples: [] });
    if (mock.trouble === "contact") Object.assign(frame, { age_contact: 1.5, flags: 16 });
    frame.unseen = Math.max(tick - this.since - 1, 0);
    this.sequence += 1;
    const { paused, renderer } = mock;
    Object.assign(frame, {
      sequence: this.sequence,
      paused: paused ? 1 : 0,
      renderer,
      leading: mock.intent ? 1 : 0,
      intent: mock.intent ?? [0, 0, 0],
    });
    if (mock.fault) Object.assign(frame, { fault: mock.fault, flags: 256, force: [0, 0, 0] });
    if (paused) frame.flags = 1024;
    this.socket.send(encode(mock.layout, frame));
  }

  take(message) {
    const { mock } = this;
    mock.received.push(message);
    if (message.type === "shown") this.in_flight = false;
    else if (message.type === "token") {
      this.control = message.token === kToken;
      this.say({
        type: "control",
        allowed: this.control,
        reason: this.control ? "" : "The token is not that of this session.",
      });
    } else if (message.type === "command") this.command(message);
    else if (message.type === "lead" && this.control) mock.intent = message.position;
    else if (message.type === "release") mock.intent = mock.led = null;
    else this.player?.take(message);
  }

  command({ id, line }) {
    const { mock } = this;
    const [word, key, value] = line.split(" ");
    const reply = (ok, text) => this.say({ type: "answer", id, ok, text });
    if (!this.control) return reply(false, "watching only");
    if (word === "pause" || word === "resume") mock.paused = word === "pause";
    else if (word === "clear-fault") mock.fault = 0;
    else if (key === "stiffness") mock.stiffness = Number(value);
    else if (key === "renderer")
      mock.renderer = mock.scene().renderers.findIndex(({ name }) => name === value);
    else if (key === "solver") return reply(false, "cannot set 'solver'");
    return reply(true, "done");
  }
}

if (process.argv[1] === fileURLToPath(import.meta.url)) {
  const option = (name, usual) => {
    const at = process.argv.indexOf(`--${name}`);
    return at < 0 ? usual : process.argv[at + 1];
  };
  const has = (name) => process.argv.includes(`--${name}`);
  const mock = new Mock({
    view: option("view", "../../build/view"),
    log: has("log"),
    growing: has("growing"),
    columns: Number(option("columns", 1)),
  });
  console.log(`${await mock.listen(Number(option("port", 8871)))}#token=${kToken}`);
}
