// Prints the checksum of each arithmetic: node run.mjs picket_on_wasm32.wasm
import { readFileSync } from "node:fs";

const module = await WebAssembly.instantiate(readFileSync(process.argv[2]), {});
const { checksum } = module.instance.exports;
for (const [name, fixed] of [["Float", 0], ["Fixed", 1]]) {
  console.log(name, BigInt.asUintN(64, checksum(fixed)).toString(16).padStart(16, "0"));
}
