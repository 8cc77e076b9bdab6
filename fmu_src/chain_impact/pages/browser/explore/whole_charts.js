// Keeps the list of impacts beside the motion from covering a part of a chart.

import { find } from "../base/dom.js";

/**
 * From now on, while the column is not scrolled, prevent the upper edge of the list from cutting a chart or a title in the column: the
 * charts above the cut part become higher, so that this part moves down and lies wholly behind the list.
 */
export function keepChartsWhole() {
  const [column, list] = [document.querySelector("aside"), find("list")];
  const fit = () => {
    const charts = column.scrollTop > 0 ? [] : [...column.querySelectorAll(":scope > :not(.enlarged) .chart")];
    charts.forEach((chart) => chart.style.removeProperty("height"));
    const edge = getComputedStyle(list).position === "sticky" ? list.getBoundingClientRect().top : Infinity;
    const parts = column.querySelectorAll(":scope > :not(.enlarged) :is(h2, .curve-unit, .chart)");
    const boxes = Array.from(parts, (part) => part.getBoundingClientRect());
    const cut = boxes.find(({ top, bottom }) => top < edge && bottom > edge);
    const above = cut ? charts.filter((chart) => chart.checkVisibility() && chart.getBoundingClientRect().bottom <= cut.top) : [];
    above.forEach((chart) => Object.assign(chart.style, { height: `${chart.clientHeight + (edge - cut.top + 1) / above.length}px` }));
  };
  const watch = new ResizeObserver(() => requestAnimationFrame(fit));
  [column, ...column.children].forEach((card) => watch.observe(card));
}
