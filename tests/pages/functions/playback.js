// Functions that tests/pages/test_playback.py runs in a page.
import { ImpactList } from "../../../fmu_src/chain_impact/pages/browser/player/impact_list.js";

export const longList = (count) => {
  const impact = (k) => ({ onset: k / count, what: "point 1", wall: "y_min", impact_speed: 1, peak_force: 2 });
  const element = document.body.appendChild(document.createElement("div"));
  const impacts = Array.from({ length: count }, (_, k) => impact(k));
  new ImpactList(element, () => {}).show({ impacts, frameAt: () => 0, pointAt: () => [0, 0] });
  return [element.querySelectorAll("tbody tr").length, element.lastChild.textContent];
};

/** Return the number of frames that a page requests in a time [ms]. */
export const framesIn = (time) => new Promise((resolve) => {
  const ask = window.requestAnimationFrame;
  let count = 0;
  window.requestAnimationFrame = (draw) => {
    count += 1;
    return ask(draw);
  };
  setTimeout(() => {
    window.requestAnimationFrame = ask;
    resolve(count);
  }, time);
});
