// The line of a slider, with its stops. A stop is drawn at the edge of the carriage; its text tells the position of the carriage there.

import { digits, withMinus } from "../base/format.js";

// [pixels] distance from the mark of a stop to the middle of its text; half the width that labels keep free there
const [BELOW_STOP, HALF_TEXT] = [10, 24];

/**
 * Draw the lines of a slider, both ends of each on the screen: its own line and the mark of each stop, with its name and the position
 * of the carriage there. `limits`: name → position [m], in the order of the marks. Return lines that labels must not cover.
 */
export function drawRail(group, lines, limits) {
  lines.forEach((line) => group.polyline(line).addClass("pin"));
  const texts = Object.entries(limits).map(([name, position], k) => {
    const [x, y] = lines[k + 1].reduce((low, end) => (end[1] > low[1] ? end : low));
    const text = `${SHARED.names.SLIDER_STOPS[name]} ${withMinus(String(Number(digits(position))))}\u202fm`;
    group.plain(text).attr({ x, y: y + BELOW_STOP + 4, "text-anchor": "middle" }).addClass("point-number");
    return [[x - HALF_TEXT, y + BELOW_STOP], [x + HALF_TEXT, y + BELOW_STOP]];
  });
  return [...lines, ...texts];
}
