// SPDX-License-Identifier: GPL-3.0-or-later
// The page in Chromium on the real bridge and a real session: BIN=… VIEW=… node --test bridge.test.mjs
// BIN: folder of the programs, VIEW: of the page. SHORT=1 leaves out what is long.
import assert from "node:assert/strict";
import { existsSync, readFileSync, writeFileSync } from "node:fs";
import { join, resolve } from "node:path";
import { after, before, describe, test } from "node:test";
import { eventually, pause, Sessions } from "./live.mjs";

const bin = resolve(process.env.BIN ?? "../../build/dev/bin");
const view = resolve(process.env.VIEW ?? "../../build/dev/view");
const is_short = process.env.SHORT === "1";
const parts = await import("./browser.mjs").catch(() => null);
const lack = !parts
  ? "playwright-core is missing: npm ci --ignore-scripts in tests/view"
  : !parts.has_chromium
    ? "no chromium (CHROMIUM names another)"
    : !existsSync(join(view, "app.js"))
      ? `no page in ${view}: build the target view_page`
      : !existsSync(join(bin, "haptic-view")) && `no programs in ${bin}`;
if (lack) console.log(`SKIPPED: ${lack}`);

const kTicks = 100; // that are compared with the log
const kSame = 1e-6; // [m, N] between page and log
const kMostUnreceived = 1e-3; // of the frames sent

/** `count` of a list's elements, or all, each once, chosen at random. */
function some_of(list, count) {
  const left = [...list];
  const draw = () => left.splice(Math.floor(Math.random() * left.length), 1)[0];
  return Array.from({ length: Math.min(count, left.length) }, draw);
}

/** A scene without real-time priority, always under one name; a contact that is stopped is not
 *  replaced by a spare. */
function write_session(path, scene = "plane") {
  const text = readFileSync(new URL(`../../configs/${scene}.toml`, import.meta.url), "utf8");
  const name = `name = "${scene}"`;
  assert.ok(text.includes(name));
  const more = text.includes("[contact.voxel]") ? "" : "\n\n[contact]\nspare = false";
  writeFileSync(path, text.replace(name, `name = "plane"\nrealtime = false`) + more);
}

