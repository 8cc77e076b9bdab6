// The line of a slider, with its stops. A stop is drawn at the edge of the carriage; its text tells the position of the carriage there.

import { digits, withMinus } from "../base/format.js";
import { isCrossed } from "./label_positions.js";
import { belowStrip } from "./scale_strip.js";

// [pixels] distance from the mark of a stop to its text, height of a line of the text, half of its width
const [BESIDE_STOP, LINE_OF_TEXT, HALF_TEXT] = [5, 12, 42];
const AT_EDGE = "at carriage’s edge";
const SAMPLES = 60; // number of frames whose chains decide on which side of a mark its text is

/**
 * Draw the lines of a recording's slider, if it has one: its own line and the mark of each stop, with its name and the position of the
 * carriage there. The text is above or below its mark, where the chain crosses it in fewer frames, and in `front` of the chain. `toScreen`:
 * function from positions [m] to positions on the screen. Return lines that labels must not cover.
 */
export function drawRail(group, front, recording, toScreen) {
  front.clear();
  if (!recording.rail) return [];
  const lines = recording.rail.lines.map((line) => belowStrip(toScreen(line)));
  lines.forEach((line) => group.polyline(line).addClass("pin"));
  const segments = sampledFrames(recording).flatMap((frame) => {
    const chain = toScreen(Array.from({ length: recording.links + 1 }, (_, point) => recording.pointAt(frame, point)));
    return chain.slice(1).map((end, k) => [chain[k], end]);
  });
  const texts = Object.entries(recording.rail.limits).flatMap(([name, position], k) => {
    const ends = [...lines[k + 1]].sort((one, other) => other[1] - one[1]);
    const x = ends[0][0];
    const tops = [ends[0][1] + BESIDE_STOP, ends[1][1] - BESIDE_STOP - 2 * LINE_OF_TEXT];
    const [below, above] = tops.map((top) =>
      segments.filter((segment) => isCrossed([x - HALF_TEXT, top, x + HALF_TEXT, top + 2 * LINE_OF_TEXT], segment)).length);
    const top = above < below ? tops[1] : tops[0];
    front.rect(2 * HALF_TEXT, 2 * LINE_OF_TEXT + 2).move(x - HALF_TEXT, top).addClass("text-ground");
    const text = `${SHARED.names.SLIDER_STOPS[name]} ${withMinus(String(Number(digits(position))))}\u202fm`;
    return [text, AT_EDGE].map((words, line) => {
      const y = top + (line + 0.8) * LINE_OF_TEXT;
      front.plain(words).attr({ x, y, "text-anchor": "middle" }).addClass(line ? "point-number rail-note" : "point-number");
      return [[x - HALF_TEXT, y - LINE_OF_TEXT / 3], [x + HALF_TEXT, y - LINE_OF_TEXT / 3]];
    });
  });
  return [...lines, ...texts];
}

/** Return some of the frames of a recording. */
function sampledFrames({ time }) {
  return Array.from({ length: SAMPLES }, (_, k) => (k * (time.length - 1)) / (SAMPLES - 1));
}
