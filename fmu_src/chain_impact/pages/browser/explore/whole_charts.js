// The charts beside the motion: none is covered in part by the list of impacts.

import { find } from "../base/dom.js";

/** While the list covers the end of its column, let the chart of energies push down the chart or the title that the list would cut. */
export function keepChartsWhole() {
  const [column, energy, list] = [document.querySelector("aside"), find("energy"), find("list")];
  const watch = new ResizeObserver(() => {
    if (column.scrollTop > 0) return;
    energy.style.removeProperty("height");
    if (getComputedStyle(list).position !== "sticky") return;
    const { top: edge } = list.getBoundingClientRect();
    const boxes = Array.from(column.querySelectorAll("h2, .curve-unit, .chart:not(#energy)"), (part) => part.getBoundingClientRect());
    const cut = boxes.find(({ top, bottom }) => top < edge && bottom > edge);
    if (cut) energy.style.height = `${energy.clientHeight + edge - cut.top}px`;
  });
  [column, ...column.querySelectorAll(":scope > :not(:first-child)")].forEach((card) => watch.observe(card));
}
