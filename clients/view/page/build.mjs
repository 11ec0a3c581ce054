// SPDX-License-Identifier: GPL-3.0-or-later
// Builds the page: node build.mjs [OUT [SOURCE]]. Needs node_modules beside it (npm ci --ignore-scripts).
import { build } from "esbuild";
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";
import { createRequire } from "node:module";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const out = process.argv[2] ?? join(here, "..", "..", "..", "build", "view");
const source = process.argv[3] ?? join(here, "source");
const find = createRequire(import.meta.url);

/** Folder of an installed package. */
function package_folder(name) {
  let folder = dirname(find.resolve(name));
  while (folder !== dirname(folder)) {
    try {
      if (find(join(folder, "package.json")).name === name) return folder;
    } catch {
      /* not this one */
    }
    folder = dirname(folder);
  }
  throw new Error(`the folder of ${name} is not found`);
}

async function licences(names) {
  const parts = await Promise.all(
    names.map(async (name) => {
      const folder = package_folder(name);
      const { version } = find(join(folder, "package.json"));
      return `${name} ${version}\n\n${(await readFile(join(folder, "LICENSE"), "utf8")).trim()}\n`;
    }),
  );
  return `The page of hapt view contains these libraries.\n\n${parts.join(`\n${"-".repeat(80)}\n\n`)}`;
}

await mkdir(out, { recursive: true });
await build({
  entryPoints: { app: join(source, "app.js") },
  nodePaths: [join(here, "node_modules")],
  bundle: true,
  minify: true,
  format: "esm",
  target: "es2022",
  outdir: out,
  sourcemap: false,
  legalComments: "none",
  logLevel: "warning",
});
// by hand, so that no style depends on the order of a bundle: uPlot's first, ours may change it
const uplot_css = await readFile(join(package_folder("uplot"), "dist", "uPlot.min.css"), "utf8");
await writeFile(
  join(out, "app.css"),
  `${uplot_css}\n${await readFile(join(source, "app.css"), "utf8")}`,
);
await copyFile(join(source, "index.html"), join(out, "index.html"));
await copyFile(join(source, "favicon.svg"), join(out, "favicon.svg"));
await writeFile(join(out, "licences.txt"), await licences(["three", "uplot"]));
