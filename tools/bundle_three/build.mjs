// Writes the three.js bundle of the viewer page and its licence into the package.
import { build } from "esbuild";
import { copyFileSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { fileURLToPath } from "node:url";

const here = dirname(fileURLToPath(import.meta.url));
const page = join(here, "..", "..", "src", "firstcontact", "view", "page");

const { outputFiles } = await build({
  absWorkingDir: here,
  entryPoints: ["entry.js"],
  bundle: true,
  minify: true,
  format: "iife",
  globalName: "THREE",
  target: "es2020",
  legalComments: "inline",
  write: false,
});
const text = outputFiles[0].text;
// The bundle is inlined into a <script> element, which ends at the first closing tag inside it.
if (/<\/script|<!--/i.test(text)) throw new Error("the bundle cannot be inlined: it holds </script or <!--");
writeFileSync(join(page, "three.js"), text);
copyFileSync(join(here, "node_modules", "three", "LICENSE"), join(page, "three.LICENSE.txt"));
const { version } = JSON.parse(readFileSync(join(here, "node_modules", "three", "package.json"), "utf8"));
console.log(`three ${version}: ${text.length} characters`);
