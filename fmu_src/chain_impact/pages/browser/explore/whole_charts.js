// Keeps the list of impacts beside the motion from covering a part of a chart.

import { find } from "../base/dom.js";

/**
 * From now on, if the upper edge of the list cuts a chart or a title of a column that is not scrolled, make the charts above it higher, so
 * that it moves down and lies behind the list as a whole.
 */
export function keepChartsWhole() {
  const [column, list] = [document.querySelector("aside"), find("list")];
  const fit = () => {
    const charts = column.scrollTop > 0 ? [] : [...column.querySelectorAll(".chart")];
    charts.forEach((chart) => chart.style.removeProperty("height"));
    const edge = getComputedStyle(list).position === "sticky" ? list.getBoundingClientRect().top : Infinity;
    const boxes = Array.from(column.querySelectorAll("h2, .curve-unit, .chart"), (part) => part.getBoundingClientRect());
    const cut = boxes.find(({ top, bottom }) => top < edge && bottom > edge);
    const above = cut ? charts.filter((chart) => chart.checkVisibility() && chart.getBoundingClientRect().bottom <= cut.top) : [];
    above.forEach((chart) => Object.assign(chart.style, { height: `${chart.clientHeight + (edge - cut.top + 1) / above.length}px` }));
  };
  const watch = new ResizeObserver(() => requestAnimationFrame(fit));
  [column, ...column.children].forEach((card) => watch.observe(card));
}
