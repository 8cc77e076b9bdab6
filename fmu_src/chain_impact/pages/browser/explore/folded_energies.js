// Folds the chart of energies where the column of cards has no room for it beside charts of inputs and outputs.

import { byId } from "../base/dom.js";
import { fold } from "../player/folding.js";

/**
 * From now on, fold the chart of energies if the column has a chart of inputs or outputs, and no room for all cards, unless the reader has
 * folded or unfolded this card.
 */
export function foldEnergiesWithoutRoom(changes) {
  const [column, energies, ...others] = [document.querySelector("aside"), ...["energy-card", "inputs-card", "outputs-card"].map(byId)];
  const fit = () => {
    if (energies.dataset.isOfReader || energies.matches(".enlarged")) return;
    fold(energies, false);
    fold(energies, others.some((card) => !card.hidden) && column.scrollHeight > column.clientHeight);
  };
  const fitSoon = () => requestAnimationFrame(fit);
  changes.onChange(fitSoon);
  const watch = new ResizeObserver(fitSoon);
  [column, ...column.children].forEach((card) => watch.observe(card));
}
