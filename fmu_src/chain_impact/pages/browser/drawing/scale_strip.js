// The strip at the top of the drawing: scale bar, ruler of forces, and legend of arrows. The chain never covers the strip.

const KEY = 64; // [pixels] width of each entry of the legend of arrows
const [STRIP_LETTER, BESIDE_BAR] = [7, 8]; // [pixels] width of a letter in the strip at the top, and distance to the scale bar
const NAMED_FROM = 480; // [pixels] least width of a drawing in which the ruler has its name
export const STRIP = 30; // [pixels] height of the strip at the top for the scale bar

/** Return the part of a line on the screen that is below the strip with the scale bar. */
export function belowStrip([[x0, y0], [x1, y1]]) {
  const at = (y) => (y0 === y1 ? 0 : Math.min(Math.max((y - y0) / (y1 - y0), 0), 1));
  const ends = [y0 < STRIP ? at(STRIP) : 0, y1 < STRIP ? at(STRIP) : 1];
  return ends.map((share) => [x0 + share * (x1 - x0), y0 + share * (y1 - y0)]);
}

/**
 * Draw a bar of a round length, about a sixth of the width, in the middle, or behind the end of the ruler; `scale` is in
 * pixels per metre.
 */
export function drawScaleBar(group, scale, width, rulerEnd) {
  const wanted = width / 6 / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = power * [5, 2, 1].find((factor) => factor * power <= wanted);
  const y = 0.6 * STRIP;
  const text = length < 0.01 ? `${+(1000 * length).toPrecision(1)} mm` : `${+length.toPrecision(1)} m`;
  const left = Math.max(width / 2 - (length * scale) / 2, rulerEnd + STRIP_LETTER * text.length + 2 * BESIDE_BAR);
  const right = left + length * scale;
  group.polyline([[left, y - 4], [left, y + 4], [left, y], [right, y], [right, y - 4], [right, y + 4]])
    .addClass("bar").fill("none");
  group.plain(text).attr({ x: left - BESIDE_BAR, y: y + 4 }).addClass("bar-text");
}

/** Draw the lengths of the arrows of round forces, up to the largest force; return where the ruler ends. */
export function drawRuler(group, { longest, marks }, width) {
  const [left, y] = [12, STRIP - 7];
  group.line([[left, y], [left + longest, y]]).addClass("bar ruler");
  marks.forEach(({ at, text }) => {
    group.line([[left + at, y - 4], [left + at, y + 4]]).addClass("bar");
    if (text) group.plain(text).attr({ x: left + at, y: y - 7 }).addClass("ruler-text");
  });
  group.polygon([[left + longest + 7, y], [left + longest, y - 4], [left + longest, y + 4]]).addClass("ruler-head");
  const end = left + longest + 12;
  if (width < NAMED_FROM) return end;
  group.plain("force").attr({ x: end, y: y + 4 }).addClass("ruler-name");
  return end + STRIP_LETTER * "force".length;
}

/** Draw the legend of the two kinds of arrows, on a ground that covers walls. */
export function drawKey(group, width) {
  group.rect(2 * KEY, STRIP - 5).move(width - 2 * KEY, 0).addClass("key-ground");
  [["joint", "load"], ["wall", "force"]].forEach(([name, kind], column) => {
    group.plain(`➝ ${name}`).attr({ x: width - 8 - KEY * column, y: 0.6 * STRIP + 4 }).addClass(`key ${kind}`);
  });
}
