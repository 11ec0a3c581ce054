// SPDX-License-Identifier: GPL-3.0-or-later
// The moving picture at the top of README from a real session: node clip.mjs BIN VIEW OUT.webp [LOG]
// Records `hapt demo bunny` (or takes LOG), opens the recording and takes a picture every few ticks, so that the clip
// runs at the speed of the hand however slowly this machine draws.
// Needs chromium and Debian's package `webp` (img2webp). HAPTICD_MESHES: where the bunny is.
import { execFileSync } from "node:child_process";
import { statSync, writeFileSync } from "node:fs";
import { resolve } from "node:path";
import { launch } from "./browser.mjs";
import { kPatience, open_log, record, Sessions } from "./live.mjs";

const [bin, view, out, recording] = process.argv.slice(2);
const kSize = { width: 720, height: 500 };
const kSeconds = 7;
const kRate = 12; // pictures a second
const kPlotted = 3; // [s] that the plots show
const kCamera = { nearer: 1.2, shift: [0, 0] };
const kMostBytes = 2e6;

/** Picture and two plots, without what a clip cannot operate. */
const kStyle = `
  header, .tools, .player, aside, .picture > .reason, #stage-help { display: none !important; }
  main { grid-template: "picture" minmax(0, 1fr) "curves" auto / minmax(0, 1fr) !important; }
  body { height: 100vh; }
  .stage-frame { flex: 1 !important; height: auto !important; min-height: 0 !important; }
  #plots { padding-top: 6px; grid-template-columns: 1fr 1fr !important; }
  .plot:not(:nth-child(1), :nth-child(3)) { display: none; }
  .plot-body { height: 6.5rem !important; }`;

/** Where to begin: the window of the recording in which most is touched, [s] of its clock. */
function busiest(seconds, before) {
  const [table] = window.hapticd.plots.tables;
  const [times] = table;
  const depth = table[9];
  const is_touched = (from) =>
    times.filter((t, i) => t >= from && t < from + seconds && depth[i] > 5e-4).length;
  const starts = times.filter((t) => t > times[0] + before && t + seconds < times.at(-1));
  const best = Math.max(...starts.map(is_touched));
  return starts.find((start) => is_touched(start) === best);
}

/** Shows the recording at a time, with the plots up to it. */
async function show(page, time) {
  await page.evaluate((wanted) => window.hapticd.plots.on_pick(wanted), time);
  await page.waitForFunction((t) => Math.abs(window.hapticd.latest.time - t) < 0.02, time);
  await page.evaluate(
    ([now, plotted]) => {
      const { plots, whole } = window.hapticd;
      const count = whole[0].filter((t) => t <= now).length;
      plots.tables = [whole.map((column) => column.slice(0, count))];
      plots.range = [now - plotted, now];
      plots.set_now(now);
      plots.draw();
      return new Promise((done) => {
        requestAnimationFrame(() => requestAnimationFrame(done));
      });
    },
    [time, kPlotted],
  );
}

async function pictures(page, sessions) {
  await page.addStyleTag({ content: kStyle });
  await page.waitForFunction(() => window.hapticd.plots.tables?.[0]?.[0].length > 100);
  const start = await page.evaluate(`(${busiest})(${kSeconds}, ${kPlotted})`);
  await page.evaluate(
    ([camera, from, to]) => {
      const { stage, plots } = window.hapticd;
      stage.view("start");
      stage.move(camera);
      plots.tables = null;
      plots.zoom(from, to);
    },
    [kCamera, start - kPlotted, start + kSeconds],
  );
  await page.waitForFunction(() => (window.hapticd.whole = window.hapticd.plots.tables?.[0]));
  const files = [];
  for (let i = 0; i < kSeconds * kRate; i += 1) {
    await show(page, start + i / kRate);
    const file = sessions.file(`${String(i).padStart(3, "0")}.png`);
    writeFileSync(file, await page.screenshot({ timeout: kPatience }));
    files.push(file);
  }
  return files;
}

const sessions = new Sessions(resolve(bin));
const browser = await launch();
try {
  const log = resolve(recording ?? sessions.file("bunny.mcap"));
  if (!recording) await record(sessions, log, "bunny");
  const page = await open_log(browser, sessions, log, resolve(view), {
    viewport: kSize,
    bypassCSP: true, // for kStyle
  });
  const files = await pictures(page, sessions);
  const step = String(Math.round(1000 / kRate)); // [ms]
  const each = files.flatMap((file) => ["-d", step, "-lossy", "-q", "60", "-m", "6", file]);
  execFileSync("img2webp", ["-loop", "0", "-kmax", "24", ...each, "-o", out]);
  const { size } = statSync(out);
  console.log(`${out}: ${files.length} pictures, ${size} bytes`);
  if (size > kMostBytes) throw new Error(`${size} bytes are too many for the top of a page`);
} finally {
  await browser.close();
  await sessions.close();
}
