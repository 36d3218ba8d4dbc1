// Bundles the page into one HTML file: node build.mjs OUTPUT.html
import { build } from "esbuild";
import { readFile, writeFile } from "node:fs/promises";
import path from "node:path";
import { fileURLToPath } from "node:url";

const here = path.dirname(fileURLToPath(import.meta.url));
const output = process.argv[2];
if (!output) throw new Error("usage: node build.mjs OUTPUT.html");

// uPlot's license wants its text in every copy, and its own comments are not of the kind that esbuild keeps.
const license = await readFile(path.join(here, "node_modules/uplot/LICENSE"), "utf8");

const result = await build({
  entryPoints: [path.join(here, "src/main.js")],
  bundle: true,
  minify: true,
  format: "iife",
  target: ["es2022"],
  charset: "ascii",
  legalComments: "inline",
  banner: { js: `/*! uPlot (https://github.com/leeoniya/uPlot)\n${license.trim()}\n*/` },
  outdir: "bundle",
  write: false,
  logLevel: "warning",
});
const text = (extension) => result.outputFiles.find((file) => file.path.endsWith(extension)).text;

// A function as replacement, so that "$&" and the like in the bundle stand for themselves.
const fill = (page, marker, content) => {
  if (!page.includes(marker)) throw new Error(`src/index.html has no ${marker}`);
  return page.replace(marker, () => content);
};
const template = await readFile(path.join(here, "src/index.html"), "utf8");
const script = text(".js").replaceAll("</script", "<\\/script");
await writeFile(output, fill(fill(template, "/*STYLE*/", text(".css")), "/*SCRIPT*/", script));
