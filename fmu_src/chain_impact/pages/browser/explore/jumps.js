// The buttons below the motion on a phone, each of which scrolls the page to one of its parts.

import { find, make } from "../base/dom.js";

// words → selectors of the first element of a part; the first that is shown is scrolled into view
const PARTS = {
  Motion: ["body"],
  Parameters: ["#parameters"],
  Charts: ["#outputs-card", "#inputs-card", "section:has(> #energy)"],
  Impacts: ["#list"],
};

export function addJumps() {
  const jumps = make("nav", { id: "jumps", ariaLabel: "Parts of the page" });
  jumps.append(...Object.entries(PARTS).map(([textContent, places]) => {
    const button = make("button", { type: "button", role: "link", textContent });
    button.addEventListener("click", () =>
      places.map((place) => document.querySelector(place)).find((part) => !part.hidden).scrollIntoView());
    return button;
  }));
  find("stage").append(jumps);
}
