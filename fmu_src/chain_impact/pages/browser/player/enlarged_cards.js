// Cards beside the motion that the reader enlarges: the motion leaves a part of its space to one card.

import { byId, make } from "../base/dom.js";

// [pixels] space around an enlarged card; with less height than LEAST_BELOW below the motion, the card covers the motion
const [AROUND_CARD, LEAST_BELOW] = [8, 170];

/**
 * Give each card a button that enlarges it. `cards`: pairs [element, part]; `part.enlarge` is called with true when the card becomes large,
 * and with false when it becomes small again. The key Esc shows the whole time again and, if it is shown, ends the large card.
 */
export function enlargeable(cards) {
  const isLarge = (card) => card.classList.contains("enlarged");
  const show = (large) => cards.forEach(([card, part]) => {
    if (isLarge(card) === (card === large)) return;
    card.classList.toggle("enlarged", card === large);
    card.removeAttribute("style");
    card.querySelector(".enlarge").ariaPressed = card === large;
    part.enlarge(card === large);
  });
  const place = () => cards.filter(([card]) => isLarge(card)).forEach(([card]) => Object.assign(card.style, placeOf(card)));
  cards.forEach(([card, part]) => {
    const whole = make("button", { type: "button", className: "whole-time", textContent: "Whole time" });
    const title = part.zoom ? "Enlarge; a drag in the chart then zooms in time" : "Enlarge, with more columns";
    const button = make("button", { type: "button", className: "enlarge", title, ariaLabel: "Enlarge", ariaPressed: false });
    button.setAttribute("aria-describedby", card.getAttribute("aria-labelledby"));
    button.innerHTML = '<svg viewBox="0 0 12 12"><path d="M7 1h4v4M5 11H1V7M11 1 7 5M1 11l4-4"/></svg>';
    whole.addEventListener("click", () => part.zoom());
    button.addEventListener("click", () => {
      show(isLarge(card) ? null : card);
      place();
    });
    const corner = card.querySelector(".corner") ?? make("p", { className: "corner" });
    corner.append(whole, " ", button);
    card.append(corner);
    card.classList.add("with-corner");
  });
  document.addEventListener("keydown", (event) => {
    const large = cards.find(([card]) => isLarge(card));
    if (event.key !== "Escape" || !large || document.querySelector("dialog:modal")) return;
    event.preventDefault(); // the key closes nothing else
    if (large[0].querySelector(".zoomed")) large[1].zoom();
    else show(null);
  });
  const watch = new ResizeObserver(place);
  ["#stage", "aside", "footer"].forEach((part) => watch.observe(document.querySelector(part)));
  ["scroll", "resize"].forEach((event) => addEventListener(event, place));
}

/** Return the place of an enlarged card as a style: below the motion or, without room there, over the whole window. */
function placeOf() {
  const parts = [byId("stage"), ...document.querySelectorAll("aside, body > footer")];
  const [stage, column, footer] = parts.map((part) => part.getBoundingClientRect());
  const pins = byId("pins")?.checkVisibility() ? byId("pins").getBoundingClientRect().top : Infinity;
  const isInColumn = column.bottom > stage.bottom && column.bottom < footer.top && pins > column.bottom;
  const bottom = isInColumn ? column.bottom : Math.min(footer.top, pins > stage.bottom ? pins : Infinity) - AROUND_CARD;
  const below = Math.max(stage.bottom, 0) + AROUND_CARD;
  const isCovering = bottom - below < LEAST_BELOW;
  const [left, top, width] = isCovering ? [AROUND_CARD, AROUND_CARD, innerWidth - 2 * AROUND_CARD] : [stage.left, below, stage.width];
  return { left: `${left}px`, top: `${top}px`, width: `${width}px`, height: `${bottom - top}px` };
}
