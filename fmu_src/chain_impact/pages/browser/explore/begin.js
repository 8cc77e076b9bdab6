// Begins the two slowest tasks before the page reads its libraries: compiling the kernel, and starting the first worker.

import { decompressed } from "../base/base64.js";
import { find } from "../base/dom.js";
import { Engine } from "../solver/engine.js";

const needed = ["Worker", "WebAssembly", "DecompressionStream"].filter((name) => !(name in window));
if (needed.length) throw new Error(`this browser has no ${needed.join(", no ")}`);
const program = URL.createObjectURL(new Blob([find("worker").textContent], { type: "text/javascript" }));
const compiled = decompressed(find("kernel").textContent).then((bytes) => WebAssembly.compile(bytes));
const startEngine = () => new Engine(program, compiled);
window.begun = { startEngine, engines: [startEngine()] };
