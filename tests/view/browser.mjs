// SPDX-License-Identifier: GPL-3.0-or-later
// Debian's Chromium for the tests of the page, with OpenGL in software and nothing kept.
import { existsSync } from "node:fs";
import { chromium } from "playwright-core";

export const kChromium = process.env.CHROMIUM ?? "/usr/bin/chromium";
export const has_chromium = existsSync(kChromium);

/** `more`: further switches. */
export function launch(more = []) {
  // playwright makes a fresh user data folder for each launch
  return chromium.launch({
    executablePath: kChromium,
    headless: true,
    args: [
      "--headless",
      "--no-sandbox",
      "--disable-gpu",
      "--disable-quic",
      "--no-first-run",
      "--disable-background-networking",
      "--disable-component-update",
      "--disable-sync",
      "--enable-unsafe-swiftshader",
      ...more,
    ],
  });
}
