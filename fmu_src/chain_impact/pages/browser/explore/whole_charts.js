// Keeps the list of impacts beside the motion from covering a part of a chart.

import { find } from "../base/dom.js";

/** While the list covers the end of its column, let the charts above push down the chart or the title that the list would cut. */
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
