// SPDX-License-Identifier: GPL-3.0-or-later
// The built page in Chromium against the mock bridge. VIEW names the folder of the page.
import assert from "node:assert/strict";
import { existsSync } from "node:fs";
import { join } from "node:path";
import { after, afterEach, before, describe, test } from "node:test";
import { has_chromium, launch } from "./browser.mjs";
import { kToken, Mock } from "./mock.mjs";
import { kTightest } from "./mock_recording.mjs";
import { nameless, overflow } from "./page_checks.mjs";

const view = process.env.VIEW ?? "../../build/dev/view";
const lack = !has_chromium
  ? "no chromium (CHROMIUM names another)"
  : !existsSync(join(view, "app.js"))
    ? `no page in ${view}: build the target view_page, or set VIEW`
    : false;

const kPatience = 30000; // [ms]; a busy machine draws a picture in a second
let browser;
let mock;
let page;
let complaints;

/** Opens the page on a fresh mock and waits for its first pictures. */
async function open({
  size = [1280, 720],
  token = true,
  colours = "dark",
  motion = "no-preference",
  ...options
} = {}) {
  mock = new Mock({ view, ...options });
  const url = await mock.listen();
  page = await browser.newPage({
    viewport: { width: size[0], height: size[1] },
    colorScheme: colours,
    reducedMotion: motion,
  });
  complaints = [];
  page.on("pageerror", (error) => complaints.push(String(error)));
  page.on("console", (message) => {
    if (message.type() === "error") complaints.push(message.text());
  });
  page.on("request", (request) => {
    if (!request.url().startsWith(url)) complaints.push(`asks ${request.url()}`);
  });
  await page.goto(`${url}?quality=low${token ? `#token=${kToken}` : ""}`);
  await page.waitForFunction(() => window.hapticd?.ready && window.hapticd.stats.frames_drawn > 0);
  return url;
}

const until = (condition, argument) =>
  page.waitForFunction(condition, argument, { timeout: kPatience });
const text = (selector) => page.textContent(selector);
const sent = (type) => mock.received.filter((message) => message.type === type);
const sent_lines = () => sent("command").map(({ line }) => line);

/** Waits in node until `condition` holds. */
async function eventually(condition) {
  const end = Date.now() + kPatience;
  while (!condition()) {
    assert.ok(Date.now() < end, `waited in vain for ${condition}`);
    await new Promise((done) => {
      setTimeout(done, 20);
    });
  }
}

describe("the page", { skip: lack }, () => {
  before(async () => {
    browser = await launch();
  });
  after(() => browser?.close());
  afterEach(async () => {
    await page?.close();
    await mock?.close();
    assert.deepEqual(complaints, []);
  });

  test("loads under its policy, moves, and plots every sample", async () => {
    const url = await open();
    assert.equal(page.url(), `${url}?quality=low`, "the token has left the address");
    const count = () =>
      page.evaluate(() => {
        const {
          stats,
          frames: [{ tick }],
        } = window.hapticd;
        return { tick, counted: stats.samples + stats.missing, samples: stats.samples };
      });
    const first = await count();
    await until((tick) => window.hapticd.latest.tick > tick + 1000, first.tick);
    const last = await count();
    assert.equal(
      last.counted - first.counted,
      last.tick - first.tick,
      "each tick is there or told to be missing",
    );
    const { gaps, same, plots } = await page.evaluate(() => ({
      gaps: window.hapticd.stats.sequence_gaps,
      same: window.hapticd.latest.tool[0] === window.hapticd.stage.models[0].hand.position.x,
      plots: window.hapticd.plots.plots.map(({ uplot }) => uplot.data[0].length),
    }));
    assert.equal(gaps, 0);
    assert.ok(same, "the picture has the pose of the newest frame");
    assert.equal(plots.length, 5);
    await until(() => window.hapticd.plots.plots.every(({ uplot }) => uplot.data[0].length > 200));
    assert.ok(last.samples > first.samples);
    assert.match(await text('[data-reading="force"] td'), /N$/);
    assert.equal(await page.locator("#processes tr").count(), 4);
    assert.ok(sent("shown").length > 0);
  });

  for (const [trouble, words] of [
    ["servo", /servo's data/],
    ["contact", /contacts are/],
    ["silent", /silent/],
    ["gone", /hapticd has ended/],
  ]) {
    test(`says when what it shows is old (${trouble}), and when all is well again`, async () => {
      await open();
      assert.ok(await page.isHidden("#banner"));
      mock.set_trouble(trouble);
      await until((source) => {
        const banner = document.querySelector("#banner.bad");
        return banner && new RegExp(source).test(banner.textContent);
      }, words.source);
      await until(
        (source) => new RegExp(source).test(document.querySelector("#announcements").textContent),
        words.source,
      );
      mock.set_trouble(null);
      // the banner goes after some seconds, so the list of events is asked
      await until(() => /All is well again after/.test(document.querySelector("#events").textContent));
      await until(() => !document.querySelector("#banner.bad:not([hidden])"));
    });
  }

  test("without WebGL all but the picture works", async () => {
    const usual = browser;
    browser = await launch(["--disable-3d-apis"]);
    try {
      await open();
      assert.ok(await page.isVisible("#no-picture"));
      await until(() => window.hapticd.plots.plots[0].uplot.data[0].length > 100);
      await page.click("#pause");
      await eventually(() => mock.paused);
      await page.close();
    } finally {
      await browser.close();
      browser = usual;
    }
    complaints = complaints.filter((text) => !/WebGL/.test(text));
  });

  test("comes back by itself when the bridge has been away, with its token", async () => {
    await open();
    mock.drop_sockets();
    await until(() => window.hapticd.stats.reconnects === 1 && window.hapticd.state.connected);
    await until(() => window.hapticd.state.control?.allowed);
    assert.equal(sent("token").length, 2);
  });

  test("without the token nothing can be operated, and it says why", async () => {
    await open({ token: false });
    for (const id of ["renderer", "pause", "stiffness", "touch"])
      assert.ok(await page.isDisabled(`#${id}`), id);
    assert.match(await text("#control-reason"), /token/);
    assert.match(await text("#touch-reason"), /token/);
    assert.deepEqual(sent("command"), []);
  });

  test("controls send what the control socket takes and show its answers", async () => {
    await open();
    await until(() => !document.querySelector("#control-set").disabled);
    await page.click("#pause");
    await until(() => document.querySelector("#pause").textContent === "Resume");
    assert.match(await text("#answer"), /pause: done/);
    assert.ok(await page.isDisabled("#solver"));
    assert.match(await text("#solver-reason"), /god-object3 has no solver.*voxel/);
    await page.fill("#stiffness", "750");
    await page.waitForTimeout(300);
    await page.click("#stiffness-form button");
    await page.selectOption("#renderer", "virtual-proxy3");
    assert.ok(
      !sent_lines().some((line) => line.startsWith("set renderer")),
      "choosing sets nothing yet",
    );
    await page.click("#renderer-form button");
    await eventually(() => sent_lines().includes("set renderer virtual-proxy3"));
    assert.ok(sent_lines().includes("set stiffness 750 N/m"));
    await until(
      () => window.hapticd.latest.renderer === 2 && window.hapticd.latest.stiffness === 750,
    );
    await until(() => document.querySelector("#solver-reason").hidden);
    await page.selectOption("#solver", "quasi-static");
    await page.press("#solver", "Tab");
    await page.keyboard.press("Enter");
    await until(() => document.querySelector("#answer").dataset.ok === "false");
    assert.match(await text("#answer"), /cannot set 'solver'/);
    await until(() => document.querySelector("#solver").value === "direct");
    assert.ok(await page.isDisabled('#renderer option[value="voxel"]'));
    assert.match(await text('#renderer option[value="voxel"]'), /needs a \[tool\]/);
  });

  test("a fault is told in words with what to do, and can be cleared", async () => {
    await open();
    mock.fault = 5;
    await page.waitForSelector("#trouble-section:not([hidden])");
    assert.match(await text("#troubles"), /pose of the device jumped.*clear the fault/);
    mock.faults = [{ text: "The hand jumped.", remedy: "Look at the cable." }];
    await until(() => /Look at the cable/.test(document.querySelector("#troubles").textContent));
    mock.faults = [];
    await page.click("#clear-fault");
    await page.waitForSelector("#trouble-section", { state: "hidden" });
    assert.deepEqual(sent_lines(), ["clear-fault"]);
  });

  test("the hand is led by mouse while the button is down, and let go", async () => {
    await open();
    await page.click("#touch");
    const box = await page.locator("#stage").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await page.mouse.move(x + 60, y - 40, { steps: 5 });
    await eventually(() => sent("lead").length > 3);
    assert.ok(await page.evaluate(() => window.hapticd.stage.models[0].intent.visible));
    await page.mouse.up();
    await eventually(() => sent("release").length === 1);
    const count = sent("lead").length;
    const positions = sent("lead").map(({ position }) => position);
    assert.ok(
      positions.every((position) => position.length === 3 && position.every(Number.isFinite)),
    );
    await page.waitForTimeout(200);
    assert.equal(sent("lead").length, count, "nothing is led after the release");
  });

  test("with Shift the drag turns the tool and leaves its place", async () => {
    await open();
    await page.click("#touch");
    const box = await page.locator("#stage").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await eventually(() => sent("lead").length > 1);
    const [first] = sent("lead");
    await page.keyboard.down("Shift");
    await page.mouse.move(x + 50, y, { steps: 5 });
    const newest = () => sent("lead").at(-1);
    const angle = () => {
      const parts = newest().orientation.map((part, i) => part * first.orientation[i]);
      return 2 * Math.acos(Math.min(1, Math.abs(parts.reduce((sum, part) => sum + part))));
    };
    await eventually(() => Math.abs(angle() - 50 * 0.008) < 1e-6);
    assert.deepEqual(newest().position, first.position);
    assert.ok(Math.abs(Math.hypot(...newest().orientation) - 1) < 1e-12);
    // about the picture's upward direction
    const up = await page.evaluate(() => window.hapticd.stage.plane().up.toArray());
    const [w, ...vector] = first.orientation;
    const [w2, ...vector2] = newest().orientation;
    const cross = (a, b) =>
      [1, 2, 0].map((i, k) => a[i] * b[(k + 2) % 3] - a[(k + 2) % 3] * b[i]);
    const turn = vector2.map((part, i) => w * part - w2 * vector[i] - cross(vector2, vector)[i]);
    const along = turn.reduce((sum, part, i) => sum + part * up[i], 0);
    assert.ok(Math.abs(along - Math.sin(0.2)) < 1e-6, "to the right about up");
    await page.keyboard.up("Shift");
    await page.mouse.up();
    await eventually(() => sent("release").length === 1);
  });

  test("a ball of nine millimetres is shaded round, not by the centimetre", async () => {
    await open();
    const least = await page.evaluate(() => {
      const [{ geometry }] = window.hapticd.stage.models[0].objects[1].children;
      const { position, normal } = geometry.attributes;
      let worst = 1;
      for (let i = 0; i < position.count; i += 1) {
        const p = [position.getX(i), position.getY(i), position.getZ(i)];
        if (normal.getX(i) === 0 && normal.getY(i) === 0 && normal.getZ(i) === 0) continue; // at a pole
        const along = p[0] * normal.getX(i) + p[1] * normal.getY(i) + p[2] * normal.getZ(i);
        worst = Math.min(worst, along / Math.hypot(...p));
      }
      return worst;
    });
    assert.ok(least > 0.99, `${least}: cosine between a normal and its radius`); // 16 rings of facets
  });

  test("convex pieces are fetched where they are first shown, and stand for the mesh", async () => {
    const asked = [];
    const url = await open({ pieces: true });
    page.on("request", (request) => asked.push(request.url()));
    const shown = () =>
      page.evaluate(() =>
        window.hapticd.stage.models[0].objects.map((group) =>
          group.children
            .filter(({ isMesh, visible }) => isMesh && visible)
            .map(({ name, geometry }) => {
              const { array } = geometry.attributes.color ?? { array: [] };
              const colours = new Set();
              for (let i = 0; i < array.length; i += 3) colours.add(array.slice(i, i + 3).join());
              return `${name || "mesh"} ${colours.size}`;
            }),
        ),
      );
    assert.deepEqual(await shown(), [["mesh 0"], ["mesh 0"]]);
    await page.check("#pieces");
    await until(() => window.hapticd.stage.pieces !== null);
    assert.deepEqual(asked, [`${url}pieces/0.bin`]);
    assert.deepEqual(await shown(), [["pieces 8"], ["mesh 0"]]);
    await page.uncheck("#pieces");
    assert.deepEqual(await shown(), [["mesh 0"], ["mesh 0"]]);
    await page.keyboard.press("c");
    assert.deepEqual(await shown(), [["pieces 8"], ["mesh 0"]]);
    assert.equal(asked.length, 1, "fetched once");
  });

  test("what clients draw is in the picture, in its colours, and goes with them", async () => {
    await open();
    const share_of = (wanted) =>
      page.evaluate((hex) => {
        const { stage } = window.hapticd;
        stage.dirty = true;
        stage.draw();
        const gl = stage.renderer.getContext();
        const [w, h] = [gl.drawingBufferWidth, gl.drawingBufferHeight];
        const pixels = new Uint8Array(4 * w * h);
        gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, pixels);
        let count = 0;
        // a dot is darker at its rim
        for (let i = 0; i < pixels.length; i += 4) {
          const [r, g, b] = [pixels[i], pixels[i + 1], pixels[i + 2]];
          count += hex === "magenta" ? r > 120 && b > 120 && g < 40 : g > 240 && r < 20 && b < 20;
        }
        return count / (w * h);
      }, wanted);
    assert.equal(await share_of("magenta"), 0);
    const radius = 0.006;
    const points = [{ p: [0, 0.047, 0], radius, colour: 0xff00ff }];
    const lines = [{ from: [-0.05, 0.037, 0], to: [0.05, 0.037, 0], colour: 0x00ff00 }];
    mock.draw(3, { points, lines });
    await until(() => window.hapticd.stats.drawings === 1);
    const [dots, wide] = [await share_of("magenta"), await share_of("green")];
    assert.ok(wide > 0, "the line is seen");
    // as large as a ball of that radius there: by the camera's own measure
    const wanted = await page.evaluate((r) => {
      const { stage } = window.hapticd;
      const cell = stage.cell(0);
      const in_pixels = r / stage.metres_per_pixel([0, 0.047, 0]);
      return (Math.PI * in_pixels ** 2) / (cell.width * cell.height);
    }, radius);
    assert.ok(dots > 0.85 * wanted && dots < 1.15 * wanted, `${dots} of the picture, not ${wanted}`);
    mock.draw(3, { points: [] });
    await until(() => window.hapticd.stats.drawings === 2);
    assert.equal(await share_of("magenta"), 0);
    mock.draw(3, { points });
    await until(() => window.hapticd.stats.drawings === 3);
    assert.ok((await share_of("magenta")) > 0);
    mock.draw(3, null);
    await until(() => window.hapticd.stats.drawings === 4);
    assert.equal(await share_of("magenta"), 0);
  });

  test("clients that give have a line each, marked where something is wrong", async () => {
    await open();
    assert.equal(await page.isVisible("#giving"), false);
    mock.giving = [
      { name: "arm", text: "gives, pid 7, 100 Hz", well: true },
      { name: "cup", text: "gives, pid 8; late: what it gives is not felt", well: false },
    ];
    await until(() => document.querySelectorAll("#giving li").length === 2);
    assert.equal(await text("#giving li:first-child"), "arm gives, pid 7, 100 Hz");
    assert.equal(await text("#giving li.warn"), "cup gives, pid 8; late: what it gives is not felt");
    mock.giving = [];
    await until(() => document.querySelector("#giving").hidden);
  });

  test("a scene without convex pieces offers none", async () => {
    await open();
    assert.equal(await page.isDisabled("#pieces"), true);
  });

  test("by keyboard alone: camera, touch, help, plots; no trap", async () => {
    await open();
    const seen = [];
    for (let i = 0; i < 45; i += 1) {
      await page.keyboard.press("Tab");
      seen.push(
        await page.evaluate(() => document.activeElement.id || document.activeElement.className),
      );
    }
    for (const id of [
      "theme",
      "help",
      "view-start",
      "shell",
      "touch",
      "stage",
      "renderer",
      "stiffness",
      "pause",
      "plot-pause",
      "plot-body",
    ])
      assert.ok(seen.includes(id), `Tab reaches ${id}: ${seen}`);
    assert.ok(seen.lastIndexOf("theme") > seen.indexOf("theme"), "Tab goes around");
    const visible = await page.evaluate(() => {
      const style = getComputedStyle(document.activeElement);
      return style.outlineStyle !== "none" && parseFloat(style.outlineWidth) >= 2;
    });
    assert.ok(visible, "the focus is seen");
    await page.focus("#stage");
    const before_turn = await page.evaluate(() => window.hapticd.stage.camera.position.x);
    await page.keyboard.press("ArrowRight");
    assert.notEqual(await page.evaluate(() => window.hapticd.stage.camera.position.x), before_turn);
    await page.keyboard.press("t");
    await page.keyboard.down("ArrowRight");
    await eventually(() => sent("lead").length > 3);
    await page.keyboard.up("ArrowRight");
    await eventually(() => sent("release").length === 1);
    await page.keyboard.press("Space");
    await eventually(() => sent("lead").length > 8);
    await page.keyboard.press("Escape");
    await eventually(() => sent("release").length === 2);
    await page.keyboard.press("?");
    assert.ok(await page.isVisible("#help-panel"));
    await page.keyboard.press("Escape");
    assert.ok(await page.isHidden("#help-panel"));
    await page.focus(".plot-body");
    await page.keyboard.press("ArrowLeft");
    await until(() => /Force at/.test(document.querySelector("#announcements").textContent));
    await page.keyboard.press("+");
    assert.equal(await page.getAttribute("#plot-pause", "aria-pressed"), "true");
    await page.keyboard.press("Home");
    assert.equal(await page.getAttribute("#plot-pause", "aria-pressed"), "false");
  });

  test("everything that can be operated has a name for screen readers", async () => {
    await open();
    const session = await nameless(page);
    assert.deepEqual(session, []);
    await page.close();
    await mock.close();
    await open({ log: true });
    assert.deepEqual(await nameless(page), []);
    assert.equal(await page.getAttribute("#announcements", "aria-live"), "polite");
  });

  test("dark and light follow the system until somebody chooses", async () => {
    await open({ colours: "light" });
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const light = await ground();
    await page.emulateMedia({ colorScheme: "dark" });
    await until((was) => getComputedStyle(document.body).backgroundColor !== was, light);
    await page.click("#theme");
    assert.equal(await ground(), light);
    await page.emulateMedia({ colorScheme: "dark" });
    assert.equal(await ground(), light, "the choice holds");
  });

  for (const [name, size] of [
    ["phone", [360, 640]],
    ["phone on its side", [640, 360]],
    ["tablet", [820, 1180]],
    ["4K", [3840, 2160]],
  ]) {
    test(`fits a ${name}, live and recorded, with one column and four`, async () => {
      for (const options of [{}, { log: true }, { log: true, columns: 4 }]) {
        await open({ size, ...options });
        assert.deepEqual(await overflow(page), { wide: 0, cut: [] });
        await page.close();
        await mock.close();
      }
    });
  }

  test("a recording: the tool at its tightest place, where that was measured", async () => {
    await open({ log: true });
    await until(
      (text) => document.querySelector("#legend-tightest").textContent === text,
      kTightest.text,
    );
    const drawn = await page.evaluate(() => {
      const [{ tightest, proxy }] = window.hapticd.stage.models;
      const { group, ghost, dots, line } = tightest;
      const { x, y, z, w } = ghost.quaternion;
      return {
        visible: group.visible,
        pose: [...ghost.position.toArray(), w, x, y, z],
        dots: dots.map((dot) => dot.position.toArray()),
        length: line.scale.y,
        is_tool: ghost.geometry === proxy.children[0].geometry,
      };
    });
    assert.equal(drawn.visible, true);
    assert.deepEqual(drawn.pose, kTightest.tool);
    assert.deepEqual(drawn.dots, [kTightest.tool_point, kTightest.object_point]);
    assert.ok(Math.abs(drawn.length - kTightest.distance) < 1e-9);
    assert.equal(drawn.is_tool, true);
    assert.ok(await page.isVisible("#legend-tightest"));
    await page.close();
    await mock.close();
    await open();
    assert.ok(await page.isHidden("#legend-tightest"), "a session has none");
  });

  test("a recording: slider, steps, marks, playing, loop, export", async () => {
    await open({ log: true });
    const tick = () => page.evaluate(() => window.hapticd.latest.tick);
    const at = (wanted) => until((t) => window.hapticd.latest.tick === t, wanted);
    await at(1000);
    await page.focus("#slider");
    await page.keyboard.press("ArrowRight");
    await at(1001);
    await page.click("#step-on");
    await at(1002);
    await page.selectOption("#kind", "late");
    await page.click("#next");
    await at(4001);
    await page.click("#from-here");
    await page.click("#next");
    await at(8002);
    await page.click("#to-here");
    assert.match(await page.getAttribute("#export", "href"), /from=4001&to=8002/);
    await page.check("#loop");
    await eventually(() => sent("loop").some(({ from, to }) => from === 4001 && to === 8002));
    await page.selectOption("#speed", "4");
    await page.keyboard.press("Escape");
    await page.click("#play");
    await eventually(() => sent("play").some(({ speed }) => speed === 4));
    await until(() => window.hapticd.latest.tick > 4001 && window.hapticd.latest.tick < 8002);
    await page.click("#play");
    assert.equal(sent("stop").length, 1);
    const range = await page.evaluate(() => window.hapticd.plots.shown_range);
    assert.deepEqual(range, [1, 31]);
    mock.grow(5000);
    await until(() => Number(document.querySelector("#slider").max) === 36000);
    await until(() => window.hapticd.plots.shown_range[1] === 36);
    assert.ok((await tick()) >= 4001);
    assert.ok(await page.isHidden("#control-set"));
  });

  test("a comparison: a picture and a line in each plot for each column", async () => {
    await open({ log: true, columns: 4, size: [1600, 900] });
    await until(() => window.hapticd.frames.length === 4);
    const { models, lines, labels, hands } = await page.evaluate(() => ({
      models: window.hapticd.stage.models.length,
      lines: window.hapticd.plots.plots.map(({ uplot }) => uplot.series.length - 1),
      labels: [...document.querySelectorAll(".column-label")].map((label) => label.textContent),
      hands: new Set(window.hapticd.stage.models.map(({ hand }) => hand.position.x)).size,
    }));
    assert.equal(models, 4);
    assert.deepEqual(lines, [4, 4, 4, 4, 4]);
    assert.deepEqual(labels, ["god-object3", "virtual-proxy3", "penalty3", "voxel"]);
    assert.equal(hands, 4, "each picture shows its own column");
    assert.equal(await page.locator("#readings thead th").count(), 4);
  });
});
