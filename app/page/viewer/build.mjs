// Builds ../bundle: viewer.js (with the decoder's worker inside), viewer.css, page.html and the licences of what is in
// them. The same sources give the same bytes.
import { build } from "esbuild";
import { copyFile, mkdir, readFile, writeFile } from "node:fs/promises";

const OUT = process.argv[2] ?? "../bundle";
const SHIPPED = ["three"];
const options = {
  bundle: true,
  minify: true,
  format: "iife",
  target: "es2022",
  charset: "ascii",
  legalComments: "none",
  write: false,
};

async function bundled(entry, plugins = []) {
  const result = await build({ ...options, entryPoints: [entry], plugins });
  return result.outputFiles[0].text.replaceAll("</script", "<\\/script").replaceAll("<!--", "<\\!--");
}

const worker = await bundled("src/decoding/worker.ts");
const workerText = {
  name: "worker-text",
  setup(context) {
    context.onResolve({ filter: /^worker-text$/ }, () => ({ path: "worker-text", namespace: "text" }));
    context.onLoad({ filter: /.*/, namespace: "text" }, () => ({ contents: worker, loader: "text" }));
  },
};

async function licences() {
  const texts = [];
  for (const name of SHIPPED) {
    const about = JSON.parse(await readFile(`node_modules/${name}/package.json`, "utf8"));
    const text = await readFile(`node_modules/${name}/LICENSE`, "utf8");
    texts.push(`${name} ${about.version} (${about.license})\n\n${text.trim()}\n`);
  }
  return texts.join(`\n${"-".repeat(80)}\n\n`);
}

await mkdir(OUT, { recursive: true });
await writeFile(`${OUT}/viewer.js`, await bundled("src/main.ts", [workerText]));
const style = await build({ entryPoints: ["src/style/viewer.css"], bundle: true, minify: true, write: false });
await writeFile(`${OUT}/viewer.css`, style.outputFiles[0].text);
await copyFile("src/page.html", `${OUT}/page.html`);
await writeFile(`${OUT}/THIRD_PARTY_LICENSES.txt`, await licences());
