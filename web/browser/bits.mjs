// The checksum of random blocks in each arithmetic, and that of a scene: node bits.mjs BROWSER PAGE BLOCKS
import { readFileSync } from "node:fs";
import { join } from "node:path";
import { pathToFileURL } from "node:url";

const [, folder, blocks] = process.argv.slice(2);
const { load } = await import(pathToFileURL(join(folder, "core.js")));
const core = await load(readFileSync(join(folder, "picket.wasm")));
for (const fixed of [false, true]) console.log(core.checksum(fixed, Number(blocks)));
console.log(core.sceneChecksum());
