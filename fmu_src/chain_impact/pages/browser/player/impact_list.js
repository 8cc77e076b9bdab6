// The list of impacts; a click on a row goes to the impact's `peakTime`: the time of its largest force, or the onset if this is unknown.

import { byId, make } from "../base/dom.js";
import { fixed, impulseText, inOneUnit, peakText, speedWithUnit, unitsOf, withMinus } from "../base/format.js";
import { mapValues } from "../base/map_values.js";
import { capitalized, placeText, touchingPartText, wallText } from "../scene/words.js";

const LONGEST_LIST = 2000; // largest number of rows in the list, because each needs several elements of the page
const FIRST_ROWS = 10; // number of rows that the list shows at first where the page itself scrolls
// number of rows around the present impact that the list shows at first where it scrolls with the charts; fewer in a window below LOW
const [NEAR, FEW_NEAR, LOW] = [5, 4, 740]; // LOW: [pixels]
const COLUMNS = ["#", "time, s", "point", "wall", "speed", "e′", "peak"];
const JOINT_FORCE = "in joint"; // head of the column for the largest force in a joint, which the list has if these forces are known
const OF_LARGE_LIST = ["duration", "penetration", "impulse"]; // columns that only an enlarged list has
const TITLES = {
  "e′": "Speed after the impact over the speed before; above 1, other forces act, too; lasts: no separation yet; –: unknown",
  peak: "Largest force of the contact, at a stop of a joint the largest moment; the impulse of a rigid wall or stop",
  impulse: "Impulse of the contact, at a stop of a joint the angular impulse: walls and stops are rigid",
  [JOINT_FORCE]: "Largest force in a joint while the contact lasts",
};

function approachText(impact) {
  return speedWithUnit(impact.impact_speed, unitsOf(impact).impact_speed).replace("/", "/\u2060"); // no line begins after the slash
}

/**
 * Return {textContent, title} for the ratio of the separation speed to the impact speed. The text is "lasts" if the contact has
 * a peak force and no separation speed yet, else a dash if the ratio is unknown. A ratio above 1 does not describe the contact, because
 * other forces have accelerated the point: the text is "> 1", and the title tells the separation speed.
 */
function reboundCell(impact) {
  const { impact_speed: before, separation_speed: after } = impact;
  if (!Number.isFinite(after ?? NaN)) return { textContent: impact.peak_force === null ? "–" : "lasts" };
  const ratio = before > 0 ? (after / before).toFixed(3) : "–";
  if (!(Number(ratio) > 1)) return { textContent: ratio };
  const title = `Other forces act during the contact: the separation speed is ${speedWithUnit(after, unitsOf(impact).impact_speed)}`;
  return { textContent: ">\u00a01", title };
}

const valueAndUnit = (impact, name) => [impact[name], unitsOf(impact)[name]];

/** The columns with a unit: head → function from an impact to the pair [value, unit]. */
const QUANTITIES_OF = {
  speed: (impact) => valueAndUnit(impact, "impact_speed"),
  peak: (impact) => valueAndUnit(impact, impact.peak_force === null ? "impulse" : "peak_force"),
  [JOINT_FORCE]: ({ joint, joint_force }) => [joint > 0 ? joint_force : null, "N"],
  duration: ({ onset, end }) => [end - onset, "s"],
  penetration: (impact) => valueAndUnit(impact, "max_penetration"),
  impulse: (impact) => valueAndUnit(impact, "impulse"),
};

export class ImpactList {
  constructor(element, goTo) {
    Object.assign(this, { element, goTo });
    this.more = make("button", { id: "impacts-all", type: "button" });
    this.more.addEventListener("click", () => this.#showAll(!this.element.classList.contains("whole")));
    element.after(this.more);
    element.addEventListener("focusin", ({ target }) => target.matches("td button") && this.#reach(target));
    element.addEventListener("keydown", (event) => this.#press(event));
    new ResizeObserver(() => {
      this.#reveal();
      this.#tellSeen();
    }).observe(element);
  }

  /** Let the key Tab reach only this button of the list, so that Tab passes a long list in one step. */
  #reach(button) {
    if (this.reached) this.reached.tabIndex = -1;
    this.reached = Object.assign(button, { tabIndex: 0 });
  }

  /** Go to the button of the next or the previous row with the arrow keys; outside the list, these keys change the time. */
  #press(event) {
    const way = { ArrowUp: -1, ArrowDown: 1 }[event.key];
    if (!way || !event.target.matches("td button")) return;
    event.preventDefault();
    event.stopPropagation();
    const next = this.rows[this.rows.indexOf(event.target.closest("tr")) + way];
    if (!next) return;
    this.#showNear(this.rows.indexOf(next));
    next.querySelector("button").focus();
  }

  /**
   * Show all rows if `isWhole`. Otherwise a page that scrolls shows only the first rows and the row of the present impact, and a list that
   * scrolls with the charts the rows near this one; a list that scrolls by itself still shows all rows.
   */
  #showAll(isWhole) {
    this.element.classList.toggle("whole", isWhole);
    const count = this.rows?.length ?? 0;
    this.more.hidden = count <= NEAR;
    this.more.classList.toggle("few", count <= FIRST_ROWS);
    this.more.textContent = isWhole ? "Fewer impacts" : `All ${this.count} impacts`;
  }

