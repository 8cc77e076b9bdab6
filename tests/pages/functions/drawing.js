// Functions that tests of the drawing run in a page.
import { LabelSpace } from "../../../fmu_src/chain_impact/pages/browser/drawing/label_positions.js";
import { numbersText, ringsOf } from "../../../fmu_src/chain_impact/pages/browser/drawing/rings.js";

export const lengths = () => [...document.querySelectorAll('.arrow-head.force')].map((head) => {
  const [tip] = head.points, { x1, y1 } = head.previousElementSibling;
  return Math.hypot(tip.x - x1.baseVal.value, tip.y - y1.baseVal.value); });

export const onOthers = () => {
  const seen = (kinds) => [...document.querySelectorAll(kinds)]
    .filter((element) => getComputedStyle(element).visibility === 'visible')
    .map((element) => [element.textContent || 'a dot', element.getBoundingClientRect()]);
  const shared = (a, b, low, high) => Math.min(a[high], b[high]) - Math.max(a[low], b[low]);
  const meet = ([, a], [, b]) => shared(a, b, 'left', 'right') > 1 && shared(a, b, 'top', 'bottom') > 3;
  const texts = seen('.point-number, .force-text, .ring-number, .ruler-text, .ruler-name, .bar-text');
  const others = [...texts, ...seen('circle.joint, circle.tip, circle.site')];
  return texts.flatMap((text, k) => others.slice(k + 1).filter((other) => meet(text, other))
    .map((other) => [text[0], other[0]]));
};

export const crossedTexts = () => {
  const seen = (kinds) => [...document.querySelectorAll(kinds)].filter((element) => getComputedStyle(element).visibility === "visible");
  const { width, height } = document.querySelector("#scene").getBoundingClientRect();
  const circles = seen(".ring, .disc").filter((ring) => Number(ring.getAttribute("opacity") ?? 1) > 0.15)
    .map((ring) => [ring.cx, ring.cy, ring.r].map((number) => number.baseVal.value));
  const onLinks = seen("polyline.link").flatMap((link) => [...link.points].slice(1).flatMap(({ x, y }, k) => {
    const from = link.points[k];
    return Array.from({ length: 101 }, (_, part) => [from.x + ((x - from.x) * part) / 100, from.y + ((y - from.y) * part) / 100]);
  }));
  return seen(".force-text, .ring-number, .point-number").filter((text) => {
    const box = text.getBBox();
    // the letters are lower than the box, which has space above and below them
    const [left, right, top, bottom] = [box.x, box.x + box.width, box.y + 0.2 * box.height, box.y + 0.8 * box.height];
    const isOnRing = circles.some(([x, y, radius]) => {
      const nearest = Math.hypot(Math.max(left - x, x - right, 0), Math.max(top - y, y - bottom, 0));
      return nearest < radius && Math.hypot(Math.max(x - left, right - x), Math.max(y - top, bottom - y)) > radius;
    });
    const isOnLink = onLinks.some(([x, y]) => x > left && x < right && y > top && y < bottom);
    return isOnRing || isOnLink || left < 0 || right > width || bottom > height;
  }).map((text) => text.textContent);
};

export const rings = ([onsets, positions]) => {
  const impacts = onsets.map((onset, k) => ({ onset, number: k + 1 }));
  const places = onsets.map((_, k) => ({ position: [positions[k], 5], away: [0, 1] }));
  return ringsOf(impacts, places, onsets.at(-1)).map(({ number, numbers, radius }) => [number, numbersText(numbers), radius]);
};

export const crossedRings = () => {
  const circles = [...document.querySelectorAll(".ring")].map((ring) => [ring.cx, ring.cy, ring.r].map((number) => number.baseVal.value));
  return circles.flatMap(([x, y, r], k) => circles.slice(k + 1).filter((other) => Math.hypot(other[0] - x, other[1] - y) < r + other[2]));
};

export const ringsAndNumbers = () => {
  const middleOf = ({ x, y, width, height }) => [x + width / 2, y + height / 2];
  const of = (kind) => [...document.querySelectorAll(kind)];
  return [of(".ring").map((ring) => middleOf(ring.getBBox())), of(".ring-number").map((text) => [text.textContent, middleOf(text.getBBox())])];
};

export const distancesOfNumbers = () => {
  const dots = [...document.querySelectorAll("circle.joint, circle.tip, circle.site")];
  const middleOf = ({ x, y, width, height }) => [x + width / 2, y + height / 2];
  const at = new Map(dots.map((dot, k) => [String(k), middleOf(dot.getBBox())]));
  return [...document.querySelectorAll(".point-number")]
    .filter((number) => getComputedStyle(number).visibility === "visible")
    .map((number) => [number.textContent, middleOf(number.getBBox())])
    .map(([name, [x, y]]) => Math.hypot(x - at.get(name)[0], y - at.get(name)[1]));
};

/** Return the vectors from the points to their visible numbers, by the numbers. */
export const sidesOfNumbers = () => {
  const middleOf = ({ x, y, width, height }) => [x + width / 2, y + height / 2];
  const dots = [...document.querySelectorAll("circle.joint, circle.tip")].map((dot) => middleOf(dot.getBBox()));
  return Object.fromEntries([...document.querySelectorAll(".point-number")]
    .filter((number) => getComputedStyle(number).visibility === "visible")
    .map((number) => [number.textContent, middleOf(number.getBBox()).map((at, axis) => at - dots[number.textContent][axis])]));
};

/** Return the place of a label with `candidates`, in a drawing in which labels avoid all places left of x = `left`. */
export const placeOfLabel = ([left, candidates]) => {
  const space = new LabelSpace(100, 100, 0);
  space.avoid(([x]) => x < left);
  return space.findPosition("1", 10, candidates.map((at) => ({ at, anchor: "start" }))).at;
};

/** Return the least contrast of each text of a kind with the grounds of the drawing (WCAG 2.2). */
export const contrasts = (kind) => {
  const context = document.createElement("canvas").getContext("2d", { willReadFrequently: true });
  const paint = (colour, alpha = 1) => {
    context.globalAlpha = alpha;
    context.fillStyle = colour;
    context.fillRect(0, 0, 1, 1);
  };
  const luminance = () => {
    const [red, green, blue] = [...context.getImageData(0, 0, 1, 1).data].map((part) => part / 255)
      .map((part) => (part <= 0.04045 ? part / 12.92 : ((part + 0.055) / 1.055) ** 2.4));
    return 0.2126 * red + 0.7152 * green + 0.0722 * blue;
  };
  const grounds = ["free-region", "beyond-walls"].map((name) => getComputedStyle(document.body).getPropertyValue(`--${name}`));
  return [...document.querySelectorAll(kind)].map((text) => Math.min(...grounds.map((ground) => {
    const { fill, opacity } = getComputedStyle(text);
    paint(ground);
    const below = luminance();
    paint(fill, Number(opacity) * Number(text.getAttribute("opacity") ?? 1));
    const [dark, light] = [below, luminance()].sort((a, b) => a - b);
    return (light + 0.05) / (dark + 0.05);
  })));
};
