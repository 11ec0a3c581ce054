// SPDX-License-Identifier: GPL-3.0-or-later
// Reads a recording with the public MCAP reader, by its index and as a stream, decodes every message
// with the public ROS 2 decoder and compares it with our CSV export, bit for bit.
// Run: node mcap_reader.mjs <test_proto> <work folder>; says SKIPPED where npm has no network.
import { spawnSync } from "node:child_process";
import { closeSync, existsSync, fstatSync, mkdirSync, openSync, readFileSync, readSync } from "node:fs";
import { createRequire } from "node:module";
import { join } from "node:path";

const packages = [
  "@mcap/core@2.2.2",
  "@mcap/support@1.1.0",
  "@foxglove/rosmsg@5.0.5",
  "@foxglove/rosmsg2-serialization@3.1.0",
];

function fail(what) {
  console.error(`FAILED: ${what}`);
  process.exit(1);
}

function expect(actual, expected, what) {
  if (!Object.is(actual, expected)) fail(`${what}: ${actual}, expected ${expected}`);
}

/** Installs the readers into the work folder, once. */
function installPackages(folder) {
  if (existsSync(join(folder, "node_modules", "@mcap", "core"))) return;
  const npm = spawnSync("npm", ["install", "--no-audit", "--no-fund", "--prefix", folder, ...packages], {
    encoding: "utf8",
  });
  if (npm.status === 0) return;
  console.log(`SKIPPED: npm could not install the public MCAP reader:\n${npm.stderr ?? npm.error}`);
  process.exit(0);
}

/** Has the test program write one recording and the CSV of each of its topics. */
function makeSample(program, folder) {
  const made = spawnSync(program, ["trace: a sample for other programs*"], {
    env: { ...process.env, HAPTIC_SAMPLE_FOLDER: folder },
    encoding: "utf8",
  });
  if (made.status !== 0) fail(`${program}: ${made.stdout}${made.stderr}`);
}

/** A decoded field by its path; ROS 2 names are in lower case, our columns are not. */
function fieldOf(message, path) {
  return path.toLowerCase().split(/[.[\]]+/).filter(Boolean).reduce((value, key) => value?.[key], message);
}

/** Columns whose name, with or without its unit suffix, is a field; every column must be one. */
function fieldPath(message, column) {
  // n_LIST is how many values the list has
  const list = column.startsWith("n_") ? message[column.slice(2).toLowerCase()] : undefined;
  if (list?.length !== undefined) return `${column.slice(2)}.length`;
  for (let path = column; path.length > 0; path = path.slice(0, Math.max(path.lastIndexOf("_"), 0))) {
    if (fieldOf(message, path) !== undefined) return path;
  }
  return undefined;
}

/** Lists are as long as each message says: the path in the first one that has it. */
function pathIn(messages, column) {
  for (const message of messages) {
    const path = fieldPath(message, column);
    if (path !== undefined) return path;
  }
  return fail(`column ${column} is no field of a message`);
}

function readCsv(file) {
  const [head, ...rows] = readFileSync(file, "utf8").trimEnd().split("\n");
  return { columns: head.split(","), rows: rows.map((row) => row.split(",")) };
}

/** Every cell against the decoded message; integers of 64 bits as BigInt. */
function compare(topic, messages, csv) {
  expect(messages.length, csv.rows.length, `${topic}: messages`);
  const paths = csv.columns.map((column) => pathIn(messages, column));
  messages.forEach((message, row) => {
    paths.forEach((path, i) => {
      const cell = csv.rows[row][i];
      if (cell === "") return;
      const value = fieldOf(message, path);
      const parsed = typeof value === "bigint" ? BigInt(cell) : Number(cell.replace(/^-?inf$/, "Infinity"));
      expect(parsed, value, `${topic}: row ${row}, ${csv.columns[i]}`);
    });
  });
  return paths.length * messages.length;
}

const [program, folder] = process.argv.slice(2);
mkdirSync(folder, { recursive: true });
installPackages(folder);
makeSample(program, folder);

const require = createRequire(join(folder, "package.json"));
const { McapIndexedReader, McapStreamReader } = require("@mcap/core");
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const decompressHandlers = await loadDecompressHandlers();
const path = join(folder, "sample.mcap");

// as a stream, CRCs checked
const streamed = new Map();
const channels = new Map();
const schemas = new Map();
const stream = new McapStreamReader({ decompressHandlers, validateCrcs: true });
stream.append(readFileSync(path));
for (let record; (record = stream.nextRecord()) !== undefined; ) {
  if (record.type === "Schema") schemas.set(record.id, record);
  if (record.type === "Channel") channels.set(record.id, record);
  if (record.type !== "Message") continue;
  const channel = channels.get(record.channelId);
  const schema = schemas.get(channel.schemaId);
  schema.reader ??= new MessageReader(parse(new TextDecoder().decode(schema.data), { ros2: true }));
  const list = streamed.get(channel.topic) ?? [];
  list.push(schema.reader.readMessage(record.data));
  streamed.set(channel.topic, list);
}
if (!stream.done()) fail("the stream reader wants more bytes");

// by the index
const file = openSync(path, "r");
const readable = {
  size: async () => BigInt(fstatSync(file).size),
  read: async (offset, length) => {
    const bytes = new Uint8Array(Number(length));
    readSync(file, bytes, 0, bytes.length, Number(offset));
    return bytes;
  },
};
const indexed = await McapIndexedReader.Initialize({ readable, decompressHandlers });
const counts = new Map();
let last = 0n;
for await (const message of indexed.readMessages()) {
  if (message.logTime < last) fail("the indexed reader gives messages out of order");
  last = message.logTime;
  const { topic } = indexed.channelsById.get(message.channelId);
  counts.set(topic, (counts.get(topic) ?? 0) + 1);
}
const metadata = [];
for await (const record of indexed.readMetadata()) metadata.push(record);
closeSync(file);

expect(metadata.length, 1, "metadata records");
expect(metadata[0].metadata.get("session"), "sample", "name in the metadata");
expect(streamed.size, 5, "topics");
if (indexed.chunkIndexes.length < 2) fail("the sample should have several chunks");

let cells = 0;
let total = 0;
for (const [topic, messages] of streamed) {
  expect(counts.get(topic), messages.length, `${topic}: messages by the index`);
  cells += compare(topic, messages, readCsv(join(folder, topic.replaceAll("/", "_") + ".csv")));
  total += messages.length;
}
expect(indexed.statistics.messageCount, BigInt(total), "messages in the statistics");
console.log(`${total} messages, ${indexed.chunkIndexes.length} chunks, ${cells} numbers agree`);
