// What a canvas draws as text of SVG: the calls of its context are noted while it draws.

const toHundredths = (value) => Number(value.toFixed(2));

/** The commands of a path as text. */
class PathText {
  text = "";

  moveTo(x, y) {
    this.#add("M", x, y);
  }

  lineTo(x, y) {
    this.#add(this.text ? "L" : "M", x, y);
  }

  bezierCurveTo(...all) {
    this.#add("C", ...all);
  }

  rect(x, y, width, height) {
    this.#add("M", x, y);
    this.text += `h${toHundredths(width)}v${toHundredths(height)}h${toHundredths(-width)}z`;
  }

  /** Add a whole circle, the only arc that charts have. */
  arc(x, y, radius) {
    this.#add("M", x - radius, y);
    [2 * radius, -2 * radius].forEach((across) => this.#add("a", radius, radius, 0, 1, 0, across, 0));
  }

  closePath() {
    this.text += "z";
  }

  #add(letter, ...all) {
    this.text += letter + all.map(toHundredths).join(" ");
  }
}

const PATH_CALLS = ["moveTo", "lineTo", "bezierCurveTo", "rect", "arc", "closePath"];

/** Call `draw` while each new Path2D of the page also keeps its commands as text, in `told`. */
export async function withToldPaths(draw) {
  const { Path2D: Native } = window;
  window.Path2D = class extends Native {
    told = new PathText();

    constructor(...from) {
      super(...from);
      this.told.text = from[0]?.told?.text ?? "";
    }
  };
  PATH_CALLS.forEach((name) => {
    window.Path2D.prototype[name] = function (...all) {
      this.told[name](...all);
      return Native.prototype[name].apply(this, all);
    };
  });
  try {
    return await draw();
  } finally {
    window.Path2D = Native;
  }
}

/** Return a text as it stands in an SVG file. */
export const escaped = (text) => text.replace(/[&<>"]/g, (sign) => `&#${sign.codePointAt(0)};`);

/** Return the attributes for a colour of a canvas, `kind` is "fill" or "stroke": programs that edit drawings know no alpha in colours. */
function paint(kind, colour) {
  if (colour.startsWith("#")) return `${kind}="${colour}"`;
  const [red, green, blue, alpha = 1] = colour.match(/[\d.e-]+/g).map(Number);
  const scale = colour.startsWith("color") ? 255 : 1; // color(srgb …) has fractions
  return `${kind}="rgb(${[red, green, blue].map((part) => Math.round(scale * part)).join()})" ${kind}-opacity="${toHundredths(alpha)}"`;
}

function strokeOf({ strokeStyle, lineWidth, lineCap, lineJoin }, dashes) {
  const dash = dashes.length ? ` stroke-dasharray="${dashes.map(toHundredths).join(" ")}"` : "";
  return `fill="none" ${paint("stroke", strokeStyle)} stroke-width="${toHundredths(lineWidth)}" stroke-linecap="${lineCap}" ` +
    `stroke-linejoin="${lineJoin}"${dash}`;
}

function transformOf(context) {
  const { a, b, c, d, e, f } = context.getTransform();
  const all = [a, b, c, d, e, f].map((value) => Number(value.toFixed(4)));
  return all.join() === "1,0,0,1,0,0" ? "" : ` transform="matrix(${all.join(" ")})"`;
}

/** Return a text at [x, y] as SVG, in the font of a context; `most`: its largest width, if any. */
function textElement(context, text, [x, y], most) {
  const { font, fillStyle, textAlign, textBaseline } = context;
  const [, weight = "400", size, family] = /^(?:.*?(\d{3}|bold) )?(?:.*? )?([\d.]+)px (.*)$/.exec(font);
  const anchor = { center: "middle", right: "end", end: "end" }[textAlign] ?? "start";
  const down = { middle: 0.35, top: 0.8, bottom: -0.2 }[textBaseline] ?? 0;
  const fit = most && context.measureText(text).width > most ? ` textLength="${toHundredths(most)}" lengthAdjust="spacingAndGlyphs"` : "";
  return `<text x="${toHundredths(x)}" y="${toHundredths(y + down * size)}" font-family="${escaped(family)}" font-size="${size}" ` +
    `font-weight="${weight}" text-anchor="${anchor}" ${paint("fill", fillStyle)}${fit}${transformOf(context)}>${escaped(text)}</text>`;
}

/** Notes what a context draws as SVG, from `begin` to `end`, in `elements`. */
export class SvgRecorder {
  static #count = 0; // of all clips, which have numbers
  elements = [];
  #names = [];

  /** `imageOf`: a function from a canvas that the context draws to its `elements`. */
  constructor(context, imageOf = () => []) {
    Object.assign(this, { context, imageOf });
  }

  begin() {
    const { context } = this;
    let [path, clips] = [new PathText(), []];
    const saved = [];
    const add = (element) => this.elements.push(clips.reduceRight((inner, id) => `<g clip-path="url(#${id})">${inner}</g>`, element));
    const textOf = (given) => (given?.told ?? path).text;
    const alpha = () => (context.globalAlpha < 1 ? ` opacity="${toHundredths(context.globalAlpha)}"` : "");
    const drawPath = (text, attributes) => text && add(`<path d="${text}" ${attributes}${alpha()}${transformOf(context)}/>`);
    this.#note(Object.fromEntries(PATH_CALLS.map((name) => [name, (...all) => path[name](...all)])));
    this.#note({
      beginPath: () => {
        path = new PathText();
      },
      save: () => saved.push(clips),
      restore: () => {
        clips = saved.pop() ?? clips;
      },
      clip: (given) => {
        SvgRecorder.#count += 1;
        const id = `clip-${SvgRecorder.#count}`;
        this.elements.push(`<clipPath id="${id}"><path d="${textOf(given)}"${transformOf(context)}/></clipPath>`);
        clips = [...clips, id];
      },
      stroke: (given) => drawPath(textOf(given), strokeOf(context, context.getLineDash())),
      fill: (given) => drawPath(textOf(given), paint("fill", context.fillStyle)),
      fillRect: (...box) => {
        const rectangle = new PathText();
        rectangle.rect(...box);
        drawPath(rectangle.text, paint("fill", context.fillStyle));
      },
      fillText: (text, x, y, most) => add(textElement(context, text, [x, y], most)),
      drawImage: (canvas, x, y, width, height) => {
        const scales = [width / canvas.width, height / canvas.height].map((scale) => Number(scale.toFixed(5)));
        const place = `<g transform="translate(${toHundredths(x)} ${toHundredths(y)}) scale(${scales.join(" ")})">`;
        add(`<g${transformOf(context)}>${place}${this.imageOf(canvas).join("")}</g></g>`);
      },
    });
  }

  /** Let each method of the context first call the function with the same name. */
  #note(functions) {
    Object.entries(functions).forEach(([name, note]) => {
      const native = this.context[name];
      this.#names.push(name);
      this.context[name] = (...all) => {
        note(...all);
        return native.apply(this.context, all);
      };
    });
  }

  end() {
    this.#names.forEach((name) => delete this.context[name]);
  }
}
