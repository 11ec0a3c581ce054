// SPDX-License-Identifier: GPL-3.0-or-later
// Real sessions and the real bridge for tests and pictures of the page. BIN: folder of the programs.
import { spawn } from "node:child_process";
import { once } from "node:events";
import { existsSync, mkdtempSync, rmSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";

const kWaiting = 60000; // [ms]; a busy machine takes its time
export const kPatience = 240000; // [ms] of a picture: OpenGL in software, on a busy machine

export const pause = (ms) =>
  new Promise((done) => {
    setTimeout(done, ms);
  });

/** Waits until `condition()` gives something true, and gives it. */
export async function eventually(condition, what = String(condition)) {
  for (const end = Date.now() + kWaiting; ; await pause(50)) {
    const got = await condition();
    if (got) return got;
    if (Date.now() > end) throw new Error(`waited in vain for ${what}`);
  }
}

/** A folder of sessions of its own, in which programs are started; `close` ends all of them. */
export class Sessions {
  constructor(bin) {
    this.bin = bin;
    this.folder = mkdtempSync(join(tmpdir(), "hapticd-view-"));
    this.children = [];
  }

  file(name) {
    return join(this.folder, name);
  }

  /** Starts a program; the child has what it printed as `said`. */
  start(program, ...options) {
    const child = spawn(join(this.bin, program), options, {
      cwd: this.folder,
      env: { ...process.env, HAPTICD_RUNTIME_DIR: this.folder },
      stdio: ["ignore", "pipe", "pipe"],
    });
    child.said = "";
    for (const stream of [child.stdout, child.stderr])
      stream.on("data", (bytes) => {
        child.said += bytes;
      });
    this.children.push(child);
    return child;
  }

  /** Runs a program to its end and gives what it printed; throws where it fails. */
  async run(program, ...options) {
    const child = this.start(program, ...options);
    const [code] = await once(child, "close");
    if (code !== 0) throw new Error(`${program} ${options.join(" ")}: ${child.said}`);
    return child.said;
  }

  /** The bridge to a session by name; gives its address with the token. */
  async bridge(session, page) {
    const options = ["view", "--session", session, "--no-open", "--port", "0", "--page", page];
    const child = this.start("hapt", ...options);
    const [address] = await eventually(() => child.said.match(/http:\S+/), "the bridge's address");
    return address;
  }

  /** `signal` to a process, and its end. */
  async end(child, signal = "SIGTERM") {
    if (child.exitCode !== null || child.signalCode !== null) return;
    const gone = once(child, "exit");
    child.kill(signal);
    await gone;
  }

  async close() {
    for (const child of this.children.reverse()) {
      child.kill("SIGCONT");
      await this.end(child);
    }
    rmSync(this.folder, { recursive: true, force: true });
  }
}

/** Records 20 s of `hapt demo` with these options. Whether the figures of the demo are good does not
 *  matter here: a machine that draws pictures has no time to keep. */
export async function record(sessions, log, ...options) {
  const demo = sessions.start("hapt", "demo", ...options, "--overwrite", "-o", log);
  await once(demo, "close");
  if (!existsSync(log)) throw new Error(demo.said);
}

/** The page on a recording, when the first picture is drawn. */
export async function open_log(browser, sessions, log, view, options) {
  const bridge = sessions.start("hapt", "view", log, "--no-open", "--port", "0", "--page", view);
  const [address] = await eventually(() => bridge.said.match(/http:\S+/), "the bridge's address");
  const page = await browser.newPage({ colorScheme: "light", ...options });
  page.setDefaultTimeout(kPatience);
  await page.goto(address, { waitUntil: "commit", timeout: kPatience });
  await page.waitForFunction(() => window.hapticd?.drawn);
  return page;
}
