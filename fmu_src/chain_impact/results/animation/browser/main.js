// The page of a recording.

import { unpack } from "./packed.js";
import { Player } from "./player.js";
import { Recording } from "./recording.js";

const parts = unpack(JSON.parse(document.getElementById("data").textContent));
new Player(parts.speed).show(new Recording(parts));
