// The column of cards beside the drawing. The reader can fold each card: its title is a button that hides or shows the rest of the card.

import { make } from "../base/dom.js";

/** Make the first words of the title of each card a button that folds the card. */
export function connectFolding() {
  document.querySelectorAll("aside > section > h2").forEach((title) => {
    const words = title.firstChild;
    const button = make("button", { type: "button", className: "fold", title: "Fold or unfold this card", ariaExpanded: true });
    words.before(button);
    button.append(words);
    const card = title.parentElement;
    button.addEventListener("click", () => {
      card.dataset.isOfReader = "true"; // from now on, the reader alone folds the card
      fold(card, !card.classList.contains("folded"));
      card.scrollIntoView({ block: "nearest" });
    });
  });
}

/** Let the column of cards fade at each end where more of it follows. */
export function connectFades() {
  const column = document.querySelector("aside");
  const show = () => {
    const { scrollTop, scrollHeight, clientHeight } = column;
    column.classList.toggle("more-above", scrollTop > 1);
    column.classList.toggle("more-below", scrollTop + clientHeight < scrollHeight - 1);
  };
  column.addEventListener("scroll", show);
  const watch = new ResizeObserver(show);
  [column, ...column.children].forEach((card) => watch.observe(card));
}

/** Fold or unfold a card. */
export function fold(card, isFolded) {
  card.classList.toggle("folded", isFolded);
  card.querySelector(".fold").ariaExpanded = !isFolded;
}
