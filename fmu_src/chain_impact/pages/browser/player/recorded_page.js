// The program of the page that shows a recording.

import { byId } from "../base/dom.js";
import { framesOf, impactsUntil, timesOf } from "../recording/frames.js";
import { Recording } from "../recording/recording.js";
import { sceneText } from "../scene/words.js";
import { unpack } from "./packed_recording.js";
import { Player } from "./player.js";

const rows = unpack(JSON.parse(byId("data").textContent));
document.querySelector("h1").textContent = sceneText(rows.name);
document.title = `${sceneText(rows.name)} – chain-impact`;
const [start, stop] = [rows.time[0], rows.time.at(-1)];
const impacts = impactsUntil(rows.impacts, stop);
const frames = timesOf(impacts, start, stop, rows.pointCount, rows.impactTime, rows.frameRate);
new Player(rows.speed).show(new Recording(framesOf({ ...rows, impacts }, frames)));
