// The buttons of a phone: those below the motion each scroll the page to one of its parts; on its side, one shows and hides the parameters.

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

/** Connect the button that shows the parameters beside the motion, or hides them. */
export function foldParameters() {
  const button = find("parameters-fold");
  const show = (isShown) => {
    button.setAttribute("aria-expanded", isShown);
    document.body.classList.toggle("without-parameters", !isShown);
  };
  button.addEventListener("click", () => show(button.getAttribute("aria-expanded") === "false"));
  show(false);
}
