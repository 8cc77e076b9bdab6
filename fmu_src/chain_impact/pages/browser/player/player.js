// The player: the parts of the page that show a recording, and the loop that draws them.

import { byId, make } from "../base/dom.js";
import { rateText } from "../base/format.js";
import { CurveCharts } from "../charts/curve_charts.js";
import { ForceChart } from "../charts/force_chart.js";
import { EnergyChart } from "../charts/time_chart.js";
import { ChainDrawing } from "../drawing/chain_drawing.js";
import { Clock } from "./clock.js";
import { connect } from "./controls.js";
import { enlargeable } from "./enlarged_cards.js";
import { connectFades, connectFolding } from "./folding.js";
import { ImpactList, impactText, longestImpactText } from "./impact_list.js";
import { Zoom } from "./zoom.js";

// [s] Longest time on the screen by which one frame of the browser advances the motion. After a longer pause of the browser, the motion
// goes on nearly where it stood.
const LONGEST_FRAME = 0.1;

export class Player {
  layers = []; // further objects whose method `draw` is called in each frame
  #isDrawingDue = false;
  #lastTick = undefined;

  constructor(speed) {
    this.clock = new Clock(speed);
    this.drawing = new ChainDrawing(byId("scene"));
    const pointer = {
      seek: (time, contact) => this.clock.seek(time, contact),
      read: (time) => this.panels.forEach(([, card, part]) => card.hidden || part.readAt(time)),
    };
    this.panels = [
      [({ energies }) => Object.keys(energies).length > 0, byId("energy").closest("section"),
        new EnergyChart(byId("energy"), byId("energies"), pointer)],
      [({ inputs }) => inputs?.curves.length > 0, byId("inputs-over-time").closest("section"),
        new CurveCharts(byId("inputs-over-time"), pointer,
          { curvesOf: ({ inputs }) => inputs, label: "Driven inputs", note: byId("inputs-note"),
            whyWithout: "such an input is constant there or does not exist" })],
      [({ outputs }) => outputs?.curves.length > 0, byId("outputs-over-time").closest("section"),
        new CurveCharts(byId("outputs-over-time"), pointer,
          { curvesOf: ({ outputs }) => outputs, label: "Outputs", zoomButton: byId("zoom-impact"),
            title: byId("outputs-impact"), note: byId("outputs-note"), apartBox: byId("curves-apart"),
            whyWithout: "a pin of another scene keeps its outputs" })],
      [({ impacts }) => impacts.length > 0, byId("force").closest("section"),
        new ForceChart(byId("force"), byId("contact-quantity"), byId("contact-name"), byId("force-loop"), pointer)],
    ];
    this.impacts = new ImpactList(byId("impacts"), (impact) => this.clock.toImpact(impact));
    enlargeable([...this.panels.map(([, card, part]) => [card, part]), [byId("list"), this.impacts]]);
    this.zoom = new Zoom(this);
    this.showControls = connect(this.clock, this.drawing, this.zoom);
    connectFolding();
    connectFades();
    this.clock.onChange(() => this.drawSoon());
    new ResizeObserver(() => this.fit()).observe(byId("view"));
  }

  /** Show the first recording, or another one at the present simulated time; hide panels that have nothing to show. */
  show(recording) {
    const first = !this.recording;
    this.recording = recording;
    const [low, high] = recording.view;
    byId("view").style.setProperty("--aspect", (high[0] - low[0]) / (high[1] - low[1]));
    this.panels.forEach(([hasContents, panel, part]) => {
      panel.hidden = !hasContents(recording);
      if (!panel.hidden) part.show(recording);
    });
    [this.drawing, this.impacts].forEach((part) => part.show(recording));
    this.clock.show(recording);
    this.showControls();
    byId("subtitle").replaceChildren(...subtitle(recording));
    byId("caption-room").dataset.longest = longestImpactText(recording);
    if (first) this.#begin();
    else this.drawSoon();
  }

  #begin() {
    this.fit();
    performance.mark("first-frame");
    this.clock.set({ playing: !matchMedia("(prefers-reduced-motion: reduce)").matches });
  }

  /** Fit the drawing to its place on the page, and draw at once, so that no frame of the browser shows it with its old size. */
  fit() {
    if (!this.recording) return;
    const { clientWidth, clientHeight } = byId("view");
    this.drawing.resize(clientWidth, clientHeight);
    this.draw();
  }

  /** Draw once before the browser next paints the page. A motion that plays then goes ahead, which asks for the next drawing. */
  drawSoon() {
    if (this.#isDrawingDue) return;
    this.#isDrawingDue = true;
    requestAnimationFrame((now) => {
      this.#isDrawingDue = false;
      this.draw();
      const { playing } = this.clock;
      if (playing) this.clock.advance(Math.min((now - (this.#lastTick ?? now)) / 1000, LONGEST_FRAME));
      this.#lastTick = playing ? now : undefined;
    });
  }

  /** Draw clock, caption and all other parts of the page at the present frame. */
  draw() {
    const { clock, recording } = this;
    const { frame, time, contact } = clock;
    this.zoom.follow(contact, frame);
    this.panels.forEach(([, panel, part]) => panel.hidden || part.draw(frame, contact));
    [this.drawing, this.impacts, ...this.layers].forEach((part) => part.draw(frame, contact));
    byId("time").textContent = `${time.toFixed(5)} s`;
    byId("rate").textContent = clock.hasEnded ? "" : rateText(clock.rate);
    document.body.classList.toggle("slow-motion", clock.rate < SHARED.pacing.SLOW_RATE * clock.speed);
    document.body.classList.toggle("playing", clock.playing);
    const caption = impactText(recording, contact, time);
    // the caption may be cut, so its whole text is also the tooltip
    if (byId("caption").textContent !== caption) Object.assign(byId("caption"), { textContent: caption, title: caption });
  }
}

/** Return words for a recording: an element with its number of links, if there is room, and its number of impacts with the duration. */
function subtitle({ links, impacts: { length: count }, start, end }) {
  return [
    make("span", { className: "wide", textContent: `${links} link${links === 1 ? "" : "s"}, ` }),
    `${count} impact${count === 1 ? "" : "s"} in ${+(end - start).toPrecision(4)} s`,
  ];
}
