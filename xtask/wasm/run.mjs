// Runs built-in scenarios in WebAssembly: `node run.mjs FILE.wasm SCENARIO...` writes a line of name and result_hash for each.

import { readFileSync } from "node:fs";

const [file, ...scenarios] = process.argv.slice(2);
const { instance } = await WebAssembly.instantiate(readFileSync(file), {});
const { name_byte, run, result_hash } = instance.exports;

/** The names of the built-in scenarios, in the order of their numbers. */
function names() {
    const found = [];
    for (let number = 0; name_byte(number, 0) >= 0; number += 1) {
        let name = "";
        for (let byte; (byte = name_byte(number, name.length)) > 0; ) name += String.fromCharCode(byte);
        found.push(name);
    }
    return found;
}

const known = names();
for (const scenario of scenarios) {
    if (!run(known.indexOf(scenario))) throw new Error(`the scenario ${scenario} does not run`);
    const parts = [3, 2, 1, 0].map((part) => (result_hash(part) >>> 0).toString(16).padStart(8, "0"));
    console.log(scenario, parts.join(""));
}
