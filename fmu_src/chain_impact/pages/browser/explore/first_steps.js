// The line with the first steps, beside the page's title: it stays until the reader has taken all steps or has closed it.

import { byId } from "../base/dom.js";
import { store, stored } from "../base/storage.js";

/** Show the line, unless it has ended before in this browser; mark each step that the reader takes. */
export function showFirstSteps(changes) {
  const line = byId("first-steps");
  const [close, ...steps] = line.children;
  const show = (isShown) => {
    line.hidden = !isShown;
    document.body.classList.toggle("with-steps", isShown);
  };
  const end = () => {
    show(false);
    store("first-steps", "taken");
  };
  const take = (step) => {
    step.className = "taken";
    if (steps.every(({ className }) => className)) end();
  };
  show(!stored("first-steps"));
  changes.onChange(() => take(steps[0]));
  ["pin", "map-open"].forEach((id, k) => byId(id).addEventListener("click", () => take(steps[k + 1])));
  close.addEventListener("click", end);
}
