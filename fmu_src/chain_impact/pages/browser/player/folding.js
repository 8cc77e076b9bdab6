// Lets the reader fold each card beside the drawing: its title is a button that hides or shows the rest of the card.

import { make } from "../base/dom.js";

/** Make the first words of the title of each card a button that folds the card. */
export function connectFolding() {
  document.querySelectorAll("aside > section > h2").forEach((title) => {
    const words = title.firstChild;
    const button = make("button", { type: "button", className: "fold", title: "Fold or unfold this card" });
    button.setAttribute("aria-expanded", "true");
    words.before(button);
    button.append(words);
    button.addEventListener("click", () => {
      const isFolded = title.parentElement.classList.toggle("folded");
      button.setAttribute("aria-expanded", String(!isFolded));
    });
  });
}
