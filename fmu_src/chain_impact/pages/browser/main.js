// The program of the page that shows a recording.

import { find } from "./dom.js";
import { contactsOf, framesOf, timesOf } from "./frames.js";
import { unpack } from "./packed.js";
import { Player } from "./player.js";
import { Recording } from "./recording.js";

const rows = unpack(JSON.parse(find("data").textContent));
const [start, stop] = [rows.time[0], rows.time.at(-1)];
const contacts = contactsOf(rows.impacts, stop);
const frames = timesOf(contacts, start, stop, rows.pointCount, rows.impactTime, rows.frameRate);
new Player(rows.speed).show(new Recording(framesOf({ ...rows, contacts }, frames)));
