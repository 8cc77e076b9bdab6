// The line with the next of the first steps, beside the page's title: it stays until the reader has taken all or has closed it.

import { byId } from "../base/dom.js";
import { store, stored } from "../base/storage.js";

const FIRST_STEPS = [
  "First step: move a slider, the motion follows", "Next step: Pin keeps this motion to compare", "Next step: Map… shows many runs",
];

/** Show the line, unless it has ended before in this browser; tell the first step that the reader has not taken, and mark its control. */
export function showFirstSteps(changes) {
  const line = byId("first-steps");
  const [text, close] = line.children;
  const left = new Set(FIRST_STEPS.keys());
  const show = () => {
    const [next] = left;
    line.hidden = next === undefined;
    text.textContent = FIRST_STEPS[next] ?? "";
    if (line.hidden) delete document.body.dataset.step;
    else document.body.dataset.step = next;
  };
  const take = (...steps) => {
    if (!left.size) return;
    steps.forEach((step) => left.delete(step));
    show();
    if (!left.size) store("first-steps", "taken");
  };
  if (stored("first-steps")) left.clear();
  show();
  changes.onChange(() => take(0));
  ["pin", "map-open"].forEach((id, k) => byId(id).addEventListener("click", () => take(k + 1)));
  close.addEventListener("click", () => take(...FIRST_STEPS.keys()));
}
