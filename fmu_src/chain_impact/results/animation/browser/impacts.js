// The list of impacts, which go to their moment.

import { forceText } from "./format.js";

const COLUMNS = ["", "time", "point", "wall", "speed", "peak force"];

/** What is known of the peak of a force; where the rows of the recording are too few for it, what it is at least. */
function peakText({ peak, resolved }) {
  return peak === null ? "–" : `${resolved ? "" : "≥ "}${forceText(peak)}`;
}

export class ImpactList {
  constructor(element, recording, goTo) {
    this.element = element;
    this.recording = recording;
    this.current = null;
    if (!recording.impacts.length) {
      element.textContent = "none";
      element.classList.add("none");
      return;
    }
    const table = document.createElement("table");
    table.createTHead().insertRow().append(
      ...COLUMNS.map((name) => Object.assign(document.createElement("th"), { textContent: name, scope: "col" })),
    );
    const body = table.createTBody();
    this.rows = recording.impacts.map((impact, number) => this.#row(body, impact, number, goTo));
    element.append(table);
  }

  #row(body, impact, number, goTo) {
    const row = body.insertRow();
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = String(number + 1);
    button.setAttribute("aria-label", `Go to impact ${number + 1}, at ${impact.onset.toFixed(6)} s`);
    row.insertCell().append(button);
    const texts = [`${impact.onset.toFixed(5)} s`, impact.point, impact.wall, `${impact.speed.toFixed(2)} m/s`, peakText(impact)];
    texts.forEach((text) => {
      row.insertCell().textContent = text;
    });
    row.addEventListener("click", () => goTo(number));
    return row;
  }

  /** Mark the latest impact and bring it into sight, within the list only. */
  draw(frame) {
    const number = this.recording.impactAt(this.recording.timeAt(frame));
    if (number === this.current) return;
    this.rows?.[this.current]?.removeAttribute("aria-current");
    this.current = number;
    const row = this.rows?.[number];
    if (!row) return;
    row.setAttribute("aria-current", "true");
    const head = row.parentElement.previousElementSibling.offsetHeight;
    const { scrollTop, clientHeight } = this.element;
    if (row.offsetTop - head < scrollTop) this.element.scrollTop = row.offsetTop - head;
    const bottom = row.offsetTop + row.offsetHeight;
    if (bottom > scrollTop + clientHeight) this.element.scrollTop = bottom - clientHeight;
  }
}

/** An impact in words. */
export function impactText({ impacts }, number) {
  const { point, wall, speed, peak } = impacts[number];
  const force = peak === null ? "" : `, peak ${peakText(impacts[number])}`;
  return `Impact ${number + 1} of ${impacts.length}: point ${point} at ${wall}, ${speed.toFixed(2)} m/s${force}`;
}
