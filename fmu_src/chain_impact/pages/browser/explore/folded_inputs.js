// Folds the chart of inputs where the column of cards has no room for it.

import { find } from "../base/dom.js";
import { fold } from "../player/folding.js";

/**
 * From now on, fold the chart of inputs if the column has no room for all cards, unless the reader has set steps of inputs, or has folded
 * or unfolded this card.
 */
export function foldInputsWithoutRoom(changes) {
  const [column, inputs] = [document.querySelector("aside"), find("inputs-card")];
  const fit = () => {
    if (inputs.dataset.isOfReader || inputs.matches(".enlarged")) return;
    fold(inputs, false);
    fold(inputs, Object.keys(changes.inputSteps).length === 0 && column.scrollHeight > column.clientHeight);
  };
  const fitSoon = () => requestAnimationFrame(fit);
  changes.onChange(fitSoon);
  const watch = new ResizeObserver(fitSoon);
  [column, ...column.children].forEach((card) => watch.observe(card));
}
