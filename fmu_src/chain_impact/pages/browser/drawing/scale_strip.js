// The strip at the top of the drawing: scale bar, ruler of forces or impulses, and legend of arrows. The view of the motion lies below it.

const KEY = 64; // [pixels] width of each entry of the legend of arrows
const [STRIP_LETTER, BESIDE_BAR] = [7, 8]; // [pixels] width of a letter in the strip, and distance of the text to the scale bar
const MARK_TO_HEAD = 8; // [pixels] least distance between the last mark of the ruler and its arrowhead
const RULER_LETTER = 6; // [pixels] width of a letter of the ruler's name
const LONGEST_BAR = 1 / 6; // largest length of the scale bar, relative to the width of the strip to the left of any legend
const BAR_TEXT = 6; // largest number of letters in the text beside the scale bar
export const STRIP = 30; // [pixels] height of the strip

/** Return both ends of the part of a line on the screen that lies below the strip; the ends are equal if no part lies there. */
export function belowStrip([[x0, y0], [x1, y1]]) {
  const at = (y) => (y0 === y1 ? 0 : Math.min(Math.max((y - y0) / (y1 - y0), 0), 1));
  const ends = [y0 < STRIP ? at(STRIP) : 0, y1 < STRIP ? at(STRIP) : 1];
  return ends.map((share) => [x0 + share * (x1 - x0), y0 + share * (y1 - y0)]);
}

/** Draw the strip of a `ChainDrawing` with its `ruler`; in an enlarged drawing, where links may cross it, it has a ground of its own. */
export function drawStrip(group, { recording, ruler, camera, size: [width], lens }) {
  group.clear();
  if (lens) group.rect(width, STRIP).addClass("strip-ground");
  const free = recording.drawn.loads.length ? drawKey(group, width) : width;
  const rulerEnd = ruler.scale.peak > 0 ? drawRuler(group, ruler, free) : 0;
  drawScaleBar(group, camera.scale, free, rulerEnd);
}

/**
 * Draw a scale bar of a round length, at most LONGEST_BAR × `width`: in the middle or, if the ruler reaches so far, to the right
 * of the ruler's end, `rulerEnd` [pixels]. A bar that would end beyond `width` is not drawn. `width`: that of the strip to the left of any
 * legend [pixels]; `scale`: in pixels per metre.
 */
function drawScaleBar(group, scale, width, rulerEnd) {
  const wanted = (LONGEST_BAR * width) / scale;
  const power = 10 ** Math.floor(Math.log10(wanted));
  const length = power * [5, 2, 1].find((factor) => factor * power <= wanted);
  const y = 0.6 * STRIP;
  const text = length < 0.01 ? `${+(1000 * length).toPrecision(1)} mm` : `${+length.toPrecision(1)} m`;
  const left = Math.max(width / 2 - (length * scale) / 2, rulerEnd + STRIP_LETTER * text.length + 2 * BESIDE_BAR);
  const right = left + length * scale;
  if (right > width) return;
  group.polyline([[left, y - 4], [left, y + 4], [left, y], [right, y], [right, y - 4], [right, y + 4]])
    .addClass("bar").fill("none");
  group.plain(text).attr({ x: left - BESIDE_BAR, y: y + 4 }).addClass("bar-text");
}

/**
 * Draw the ruler of an `ArrowScale` (`scale`) with its marks, up to its peak, but at least MARK_TO_HEAD beyond the last mark; write
 * what the arrows are (`name`) as far as it fits into the `width`. Return the horizontal position of the end of this text [pixels].
 */
function drawRuler(group, { name, scale: { longest, marks } }, width) {
  const [left, y] = [12, STRIP - 7];
  const right = left + Math.max(longest, ...marks.map(({ at }) => at + MARK_TO_HEAD));
  group.line([[left, y], [right, y]]).addClass("bar ruler");
  marks.forEach(({ at, text }) => {
    group.line([[left + at, y - 4], [left + at, y + 4]]).addClass("bar");
    group.plain(text).attr({ x: left + at, y: y - 7 }).addClass("ruler-text");
  });
  group.polygon([[right + 7, y], [right, y - 4], [right, y + 4]]).addClass("ruler-head");
  const end = right + 12;
  const free = (1 - LONGEST_BAR) * width - STRIP_LETTER * BAR_TEXT - 2 * BESIDE_BAR - end;
  const shown = [`${name} (cube root)`, name].find((text) => RULER_LETTER * text.length <= free) ?? "";
  group.plain(shown).attr({ x: end, y: y + 4 }).addClass("ruler-name");
  return end + RULER_LETTER * shown.length;
}

/**
 * Draw the legend of the two kinds of arrows, with a background that hides walls; return the horizontal position of its left end [pixels].
 */
function drawKey(group, width) {
  group.rect(2 * KEY, STRIP - 5).move(width - 2 * KEY, 0).addClass("key-ground");
  [["joint", "load"], ["wall", "force"]].forEach(([name, kind], column) => {
    group.plain(`➝ ${name}`).attr({ x: width - 8 - KEY * column, y: 0.6 * STRIP + 4 }).addClass(`key ${kind}`);
  });
  return width - 2 * KEY;
}
