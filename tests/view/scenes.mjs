// SPDX-License-Identifier: GPL-3.0-or-later
// The pictures of docs/pictures from real sessions: node scenes.mjs BIN VIEW OUT [NAME…]
// Each scene is played in a session and recorded, and the page shows the recording at a firm touch:
// so a picture has all its plots however slowly this machine draws. OUT/NAME.mcap is used where it exists.
// Needs chromium and Debian's package `webp`. HAPTICD_MESHES: where the meshes are (`./run meshes`).
import { execFileSync } from "node:child_process";
import { existsSync, mkdirSync, rmSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { launch } from "./browser.mjs";
import { kPatience, open_log, record, Sessions } from "./live.mjs";

const [bin, view, out, ...wanted] = process.argv.slice(2);
const kSize = { width: 1120, height: 900 };
const kShare = 0.6; // of the greatest force allowed, that the picture shows at most

/** picture | what `hapt demo` is told | how the camera is moved from its first view; `face`: the side
 *  that is touched is turned to the viewer */
const kScenes = [
  ["bunny", ["bunny"], { nearer: 1.1, face: true }],
  ["peg", ["peg"], { nearer: 1.15, turn: [0, 0.1] }],
  ["gears", ["gears"], { nearer: 1.3, turn: [0.4, -0.1], shell: true }],
  ["teeth", ["teeth"], { nearer: 1.15 }],
  ["ball-joint", ["ball-joint"], { nearer: 1.1 }],
  ["dimpled-ball", ["dimpled-ball"], { nearer: 1.1, face: true }],
  ["bunnies", ["bunnies"], { nearer: 0.85, face: true }],
  ["rigid-peg", ["rigid-peg"], { nearer: 1.1, turn: [0, 0.1] }],
  ["frame", ["frame"], { nearer: 1.5, turn: [0.2, 0.1] }],
  ["heap", ["heap"], { nearer: 1.1 }],
  ["carry", ["carry"], { nearer: 1.1 }],
  ["door", ["door"], { nearer: 1.1 }],
  ["gear-pair", ["gear-pair"], { nearer: 1.2, turn: [0.4, -0.1] }],
  ["gearshift", ["gearshift"], { nearer: 1.1 }],
  ["admittance", ["admittance"], { nearer: 1.1, face: true }],
  ["rigid-bunnies", ["rigid-bunnies"], { nearer: 0.75, face: true }],
  ["plane", ["--config", "plane.toml"], { face: true }],
  ["penalty-artefacts", ["--config", "penalty-artefacts.toml"], { face: true }],
];

/** Goes to the firmest touch of the recording that lasts and is not at the limit of the force; where
 *  all are short, to the firmest of them. */
async function go_to_touch(page) {
  await page.waitForFunction(() => window.hapticd.plots.tables?.[0]?.[0].length > 100);
  const [time, force] = await page.evaluate((share) => {
    const { plots, state } = window.hapticd;
    const [times, , , , forces] = plots.tables[0];
    const most = share * state.scene.limits.max_force;
    // two points for each step of the plot, its least value and then its greatest
    const firmest = (odd) =>
      forces.reduce((at, f, i) => (i % 2 === odd && f <= most && !(f <= forces[at]) ? i : at), -1);
    const lasting = firmest(0);
    const best = forces[lasting] > 0.3 ? lasting : firmest(1) - 1;
    plots.on_pick(times[best]);
    return [times[best], Math.max(forces[best], forces[best + 1])];
  }, kShare);
  await page.waitForFunction((t) => Math.abs(window.hapticd.latest.time - t) < 0.02, time);
  for (let ticks = 0; ticks < 60; ticks += 1) {
    const { tick, felt } = await page.evaluate(() => {
      const { tick: now, force: f } = window.hapticd.latest;
      return { tick: now, felt: Math.hypot(...f) };
    });
    if (felt > 0.7 * force) return;
    await page.click("#step-on");
    await page.waitForFunction((was) => window.hapticd.latest.tick > was, tick);
  }
}

function look(page, camera) {
  return page.evaluate(({ face, shell, ...moves }) => {
    const { stage, latest } = window.hapticd;
    stage.view("start");
    const [x, , z] = latest.force;
    if (face && Math.hypot(x, z) > 0.1) {
      const oblique = 0.9; // [rad] between the force and the direction to the viewer
      const { position } = stage.camera;
      const now = Math.atan2(position.x - stage.orbit.target.x, position.z - stage.orbit.target.z);
      const apart = (angle) => Math.atan2(Math.sin(now - angle), Math.cos(now - angle));
      const turns = [oblique, -oblique].map((angle) => apart(Math.atan2(x, z) + angle));
      const [nearest] = turns.sort((a, b) => Math.abs(a) - Math.abs(b));
      stage.move({ turn: [nearest, 0] });
    }
    stage.move(moves);
    if (shell) document.querySelector("#shell").click();
  }, camera);
}

/** When the numbers, the plots and the picture are those of the tick. */
const settled = (page) =>
  page.evaluate(
    () =>
      new Promise((done) => {
        const { stage } = window.hapticd;
        const wait = (left) =>
          requestAnimationFrame(() => (stage.dirty || left > 0 ? wait(left - 1) : done()));
        setTimeout(() => wait(3), 1500); // a slow picture is drawn late, and texts every 0.1 s
      }),
  );

function to_webp(png, path) {
  writeFileSync(`${path}.png`, png);
  execFileSync("cwebp", ["-quiet", "-q", "82", `${path}.png`, "-o", `${path}.webp`]);
  rmSync(`${path}.png`);
}

async function take(browser, name, options, camera) {
  const sessions = new Sessions(resolve(bin));
  const log = resolve(out, `${name}.mcap`);
  try {
    if (!existsSync(log)) await record(sessions, log, ...options);
    const page = await open_log(browser, sessions, log, resolve(view), { viewport: kSize });
    page.on("pageerror", (error) => console.log(name, error.stack));
    await go_to_touch(page);
    await look(page, camera);
    await settled(page);
    to_webp(await page.screenshot({ timeout: kPatience }), join(out, name));
    await page.close();
  } finally {
    await sessions.close();
  }
}

mkdirSync(out, { recursive: true });
const browser = await launch();
try {
  for (const [name, ...scene] of kScenes) {
    if (wanted.length > 0 && !wanted.includes(name)) continue;
    await take(browser, name, ...scene).then(
      () => console.log(name),
      (error) => {
        console.log(`${name}: ${error.message}`);
        process.exitCode = 1;
      },
    );
  }
} finally {
  await browser.close();
}
