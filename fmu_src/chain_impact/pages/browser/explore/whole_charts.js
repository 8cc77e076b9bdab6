// Keeps the list of impacts beside the motion from covering a part of a chart, and the end of the column from cutting a card.

import { find } from "../base/dom.js";
import { fold } from "../player/folding.js";

/**
 * From now on, fold the chart of inputs if the column has no room for all cards, unless the reader has set steps of inputs, or has folded
 * or unfolded this card. While the column is not scrolled, prevent the upper edge of the list from cutting a chart or a title in the
 * column: the charts above the cut part become higher, so that this part moves down and lies wholly behind the list.
 */
export function keepChartsWhole(changes) {
  const [column, list, inputs] = [document.querySelector("aside"), find("list"), find("inputs-card")];
  const foldInputs = () => {
    if (inputs.dataset.isOfReader || inputs.matches(".enlarged")) return;
    fold(inputs, false);
    fold(inputs, Object.keys(changes.inputSteps).length === 0 && column.scrollHeight > column.clientHeight);
  };
  const fit = () => {
    foldInputs();
    const charts = column.scrollTop > 0 ? [] : [...column.querySelectorAll(":scope > :not(.enlarged) .chart")];
    charts.forEach((chart) => chart.style.removeProperty("height"));
    const edge = getComputedStyle(list).position === "sticky" ? list.getBoundingClientRect().top : Infinity;
    const parts = column.querySelectorAll(":scope > :not(.enlarged) :is(h2, .curve-unit, .chart)");
    const boxes = Array.from(parts, (part) => part.getBoundingClientRect());
    const cut = boxes.find(({ top, bottom }) => top < edge && bottom > edge);
    const above = cut ? charts.filter((chart) => chart.checkVisibility() && chart.getBoundingClientRect().bottom <= cut.top) : [];
    above.forEach((chart) => Object.assign(chart.style, { height: `${chart.clientHeight + (edge - cut.top + 1) / above.length}px` }));
  };
  const fitSoon = () => requestAnimationFrame(fit);
  changes.onChange(fitSoon);
  const watch = new ResizeObserver(fitSoon);
  [column, ...column.children].forEach((card) => watch.observe(card));
}
