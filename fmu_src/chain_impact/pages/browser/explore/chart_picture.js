// A picture or an SVG drawing of cards with charts: their canvases, texts, and lines of legends, as they are on the screen.

import { styleColour } from "../charts/chart.js";
import { captionHeight, drawCaption } from "./export.js";
import { escaped, SvgRecorder, withToldPaths } from "./svg_recorder.js";

const DENSITY = 3; // least number of pixels of the picture for a pixel of the page, so that a report can show it
const BETWEEN_CARDS = 8; // [pixels] free space between two cards
const LEGEND_LINE = 3; // [pixels] height of the line of a curve in a legend

/**
 * Call `draw` while canvases of charts have `factor` times their pixels in each direction. The plots draw themselves anew when the event
 * of uPlot for another density of the screen arrives, and the canvases enlarge all that they draw.
 */
async function withSharpCanvases(canvases, factor, draw) {
  const { width, height } = Object.getOwnPropertyDescriptors(HTMLCanvasElement.prototype);
  const redraw = async () => {
    dispatchEvent(new Event("dppxchange"));
    await new Promise((done) => setTimeout(done)); // uPlot draws at the end of the present task
  };
  canvases.forEach((canvas) => Object.entries({ width, height }).forEach(([name, property]) => {
    const set = (length) => {
      property.set.call(canvas, Math.round(factor * length));
      canvas.getContext("2d").setTransform(factor, 0, 0, factor, 0, 0);
    };
    Object.defineProperty(canvas, name, { configurable: true, get: property.get, set });
  }));
  try {
    await redraw();
    draw();
  } finally {
    canvases.forEach((canvas) => ["width", "height"].forEach((name) => delete canvas[name]));
    await redraw();
  }
}

/** Return the boxes of cards on the screen, and the size of a picture [pixels] with a caption and one card below the other. */
function placesOf(cards, caption) {
  const boxes = cards.map((card) => card.getBoundingClientRect());
  const height = boxes.reduce((sum, box) => sum + box.height + BETWEEN_CARDS, captionHeight(caption));
  return { boxes, width: Math.max(...boxes.map((box) => box.width)), height };
}

/** Draw the ground of a picture and its caption, and return a function that draws the cards. */
function drawFrame(context, cards, caption, { boxes, width, height }) {
  fill(context, styleColour("panel"), 0, 0, Math.ceil(width), Math.ceil(height));
  drawCaption(context, caption, width, 0);
  return () => {
    let top = captionHeight(caption);
    cards.forEach((card, k) => {
      context.save();
      context.translate(-boxes[k].left, top - boxes[k].top);
      drawCard(context, card, boxes[k]);
      context.restore();
      top += boxes[k].height + BETWEEN_CARDS;
    });
  };
}

const canvasesOf = (cards) => cards.flatMap((card) => [...card.querySelectorAll("canvas")]);

/** Return a picture of cards as a Blob with a PNG: the `caption`, as `drawCaption` takes it, and below it one card below the other. */
export async function pictureOfCards(cards, caption) {
  const density = Math.max(DENSITY, devicePixelRatio);
  const places = placesOf(cards, caption);
  const size = { width: Math.ceil(places.width * density), height: Math.ceil(places.height * density) };
  const canvas = Object.assign(document.createElement("canvas"), size);
  const context = canvas.getContext("2d");
  context.scale(density, density);
  const drawCards = drawFrame(context, cards, caption, places);
  await withSharpCanvases(canvasesOf(cards), density / devicePixelRatio, drawCards);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}

/** Return the same picture as a Blob with an SVG drawing: the calls with which the charts draw themselves are noted as text. */
export async function drawingOfCards(cards, caption) {
  const places = placesOf(cards, caption);
  const charts = canvasesOf(cards).map((canvas) => [canvas, new SvgRecorder(canvas.getContext("2d"))]);
  const imageOf = (canvas) => charts.find(([one]) => one === canvas)[1].elements;
  const picture = new SvgRecorder(document.createElement("canvas").getContext("2d"), imageOf);
  picture.begin();
  const drawCards = drawFrame(picture.context, cards, caption, places);
  charts.forEach(([, recorder]) => recorder.begin());
  await withToldPaths(() => withSharpCanvases(canvasesOf(cards), 1, () => {
    charts.forEach(([, recorder]) => recorder.end());
    drawCards();
  }));
  const { width, height } = places;
  const head = `<svg xmlns="http://www.w3.org/2000/svg" width="${width}" height="${height}" viewBox="0 0 ${width} ${height}">`;
  const title = `<title>${escaped(caption.map(({ text, letter }) => [letter, text].filter(Boolean).join(": ")).join("\n"))}</title>`;
  return new Blob([head, title, ...picture.elements, "</svg>"], { type: "image/svg+xml" });
}

/** Draw a card at its place on the screen; its buttons in the corner are left out. */
function drawCard(context, card, { left, top, width, height }) {
  context.beginPath();
  context.rect(left, top, width, height);
  context.clip();
  card.querySelectorAll("canvas, .now, .of-curve").forEach((element) => {
    if (!element.checkVisibility()) return;
    const box = element.getBoundingClientRect();
    if (element.matches("canvas")) context.drawImage(element, box.left, box.top, box.width, box.height);
    else if (element.matches(".of-curve")) drawPattern(context, element, box);
    else fill(context, styleColour("ink"), box.left, box.top, box.width, box.height);
  });
  const texts = document.createTreeWalker(card, NodeFilter.SHOW_TEXT);
  while (texts.nextNode()) {
    const { currentNode: node } = texts;
    if (!node.parentElement.closest(".corner") && node.parentElement.checkVisibility()) drawWords(context, node);
  }
}

function fill(context, colour, ...box) {
  context.fillStyle = colour;
  context.fillRect(...box);
}

/** Draw the line of a curve in a legend: the parts of the gradient that is its background in the style sheet, again and again. */
function drawPattern(context, element, { left, top, height }) {
  const parts = [...element.style.getPropertyValue("--pattern").matchAll(/(?:var\(--([\w-]+)\)|transparent) (\d+)px (\d+)px/g)];
  const [length, period] = [parseFloat(getComputedStyle(element, "::before").width), Number(parts.at(-1)?.[3])];
  for (let from = 0; from < length; from += period || length) {
    parts.filter(([, name]) => name).forEach(([, name, begin, end]) => {
      const [low, high] = [begin, end].map((at) => Math.min(from + (period > 1 ? Number(at) : at * length), length));
      fill(context, styleColour(name), left + low, top + (height - LEGEND_LINE) / 2, high - low, LEGEND_LINE);
    });
    if (!(period > 1)) break;
  }
}

/** Draw the words of a text node, each where it is on the screen. */
function drawWords(context, node) {
  const { font, color } = getComputedStyle(node.parentElement);
  Object.assign(context, { font, fillStyle: color, textBaseline: "middle", textAlign: "left" });
  // a picture lacks the mark before the title of a card that can be folded, so the first line of the title begins where the mark is
  const fold = node.parentElement.closest("h2")?.querySelector(".fold");
  const [mark, bottom] = fold ? [parseFloat(getComputedStyle(fold, "::before").width), fold.getBoundingClientRect().bottom] : [0, 0];
  const range = document.createRange();
  for (const { 0: word, index } of node.data.matchAll(/[^ \n]+/g)) {
    range.setStart(node, index);
    range.setEnd(node, index + word.length);
    const { left, top, height } = range.getBoundingClientRect();
    context.fillText(word, left - (top + height / 2 < bottom ? mark : 0), top + height / 2);
  }
}