  /** Mark some rows near the row with an index. */
  #showNear(index) {
    const near = innerHeight < LOW ? FEW_NEAR : NEAR;
    const first = Math.max(0, Math.min(index - Math.floor(near / 2), this.rows.length - near));
    this.rows.forEach((row, k) => row.classList.toggle("near", k >= first && k < first + near));
  }

  /** Fill the list with the impacts of a recording, at most the first LONGEST_LIST; a line tells the number of the others. */
  show(recording) {
    const { element } = this;
    this.recording = recording;
    this.current = this.rows = this.reached = undefined;
    this.count = recording.impacts.length;
    element.classList.toggle("none", !recording.impacts.length);
    element.textContent = recording.impacts.length ? "" : "none";
    if (!recording.impacts.length) return this.#showAll(false);
    element.parentElement.style.setProperty("--rows", recording.impacts.length);
    const areImpulses = recording.impacts.every((impact) => impact.peak_force === null && impulseText(impact));
    const ofJoints = recording.impacts.some(({ joint }) => joint > 0) ? [JOINT_FORCE] : [];
    const columns = [...COLUMNS, ...ofJoints, ...(this.isLarge ? OF_LARGE_LIST.filter((name) => !areImpulses || name !== "impulse") : [])];
    const hasStops = recording.impacts.some(({ atStop }) => atStop);
    const table = make("table", { className: hasStops || areImpulses ? "long-units" : "" });
    this.columns = mapValues(QUANTITIES_OF, (quantityOf) => inOneUnit(recording.impacts.map(quantityOf)));
    const heads = columns.map((column) => {
      const name = areImpulses && column === "peak" ? "impulse" : column;
      const textContent = [name, this.columns[column]?.unit].filter(Boolean).join(", ");
      return make("th", { textContent, scope: "col", title: TITLES[name] ?? "" });
    });
    table.createTHead().insertRow().append(...heads);
    const body = table.createTBody();
    this.rows = recording.impacts.slice(0, LONGEST_LIST).map((impact) => this.#row(body, columns, impact));
    this.rows.slice(FIRST_ROWS).forEach((row) => row.classList.add("later"));
    this.#showNear(0);
    this.#reach(this.rows[0].querySelector("button"));
    this.#markLargest(recording.impacts);
    element.append(table);
    const others = recording.impacts.length - this.rows.length;
    if (others > 0) element.append(make("p", { textContent: `and ${others} more, which the animation shows` }));
    this.#showAll(element.classList.contains("whole"));
    this.#tellSeen();
  }

  /**
   * Mark the largest peak force at walls, and the largest peak moment at stops of joints, each if at least two impacts have one and the
   * row of the largest is in the list.
   */
  #markLargest(impacts) {
    [true, false].forEach((ofStops) => {
      const peaks = impacts.map(({ peak_force, atStop }) => (Boolean(atStop) === ofStops ? peak_force ?? 0 : 0));
      const largest = peaks.reduce((most, peak) => Math.max(most, peak), 0);
      const row = this.rows[peaks.indexOf(largest)]; // missing if the list is too long
      if (!row || peaks.filter((peak) => peak > 0).length < 2) return;
      const title = `The largest ${ofStops ? "moment" : "force"} of all impacts`;
      Object.assign(row.cells[COLUMNS.indexOf("peak")], { className: "largest", title });
    });
  }

  #row(body, columns, impact) {
    const row = body.insertRow();
    if (!impact.atStop && Number.isFinite(impact.x ?? NaN)) {
      const [x, y] = [impact.x, impact.y].map((value) => withMinus(fixed(value, 4)));
      row.title = `At x = ${x}\u202fm, y = ${y}\u202fm`;
    }
    if (impact.atStop) row.title = capitalized(placeText(impact));
    const button = make("button", { type: "button", tabIndex: -1, textContent: String(impact.number) });
    button.setAttribute("aria-label", `Go to impact ${impact.number}, at ${impact.onset.toFixed(6)} s`);
    row.insertCell().append(button);
    const textIn = (column) => this.columns[column].textOf(QUANTITIES_OF[column](impact));
    const texts = [
      impact.onset.toFixed(5),
      touchingPartText(impact),
      impact.boxWall?.replace(" wall", "") ?? wallText(impact),
      textIn("speed"),
    ].map((textContent) => ({ textContent }));
    [...texts, reboundCell(impact), { textContent: textIn("peak") }].forEach((cell) => Object.assign(row.insertCell(), cell));
    const { joint } = impact;
    const ofJoint = { textContent: textIn(JOINT_FORCE), title: joint > 0 ? `In joint ${joint}` : "" };
    if (columns.includes(JOINT_FORCE)) row.append(make("td", ofJoint));
    columns.filter((name) => OF_LARGE_LIST.includes(name)).forEach((name) => row.append(make("td", { textContent: textIn(name) })));
    row.addEventListener("click", () => {
      this.goTo(impact);
      // on a phone in landscape format, the list lies far below the motion, so the page scrolls back to it
      byId("stage").scrollIntoView({ block: "nearest" });
    });
    return row;
  }

  /** Let the list be large, with more columns, or small. */
  enlarge(isLarge) {
    this.isLarge = isLarge;
    if (!this.recording) return;
    const { current } = this;
    this.show(this.recording);
    this.draw(0, current);
  }

  /** Mark the row of the present contact in the list, and scroll the list, but not the page, to it. */
  draw(frame, contact) {
    if (contact === this.current) return;
    this.element.querySelector("[aria-current]")?.removeAttribute("aria-current");
    this.current = contact;
    this.rows?.[contact?.number - 1]?.setAttribute("aria-current", "true");
    this.#reveal();
  }

  /** Tell in the title how many of all impacts a list that scrolls shows at a time. */
  #tellSeen() {
    const { scrollHeight, clientHeight } = this.element;
    const [row] = this.rows ?? [];
    const seen = row ? Math.floor((clientHeight - row.parentElement.previousElementSibling.offsetHeight + 1) / row.offsetHeight) : 0;
    byId("impacts-seen").textContent = row && scrollHeight > clientHeight + 1 ? `${seen} of ${this.count} in view` : "";
  }

  /** Scroll the list, but not the page, to the row of the present contact, with one more row below it, which lies in the shadow. */
  #reveal() {
    const row = this.rows?.[this.current?.number - 1];
    if (!row) return;
    if (!row.classList.contains("near")) this.#showNear(this.current.number - 1);
    const top = row.offsetTop - row.parentElement.previousElementSibling.offsetHeight;
    const { scrollTop, clientHeight } = this.element;
    const least = row.offsetTop + 2 * row.offsetHeight - clientHeight;
    this.element.scrollTop = Math.min(top, Math.max(least, scrollTop));
  }
}

/**
 * Return words for a contact of a recording; `time`: the present time [s]. The force comes first, because a narrow screen cuts the end; for
 * the same reason the speed is left out before the onset. The onset of a contact is told while it lasts after its impact. The result is ""
 * for a contact that is not in the list of impacts.
 */
export function impactText({ impacts }, contact, time) {
  if (!contact?.number) return "";
  const { number, onset, end, impactEnd } = contact;
  const isNext = onset > time;
  const [force, speed] = [peakText(contact), approachText(contact)];
  const parts = [force === "–" ? "" : `${force}, `, isNext ? "" : `${speed}, `, placeText(contact)];
  const since = time > impactEnd && time <= end ? `, in contact since ${fixed(onset, 3)}\u202fs` : "";
  return `${isNext ? "Next is impact" : "Impact"} ${number} of ${impacts.length}${since}: ${parts.join("")}`;
}

/** Return the longest text that `impactText` has for an impact of a recording; "" without impacts. */
export function longestImpactText(recording) {
  const texts = recording.impacts.map((impact) => impactText(recording, impact, Math.min(impact.end, recording.end)));
  return texts.reduce((longest, text) => (text.length > longest.length ? text : longest), "");
}
