// The buttons of a phone: those below the motion each scroll the page to one of its parts; on its side, one shows and hides the parameters.

import { byId, make } from "../base/dom.js";

// words → selectors of the first element of a part; the first that is shown is scrolled into view
const PARTS = {
  Motion: ["body"],
  Parameters: ["#parameters"],
  Charts: ["#outputs-card", "#inputs-card", "section:has(> #energy)"],
  Impacts: ["#list"],
};

const BEGUN = 0.7; // a part is the present one when it begins above this part of the height of the screen

export function addJumps() {
  const jumps = make("nav", { id: "jumps", ariaLabel: "Parts of the page" });
  const partOf = (places) => places.map((place) => document.querySelector(place)).find((part) => !part.hidden);
  const all = Object.entries(PARTS).map(([textContent, places]) => {
    const button = make("button", { type: "button", role: "link", textContent });
    button.addEventListener("click", () => partOf(places).scrollIntoView());
    return { button, places };
  });
  jumps.append(...all.map(({ button }) => button));
  byId("stage").append(jumps);
  // the present part is the last one that has begun (BEGUN); the end of the page shows the last part
  const show = () => {
    const isEnd = scrollY + innerHeight >= document.documentElement.scrollHeight - 2;
    const began = all.filter(({ places }, k) => k === 0 || partOf(places).getBoundingClientRect().top < innerHeight * BEGUN);
    const present = isEnd && scrollY > 0 ? all.at(-1) : began.at(-1);
    all.forEach(({ button }) => Object.assign(button, { ariaCurrent: button === present.button ? "true" : null }));
  };
  ["scroll", "resize"].forEach((change) => addEventListener(change, show, { passive: true }));
  show();
}

/** Connect the button that shows the parameters beside the motion, or hides them. */
export function foldParameters() {
  const button = byId("parameters-fold");
  const show = (isShown) => {
    button.setAttribute("aria-expanded", isShown);
    document.body.classList.toggle("without-parameters", !isShown);
  };
  button.addEventListener("click", () => show(button.getAttribute("aria-expanded") === "false"));
  show(false);
}