describe("the page on the real bridge", { skip: lack }, () => {
  let sessions;
  let hapticd;
  let browser;
  let page;
  const complaints = [];
  const until = (condition, argument) =>
    page.waitForFunction(condition, argument, { timeout: 120000 });
  const latest = (name) => page.evaluate((field) => window.hapticd.latest[field], name);
  const pid_of = (name) =>
    page.evaluate(
      (wanted) => window.hapticd.state.status?.processes.find(({ name: n }) => n === wanted)?.pid,
      name,
    );

  const start = async () => {
    hapticd = sessions.start("hapticd", sessions.file("plane.toml"));
    await eventually(() => sessions.run("hapt", "status").catch(() => ""), "the session");
  };

  before(async () => {
    sessions = new Sessions(bin);
    write_session(sessions.file("plane.toml"));
    await start();
    const address = await sessions.bridge("plane", view);
    browser = await parts.launch();
    page = await browser.newPage({ viewport: { width: 960, height: 600 }, colorScheme: "dark" });
    page.setDefaultTimeout(120000);
    page.on("pageerror", (error) => complaints.push(String(error)));
    page.on("request", (request) => {
      if (!request.url().startsWith(new URL(address).origin)) complaints.push(request.url());
    });
    await page.goto(address.replace("#", "?quality=low&keep=100000#"), {
      waitUntil: "commit",
      timeout: 120000,
    });
    await until(() => window.hapticd?.drawn);
  });
  after(async () => {
    await browser?.close();
    await sessions?.close();
    assert.deepEqual(complaints, []);
  });

  test("moves, plots, and counts from the session's start", async () => {
    const tick = await latest("tick");
    await until((first) => window.hapticd.latest.tick > first + 1000, tick);
    await until(() => window.hapticd.plots.plots.every(({ uplot }) => uplot.data[0].length > 200));
    const { meshes, same, origin, first_seen } = await page.evaluate(() => {
      const { stage, latest: frame, state } = window.hapticd;
      return {
        meshes: stage.eyes.objects.map((eye) => eye?.triangles.length ?? 0),
        same: stage.models[0].hand.position.x === stage.newest[0].tool[0] && frame !== null,
        origin: state.scene.started,
        first_seen: state.first_seen,
      };
    });
    assert.deepEqual(meshes, [36]);
    assert.ok(same, "the picture has the pose of the newest frame");
    assert.ok(origin <= first_seen && first_seen - origin < 600, `${first_seen - origin} s`);
    assert.ok(await page.isVisible("#solver-reason"), "a point has no solver to choose");
  });

  test("what it shows is what is in the log", async () => {
    const recorder = sessions.start("hapt", "record", "-o", sessions.file("log.mcap"));
    await pause(is_short ? 3000 : 20000);
    await until(() => document.querySelector('[data-reading="tick"] td').textContent !== "–");
    const shown = await page.evaluate(() => ({
      tick: Number(document.querySelector('[data-reading="tick"] td').textContent.replace(/\D/g, "")),
      force: document.querySelector('[data-reading="force"] td').textContent,
    }));
    await pause(500);
    await sessions.end(recorder, "SIGINT");
    const csv = (await sessions.run("hapt", "export", sessions.file("log.mcap"))).trim().split("\n");
    const names = csv[0].split(",");
    const columns = ["X_WT.position", "X_WP.position", "F_device_B.force"].map((vector) =>
      ["x", "y", "z"].map((axis) => names.findIndex((name) => name.startsWith(`${vector}.${axis}`))),
    );
    assert.ok(columns.flat().every((at) => at >= 0), csv[0]);
    const rows = new Map(csv.slice(1).map((line) => [Number(line.split(",", 1)[0]), line]));
    const frames = await page.evaluate(() =>
      window.hapticd.kept.map(({ tick, tool, proxy, force }) => [
        tick,
        [tool, proxy, force].map((numbers) => Array.from(numbers.slice(0, 3))),
      ]),
    );
    const both = frames.filter(([tick]) => rows.has(tick));
    assert.ok(both.length >= (is_short ? 10 : kTicks), `${both.length} ticks are in both`);
    for (const [tick, values] of some_of(both, kTicks)) {
      const logged = rows.get(tick).split(",").map(Number);
      values.forEach((vector, kind) =>
        vector.forEach((value, axis) => {
          const wanted = logged[columns[kind][axis]];
          assert.ok(Math.abs(value - wanted) < kSame, `tick ${tick}: ${value}, log ${wanted}`);
        }),
      );
    }
    const told = rows.get(shown.tick)?.split(",").map(Number);
    assert.ok(told, `tick ${shown.tick} of the readings is in the log`);
    const force = Math.hypot(...columns[2].map((at) => told[at]));
    assert.ok(Math.abs(parseFloat(shown.force) - force) <= 0.0051, `${shown.force}, log ${force}`);
  });

  test("the hand is led, falls behind what it means to where an object is, and is let go", async () => {
    await page.click("#touch");
    const box = await page.locator("#stage").boundingBox();
    const [x, y] = [box.x + box.width / 2, box.y + box.height / 2];
    await page.mouse.move(x, y);
    await page.mouse.down();
    await until(() => window.hapticd.latest.leading === 1);
    await page.mouse.move(x + 40, y - 30, { steps: 3 });
    await until(() => window.hapticd.stage.models[0].intent.visible);
    const apart = () => {
      const { tool, intent } = window.hapticd.latest;
      return Math.hypot(...[0, 1, 2].map((axis) => tool[axis] - intent[axis]));
    };
    // to the middle of the block, which holds it off
    await page.evaluate(() => (window.hapticd.touch.intent = [0, 0.02, 0]));
    await until(() => {
      const { force, tool, intent } = window.hapticd.latest;
      const behind = Math.hypot(...[0, 1, 2].map((axis) => tool[axis] - intent[axis]));
      return Math.hypot(...force) > 0.5 && behind > 0.002 && behind < 0.06;
    });
    assert.ok((await page.evaluate(apart)) > 0.002);
    await page.evaluate(() => (window.hapticd.touch.intent = [0, 0.08, 0.02]));
    await until(() => {
      const { tool, intent } = window.hapticd.latest;
      return Math.hypot(...[0, 1, 2].map((axis) => tool[axis] - intent[axis])) < 0.005;
    });
    await page.mouse.up();
    await until(() => window.hapticd.latest.leading === 0);
    await page.keyboard.press("Escape");
  });

  test("sets renderer and stiffness, pauses, disarms", async () => {
    await page.selectOption("#renderer", "virtual-proxy3");
    await page.click("#renderer-form button");
    await until(() => window.hapticd.latest.renderer === 2);
    await page.fill("#stiffness", "500");
    await page.click("#stiffness-form button");
    await until(() => window.hapticd.latest.stiffness === 500);
    for (const [button, field] of [
      ["pause", "paused"],
      ["arm", "armed"],
    ]) {
      const was = await latest(field);
      for (const value of [1 - was, was]) {
        const label = { pause: ["Resume", "Pause"], arm: ["Disarm", "Arm"] }[button][value];
        await until(([id, text]) => document.getElementById(id).textContent === text, [button, label]);
        await page.focus(`#${button}`);
        await page.keyboard.press("Enter");
        await until(([name, wanted]) => window.hapticd.latest[name] === wanted, [field, value]);
      }
    }
    assert.ok(await page.isDisabled('#renderer option[value="voxel"]'));
  });

  test("says that contact has stopped, and when all is well again", async () => {
    const contact = await pid_of("contact0");
    hapticd.kill("SIGSTOP"); // or it would replace contact at once
    process.kill(contact, "SIGSTOP");
    await until(() => /contacts are/.test(document.querySelector("#banner.bad")?.textContent));
    process.kill(contact, "SIGCONT");
    hapticd.kill("SIGCONT");
    await until(() => /All is well again/.test(document.querySelector("#events").textContent));
    await until(() => !document.querySelector("#banner.bad:not([hidden])"));
  });

  test("comes back when hapticd was killed and is started again", async () => {
    await sessions.end(hapticd, "SIGKILL");
    await until(() => window.hapticd.state.gone !== null);
    await until(() => document.querySelector("#banner.bad:not([hidden])"));
    await start();
    const hand = hapticd.pid;
    await until((pid) => window.hapticd.state.status?.processes.some((p) => p.pid === pid), hand);
    await until(() => window.hapticd.state.gone === null && window.hapticd.latest.age_servo < 0.1);
    await until(() => document.querySelector("#control-set").disabled === false);
    await until(() => !document.querySelector("#banner.bad:not([hidden])"));
  });

  test("a body: its mesh, voxel points, and a solver to choose", { skip: is_short }, async () => {
    await sessions.run("hapt", "stop");
    await sessions.end(hapticd); // it holds its name until it is gone
    write_session(sessions.file("plane.toml"), "peg-in-hole");
    await start();
    await until(() => window.hapticd.state.scene.tool.mesh && window.hapticd.stage.has_shell);
    await page.check("#shell");
    const shells = await page.evaluate(() => {
      const { hand, proxy, objects } = window.hapticd.stage.models[0];
      const points = (group) => group.getObjectByName("shell")?.geometry.attributes.position.count;
      return [objects[0], proxy, hand].map((group) => ({
        points: points(group) ?? 0,
        seen: group.getObjectByName("shell")?.visible ?? false,
        triangles: group.children[0].geometry.attributes.position.count / 3, // three corners each
      }));
    });
    assert.ok(shells.some(({ points, seen }) => points > 100 && seen), JSON.stringify(shells));
    assert.ok(shells.every(({ triangles }) => triangles > 10), JSON.stringify(shells));
    assert.ok(await page.isHidden("#solver-reason"));
    await page.selectOption("#solver", "direct");
    await page.click("#solver-set");
    await until(() => window.hapticd.latest.solver === 0);
    await until(() => Math.hypot(...window.hapticd.latest.torque) + window.hapticd.latest.n_pushing > 0);
  });

  test("fits windows and is named, dark and light", async () => {
    const { nameless, overflow } = await import("./page_checks.mjs");
    const sizes = is_short ? [[360, 640]] : [[360, 640], [640, 360], [3840, 2160]];
    for (const [width, height] of sizes) {
      await page.setViewportSize({ width, height });
      assert.deepEqual(await overflow(page), { wide: 0, cut: [] });
    }
    assert.deepEqual(await nameless(page), []);
    const ground = () => page.evaluate(() => getComputedStyle(document.body).backgroundColor);
    const dark = await ground();
    await page.emulateMedia({ colorScheme: "light" });
    await until((was) => getComputedStyle(document.body).backgroundColor !== was, dark);
  });

  test("of the frames sent at most one in a thousand is not received", async () => {
    const { frames_received, sequence_gaps } = await page.evaluate(() => window.hapticd.stats);
    const sent = frames_received + sequence_gaps;
    assert.ok(sequence_gaps <= Math.ceil(sent * kMostUnreceived), `${sequence_gaps} of ${sent}`);
    assert.ok(frames_received > 50);
  });
});
