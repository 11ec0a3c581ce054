// SPDX-License-Identifier: GPL-3.0-or-later
// The pictures of docs/pictures from real sessions: node scenes.mjs BIN VIEW OUT [NAME…]
// Needs Debian's `webp` (cwebp, img2webp) and chromium; "clip" is the moving picture of the bunny.
// HAPTICD_MESHES: where the meshes of bunny and teeth are.
import { execFileSync } from "node:child_process";
import { mkdirSync, rmSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";
import { eventually, pause, Sessions } from "./live.mjs";

const [bin, view, out, ...wanted] = process.argv.slice(2);
const kSize = { width: 1120, height: 680 };
const kSession = "scene"; // the same for all, so that one page sees them one after the other

/** picture | what `hapt demo` is told | how the camera is moved from its first view */
const kScenes = [
  ["bunny", ["bunny"], { nearer: 1.05 }],
  ["peg", ["peg"], { nearer: 1.2, turn: [0, 0.1] }],
  ["gears", ["gears"], { nearer: 1.1, turn: [-0.4, -0.2] }],
  ["teeth", ["teeth"], { nearer: 1.15 }],
  ["bunnies", ["bunnies"], { nearer: 1.1 }],
  ["rigid-peg", ["rigid-peg"], { nearer: 1.2, turn: [0.3, 0.1] }],
  ["rigid-bunnies", ["rigid-bunnies"], { nearer: 1.1 }],
  ["plane", ["--config", "plane.toml"], {}],
  ["penalty-artefacts", ["--config", "penalty-artefacts.toml"], {}],
  ["clip", ["bunny"], { nearer: 1.05 }],
];
const kShells = ["gears"]; // shown with their voxel points

const kClip = { seconds: 4, rate: 10, width: 480, height: 270 };

/** The newest frame has a contact that is felt, is on the picture, and no banner is in the way. */
const is_pressing = () =>
  document.querySelector("#banner").hidden &&
  window.hapticd.latest.n_pushing > 0 &&
  Math.hypot(...window.hapticd.latest.force) > 0.5;

async function show(page, camera, shell) {
  await page.evaluate(
    ([moves, points]) => {
      const { stage } = window.hapticd;
      stage.view("start");
      stage.move(moves);
      const box = document.querySelector("#shell");
      if (box.checked !== points && !box.disabled) box.click();
    },
    [camera, shell],
  );
}

/** Draws no picture until it is wanted: where OpenGL is software, that takes all the time there is. */
const hold = (page, on) =>
  page.evaluate((held) => {
    const { stage } = window.hapticd;
    if (held) stage.draw = () => false;
    else delete stage.draw;
    stage.dirty = true;
  }, on);

function to_webp(png, path) {
  writeFileSync(`${path}.png`, png);
  execFileSync("cwebp", ["-quiet", "-q", "82", `${path}.png`, "-o", `${path}.webp`]);
  rmSync(`${path}.png`);
}

/** Frames as they came, drawn again at even steps of the session's time: so the clip runs at the
 *  speed of the hand however slowly this machine draws. */
async function clip(page, path) {
  await hold(page, true);
  await page.evaluate(() => window.hapticd.kept.splice(0));
  await eventually(
    () =>
      page.evaluate(
        (seconds) => window.hapticd.kept.at(-1)?.time > window.hapticd.kept[0]?.time + seconds,
        kClip.seconds,
      ),
    "the frames of the clip",
  );
  const pictures = await page.evaluate(async ({ seconds, rate, width, height }) => {
    const { stage, kept } = window.hapticd;
    const frames = [...kept];
    delete stage.draw;
    stage.renderer.setPixelRatio(width / stage.canvas.clientWidth);
    const list = [];
    const small = new OffscreenCanvas(width, height);
    const pen = small.getContext("2d");
    for (let i = 0; i < seconds * rate; i += 1) {
      const time = frames[0].time + i / rate;
      stage.show(frames.findLast((frame) => frame.time <= time), null);
      stage.draw();
      const { width: w, height: h } = stage.canvas;
      const scale = Math.max(width / w, height / h);
      pen.drawImage(stage.canvas, (width - w * scale) / 2, (height - h * scale) / 2, w * scale, h * scale);
      const bytes = new Uint8Array(await (await small.convertToBlob({ type: "image/png" })).arrayBuffer());
      list.push(Array.from(bytes, (byte) => String.fromCharCode(byte)).join(""));
    }
    return list;
  }, kClip);
  const files = pictures.map((bytes, i) => {
    const file = `${path}-${String(i).padStart(3, "0")}.png`;
    writeFileSync(file, Buffer.from(bytes, "latin1"));
    return file;
  });
  const step = String(Math.round(1000 / kClip.rate)); // [ms]
  execFileSync("img2webp", [
    "-loop",
    "0",
    ...files.flatMap((file) => ["-d", step, "-lossy", "-q", "70", file]),
    "-o",
    `${path}.webp`,
  ]);
  files.forEach((file) => rmSync(file));
}

mkdirSync(out, { recursive: true });
const sessions = new Sessions(resolve(bin));
const browser = await launch();
try {
  let page = null;
  for (const [name, options, camera] of kScenes) {
    if (wanted.length > 0 && !wanted.includes(name)) continue;
    const demo = sessions.start("hapt", "demo", ...options, "--session", kSession, "--for", "600s");
    demo.stderr.resume();
    try {
      await eventually(() => sessions.run("hapt", "status", "--session", kSession).catch(() => ""));
      if (page === null) {
        const address = await sessions.bridge(kSession, resolve(view));
        page = await browser.newPage({ viewport: kSize, colorScheme: "light" });
        page.setDefaultTimeout(240000);
        page.on("pageerror", (error) => console.log(name, error.stack));
        const quality = process.env.QUALITY ? `&quality=${process.env.QUALITY}` : "";
        const url = address.replace("#", `?keep=1000${quality}#`);
        await page.goto(url, { waitUntil: "commit", timeout: 240000 });
        await page.waitForFunction(() => window.hapticd?.drawn);
        await hold(page, true);
      }
      await page.waitForFunction(
        (servo) => window.hapticd.state.status?.processes.some(({ pid }) => pid === servo),
        JSON.parse(await sessions.run("hapt", "status", "--json")).processes.find(
          ({ name: process }) => process.startsWith("servo"),
        ).pid,
      );
      await show(page, camera, kShells.includes(name));
      await pause(2000); // of plots
      await page.waitForFunction(is_pressing);
      await hold(page, false);
      await page.evaluate(
        () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done))),
      );
      if (name === "clip") await clip(page, join(out, name));
      else to_webp(await page.screenshot({ timeout: 240000 }), join(out, name));
      console.log(name, new Date().toTimeString().slice(0, 8));
    } catch (error) {
      console.log(`${name}: ${error.message}`);
    }
    if (page !== null) await hold(page, true);
    await sessions.end(demo, "SIGINT");
  }
} finally {
  await browser.close();
  await sessions.close();
}
