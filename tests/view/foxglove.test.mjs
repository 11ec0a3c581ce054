// SPDX-License-Identifier: GPL-3.0-or-later
// The bridge of a running session as Foxglove and Lichtblick see it: the public client of the
// protocol subscribes, the public decoder of ROS 2 messages reads the records, and each number is
// compared with that of a recording of the same ticks, as `hapt export` writes it.
// BIN names the folder of the programs. Run: node --test foxglove.test.mjs
import assert from "node:assert/strict";
import { spawn, spawnSync } from "node:child_process";
import { existsSync, mkdtempSync, rmSync, statSync } from "node:fs";
import { createRequire } from "node:module";
import { tmpdir } from "node:os";
import { dirname, join, resolve } from "node:path";
import { after, before, test } from "node:test";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const bin = resolve(process.env.BIN ?? join(here, "../../build/dev/bin"));
const names = ["@foxglove/ws-protocol", "@foxglove/rosmsg", "@foxglove/rosmsg2-serialization", "ws"];
const require = createRequire(import.meta.url);
const modules = names.map((name) => {
  try {
    return require(name);
  } catch {
    return undefined;
  }
});
const lack = modules.includes(undefined)
  ? "SKIPPED: the public client is not installed: npm ci --ignore-scripts"
  : !existsSync(join(bin, "haptic-view"))
    ? `SKIPPED: no haptic-view in ${bin}: build it, or set BIN`
    : false;
if (lack) console.error(lack);
const [protocol, rosmsg, serialization, ws] = modules;

const kPatience = 60000; // [ms]
const kEnough = 20; // messages of the servo
const topics = ["/servo0/frame", "/contact0/set", "/sim/frame", "/control/frame"];
const running = [];
let folder;
let address;

function start(program, words) {
  const child = spawn(join(bin, program), words, {
    env: { ...process.env, HAPTICD_RUNTIME_DIR: folder },
    stdio: ["ignore", "pipe", "pipe"],
  });
  child.said = "";
  for (const stream of [child.stdout, child.stderr]) stream.on("data", (text) => (child.said += text));
  running.push(child);
  return child;
}

async function eventually(holds, what) {
  for (const end = Date.now() + kPatience; !(await holds()); ) {
    assert.ok(Date.now() < end, what);
    await new Promise((done) => setTimeout(done, 50));
  }
}

function ended(child, signal) {
  if (child.exitCode !== null) return undefined;
  const end = new Promise((done) => child.once("exit", done));
  child.kill(signal);
  return end;
}

before(async () => {
  if (lack) return;
  folder = mkdtempSync(join(tmpdir(), "hapticd-foxglove-"));
  start("hapticd", [join(here, "../../configs/plane.toml"), "--session", "foxglove"]);
  await eventually(() => existsSync(join(folder, "foxglove.sock")), "hapticd starts");
  const bridge = start("haptic-view", ["view", "foxglove", "--port", "0", "--no-open"]);
  await eventually(() => /127.0.0.1:\d+\/#token=.*\n/.test(bridge.said), "the bridge starts");
  address = `ws://127.0.0.1:${bridge.said.match(/127.0.0.1:(\d+)/)[1]}`;
});

after(async () => {
  for (const child of running.reverse()) await ended(child, "SIGTERM");
  if (folder) rmSync(folder, { recursive: true, force: true });
});

/** What a client of that sub-protocol is sent until it has enough: topic to decoded messages. */
function listen(name) {
  const socket = new ws.WebSocket(address, [name]);
  const client = new protocol.FoxgloveClient({ ws: socket });
  const channels = new Map();
  const messages = new Map(topics.map((topic) => [topic, []]));
  return new Promise((done, failed) => {
    const late = setTimeout(() => failed(new Error(`too few messages by ${name}`)), kPatience);
    client.on("error", failed);
    client.on("advertise", (offered) => {
      for (const { id, topic, schema, encoding, schemaEncoding } of offered) {
        if (!messages.has(topic)) continue;
        assert.equal(encoding, "cdr");
        assert.equal(schemaEncoding, "ros2msg");
        const definition = rosmsg.parse(schema, { ros2: true });
        const reader = new serialization.MessageReader(definition);
        channels.set(client.subscribe(id), { topic, reader });
      }
    });
    client.on("message", ({ subscriptionId, data, timestamp }) => {
      const { topic, reader } = channels.get(subscriptionId);
      messages.get(topic).push({ timestamp, record: reader.readMessage(data) });
      const have = messages.get("/servo0/frame").length >= kEnough;
      if (!have || ![...messages.values()].every((list) => list.length > 0)) return;
      clearTimeout(late);
      assert.equal(socket.protocol, name);
      client.close();
      done(messages);
    });
  });
}

/** A decoded field by the name of its column, which may end with a unit. */
function field_of(record, column) {
  for (let path = column; path; path = path.slice(0, Math.max(path.lastIndexOf("_"), 0))) {
    const names = path.toLowerCase().split(/[.[\]]+/).filter(Boolean);
    const value = names.reduce((part, name) => part?.[name], record);
    if (value !== undefined) return value;
  }
  return assert.fail(`column ${column} is no field`);
}

function rows_of(recording, topic) {
  const words = ["export", recording, "--topic", topic];
  const run = spawnSync(join(bin, "hapt"), words, { encoding: "utf8", maxBuffer: 1 << 30 });
  assert.equal(run.status, 0, run.stderr);
  const [head, ...rows] = run.stdout.trimEnd().split("\n");
  return { columns: head.split(","), rows: rows.map((row) => row.split(",")) };
}

for (const name of ["foxglove.websocket.v1", "foxglove.sdk.v1"]) {
  test(`the public client gets by ${name} the numbers of the rings`, { skip: lack }, async () => {
    const recording = join(folder, `${name}.mcap`);
    const recorder = start("hapt", ["record", "-o", recording, "--session", "foxglove"]);
    await eventually(() => recorder.said.includes("recording to"), "the recorder starts");
    const size = () => (existsSync(recording) ? statSync(recording).size : 0);
    const grown = async () => {
      const before = size();
      await eventually(() => size() > before + 100_000, "the recording grows");
    };
    await grown();
    const messages = await listen(name);
    await grown();
    await ended(recorder, "SIGINT");
    let numbers = 0;
    for (const [topic, key] of [["/servo0/frame", "tick"], ["/sim/frame", "seq"]]) {
      const { columns, rows } = rows_of(recording, topic);
      const at = columns.indexOf(key);
      const by_key = new Map(rows.map((row) => [row[at], row]));
      let compared = 0;
      for (const { record } of messages.get(topic)) {
        const row = by_key.get(String(record[key]));
        if (!row) continue; // before or after the recording
        ++compared;
        columns.forEach((column, i) => {
          if (row[i] === "") return;
          const value = field_of(record, column);
          const wanted = row[i].replace(/inf$/, "Infinity");
          const parsed = typeof value === "bigint" ? BigInt(wanted) : Number(wanted);
          assert.ok(Object.is(parsed, value), `${topic} ${column}: ${value}, recorded ${wanted}`);
          ++numbers;
        });
      }
      assert.ok(compared > 0, `${topic}: nothing to compare`);
    }
    console.log(`${name}: ${numbers} numbers agree`);
  });
}
