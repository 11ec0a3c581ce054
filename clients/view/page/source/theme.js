// SPDX-License-Identifier: GPL-3.0-or-later
// Dark or light: as the system says, until somebody chooses; the choice is kept.

import { by_id, write } from "./dom.js";

const kKey = "hapticd.theme";

function stored() {
  try {
    return localStorage.getItem(kKey);
  } catch {
    return null;
  }
}

export function set_up_theme(changed) {
  const dark = matchMedia("(prefers-color-scheme: dark)");
  let chosen = stored();
  const apply = () => {
    const theme = chosen ?? (dark.matches ? "dark" : "light");
    document.documentElement.dataset.theme = theme;
    write(by_id("theme"), theme === "dark" ? "Light" : "Dark");
    by_id("theme").setAttribute(
      "aria-label",
      `Change to ${theme === "dark" ? "light" : "dark"} colours`,
    );
    changed();
  };
  dark.addEventListener("change", apply);
  by_id("theme").addEventListener("click", () => {
    chosen = document.documentElement.dataset.theme === "dark" ? "light" : "dark";
    try {
      localStorage.setItem(kKey, chosen);
    } catch {
      /* then it holds until the page is closed */
    }
    apply();
  });
  apply();
}
