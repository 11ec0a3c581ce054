// SPDX-License-Identifier: GPL-3.0-or-later
// Pictures of the page for people to look at: node shots.mjs VIEW OUT [NAME…]
import { mkdir } from "node:fs/promises";
import { join } from "node:path";
import { launch } from "./browser.mjs";
import { kToken, Mock } from "./mock.mjs";

const [view, out, ...wanted] = process.argv.slice(2);

/** name | mock | width × height | colours | token | what to do before the picture is taken */
const kShots = [
  ["dark", {}, 1280, 720, "dark", true],
  ["light", {}, 1280, 720, "light", false],
  ["phone", {}, 360, 640, "dark", true],
  ["uhd", {}, 3840, 2160, "dark", true],
  [
    "stale",
    {},
    1280,
    720,
    "dark",
    true,
    async (page, mock) => {
      mock.set_trouble("servo");
      await page.waitForSelector("#banner:not([hidden])");
    },
  ],
  [
    "fault",
    {},
    1280,
    720,
    "light",
    true,
    async (page, mock) => {
      mock.fault = 5;
      await page.waitForTimeout(1500);
    },
  ],
  [
    "touch",
    {},
    1280,
    720,
    "dark",
    true,
    async (page) => {
      await page.click("#touch");
      await page.mouse.move(400, 300);
      await page.mouse.down();
      await page.mouse.move(480, 230, { steps: 10 });
      await page.waitForTimeout(500);
    },
  ],
  ["help", {}, 1280, 720, "light", false, (page) => page.click("#help")],
  [
    "log",
    { log: true },
    1280,
    720,
    "dark",
    false,
    async (page) => {
      await page.click("#next");
      await page.waitForTimeout(1500);
    },
  ],
  ["log-phone", { log: true }, 360, 640, "light", false, (page) => page.waitForTimeout(1000)],
  [
    "columns",
    { log: true, columns: 4 },
    1600,
    900,
    "light",
    false,
    async (page) => {
      await page.click("#next");
      await page.waitForTimeout(2000);
    },
  ],
];

await mkdir(out, { recursive: true });
const browser = await launch();
for (const [name, options, width, height, colorScheme, token, act] of kShots) {
  if (wanted.length > 0 && !wanted.includes(name)) continue;
  const mock = new Mock({ view, ...options });
  const url = await mock.listen();
  const page = await browser.newPage({ viewport: { width, height }, colorScheme });
  page.on("console", (message) => console.log(name, message.type(), message.text()));
  page.on("pageerror", (error) => console.log(name, error.stack));
  await page.goto(`${url}?quality=low${token ? `#token=${kToken}` : ""}`);
  await page.waitForFunction(() => window.hapticd?.ready && window.hapticd.stats.frames_drawn > 0);
  await page.waitForTimeout(1500);
  await act?.(page, mock);
  await page.screenshot({ path: join(out, `${name}.png`), fullPage: width < 500 });
  console.log(name, JSON.stringify(await page.evaluate(() => window.hapticd.stats)));
  await page.close();
  await mock.close();
}
await browser.close();
