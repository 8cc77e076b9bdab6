// The page of a recording.

import { find } from "./dom.js";
import { unpack } from "./packed.js";
import { Player } from "./player.js";
import { Recording } from "./recording.js";

const parts = unpack(JSON.parse(find("data").textContent));
new Player(parts.speed).show(new Recording(parts));
