// What the page exports: the command that repeats a motion, the page's address, the scene file, tables and pictures.

import { styleColour } from "../charts/chart.js";
import { inputSignals, inputStepTexts } from "../scene/input_steps.js";

/**
 * Return a word of a command as a shell needs it: unchanged if it has no special character, in single quotes if it has $ or a similar
 * character, else in double quotes, which Windows accepts, too.
 */
function quoted(word) {
  if (/^[\w./:=+,-]+$/.test(word)) return word;
  return /[$`"\\!%]/.test(word) ? `'${word.replaceAll("'", "'\\''")}'` : `"${word}"`;
}

/**
 * Return the command that repeats the motion: chain-impact simulate or, with changed inputs, a program in Python. If an input has changed
 * while the motion played, all changed inputs are signals in the command.
 */
export function commandOf(changes) {
  const { inputs, command: [source, ...settings] } = changes.scene;
  const [changedInputs, others] = [true, false].map((wanted) => changes.texts().filter(([name]) => inputs.includes(name) === wanted));
  const hasSteps = Object.keys(changes.inputSteps).length > 0;
  const constant = hasSteps ? [] : changedInputs;
  const signals = Object.entries(hasSteps ? inputSignals(changes) : {})
    .map(([name, signal]) => `("signals", "${name}"): ${JSON.stringify(signal)}`);
  const set = others.flatMap(([name, text]) => ["--set", `${name}=${text}`]);
  if (!constant.length && !signals.length) return ["chain-impact", "simulate", source, ...settings, ...set].map(quoted).join(" ");
  const after = (option) => [...settings, ...set].filter((_, k, words) => words[k - 1] === option);
  const pairs = after("--set").map((word) => word.split(/=(.*)/s));
  const driven = signals.length ? `.with_values({${signals.join(", ")}})` : "";
  const table = tableOf(changes.scene.file, after("--inputs"));
  const scene = `load_scene(${JSON.stringify(source)}).with_values(${dictionary(pairs)})${table}${driven}`;
  const program = `from chain_impact import load_scene, simulate; print(simulate(${scene}, inputs=${dictionary(constant)}))`;
  return ["python", "-c", program].map(quoted).join(" ");
}

/**
 * Return the Python code that adds the table of the option --inputs, the last signal of the scene file, to the scene. The second argument
 * is a list with the path of the table's file; for an empty list the code is "".
 */
function tableOf({ signals }, [path]) {
  if (!path) return "";
  const [name, { input, interpolation }] = Object.entries(signals).at(-1);
  const joined = interpolation ? `, "interpolation": ${JSON.stringify(interpolation)}` : "";
  const file = `__import__("os").path.abspath(${JSON.stringify(path)})`;
  return `.with_values({("signals", "${name}"): {"input": ${JSON.stringify(input)}, "form": "table", "file": ${file}${joined}}})`;
}

/** Return pairs of a name and the text of a value as the text of a dictionary in Python. */
function dictionary(pairs) {
  const isPython = (text) => text.startsWith("[") || !Number.isNaN(Number(text));
  const value = (text) => ({ true: "True", false: "False" })[text] ?? (isPython(text) ? text : JSON.stringify(text));
  return `{${pairs.map(([name, text]) => `${JSON.stringify(name)}: ${value(text)}`).join(", ")}}`;
}

/**
 * Return the text after the # of an address: first the texts of `shown` (name → text; no name of a parameter; an empty text is left out),
 * then the changes `given`, by default those of the reader.
 */
export function hashOf(changes, shown = {}, given = changes) {
  const texts = [...Object.entries(shown).filter(([, text]) => text), ...changes.texts(given.values), ...inputStepTexts(given)];
  return texts.map(([name, text]) => `${name}=${encodeURIComponent(text)}`).join("&");
}

/** Return name → text for the entries that `hashOf` writes, from `hash`: the part of an address from the # on. */
export function changesIn(hash) {
  const parts = hash.replace(/^#/, "").split("&").filter(Boolean).map((part) => part.split("="));
  return Object.fromEntries(parts.map(([name, text = ""]) => [decodeURIComponent(name), decodeURIComponent(text)]));
}

/** Return a table with time and outputs (`columns`: name → values) as CSV, with the same columns as the CSV file of a run. */
export function csvOf({ time, columns }) {
  const all = Object.values(columns);
  const lines = Array.from(time, (now, row) => [now, ...all.map((column) => column[row])].join(","));
  return [["time", ...Object.keys(columns)].join(","), ...lines, ""].join("\r\n");
}

/** Return the list of impacts as CSV, with the columns of `simulate --impacts`; an unknown number is empty. */
export function impactsCsvOf(impacts, { wallNames, layout: { contactLog } }) {
  const lines = impacts.map((impact) =>
    Object.values({ ...impact, wall: wallNames[impact.wall], joint: impact.joint || "", duration: impact.end - impact.onset })
      .map((value) => (Number.isNaN(value) ? "" : value)).join(","));
  return [[...Object.keys(contactLog.fields), "duration"].join(","), ...lines, ""].join("\r\n");
}

/** Let the browser save a Blob as a file with a name. */
export function save(blob, name) {
  const link = Object.assign(document.createElement("a"), { href: URL.createObjectURL(blob), download: name });
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 10_000);
}

const DRAWN = ["fill", "fill-opacity", "stroke", "stroke-opacity", "stroke-width", "stroke-linecap", "stroke-linejoin",
  "opacity", "font-family", "font-size", "font-weight", "paint-order", "text-anchor", "stroke-dasharray"];

// [pixels] height of a line of a picture's caption, free space to its left, size of its letters, and diameter of the dot of a pin's letter
const [CAPTION, CAPTION_BESIDE, CAPTION_TEXT, CAPTION_DOT] = [28, 12, 14, 16];

/** Return the height of a caption [pixels]. */
export function captionHeight(caption) {
  return CAPTION * caption.length;
}

/**
 * Draw a caption on a picture with a `width`, from `top` on [pixels]: lines {text, letter, stroke}; a line of a pin has its letter in a dot
 * with the colour of the style sheet that `stroke` names.
 */
export function drawCaption(context, caption, width, top) {
  const { color, fontFamily } = getComputedStyle(document.body);
  caption.forEach(({ text, letter, stroke }, k) => {
    const [left, middle] = [CAPTION_BESIDE + (letter ? CAPTION_DOT + 6 : 0), top + CAPTION * (k + 0.5)];
    Object.assign(context, { font: `${CAPTION_TEXT}px ${fontFamily}`, fillStyle: color, textBaseline: "middle", textAlign: "left" });
    context.fillText(text, left, middle, width - left - CAPTION_BESIDE);
    if (!letter) return;
    context.fillStyle = styleColour(stroke);
    context.beginPath();
    context.arc(CAPTION_BESIDE + CAPTION_DOT / 2, middle, CAPTION_DOT / 2, 0, 2 * Math.PI);
    context.fill();
    Object.assign(context, { font: `700 11px ${fontFamily}`, fillStyle: styleColour("panel"), textAlign: "center" });
    context.fillText(letter, CAPTION_BESIDE + CAPTION_DOT / 2, middle);
  });
}

/**
 * Return a picture of an SVG drawing as a Blob with a PNG, which has twice as many pixels in each direction as the drawing has CSS pixels.
 * The background has the colour `background`; `below(context)` draws on it what lies behind the drawing. `context`: that of the canvas.
 * The picture has the `caption`, as `drawCaption` takes it, below the drawing. The picture has no handles.
 */
export async function pictureOf(svg, background, { below = () => {}, caption = [] }) {
  const copy = svg.cloneNode(true);
  const [from, to] = [svg, copy].map((root) => [...root.querySelectorAll("*")]);
  from.forEach((element, k) => {
    const style = getComputedStyle(element);
    DRAWN.forEach((name) => to[k].style.setProperty(name, style.getPropertyValue(name)));
  });
  copy.querySelectorAll(".above > :not(.refused, .pose)").forEach((handle) => handle.remove());
  copy.setAttribute("xmlns", "http://www.w3.org/2000/svg");
  const address = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(new XMLSerializer().serializeToString(copy))}`;
  const image = new Image();
  image.src = address;
  await image.decode();
  const { width, height } = svg.getBoundingClientRect();
  const canvas = Object.assign(document.createElement("canvas"), { width: 2 * width, height: 2 * (height + captionHeight(caption)) });
  const context = canvas.getContext("2d");
  context.fillStyle = background;
  context.fillRect(0, 0, canvas.width, canvas.height);
  below(context);
  context.drawImage(image, 0, 0, 2 * width, 2 * height);
  context.scale(2, 2);
  drawCaption(context, caption, width, height);
  return new Promise((done) => canvas.toBlob(done, "image/png"));
}
