// The result of the present run beside the slider that the reader has just moved, for screens where the list of impacts is far below.

import { make } from "../../base/dom.js";
import { largestText } from "../compared_table.js";

/**
 * Return a function that shows the number of impacts in a recording and the largest impact; nothing without a recording. The text is in
 * the row of the slider in `element` that the reader has moved last.
 */
export function outcomeBeside(element) {
  const outcome = make("p", { className: "sentence outcome" });
  outcome.setAttribute("role", "status");
  element.addEventListener("input", ({ target }) => {
    const row = target.type === "range" && target.closest(".main-parameter");
    if (row && outcome.parentElement !== row) {
      outcome.textContent = "";
      row.append(outcome);
    }
  });
  return (recording) => {
    const count = recording?.impacts.length;
    const largest = count ? `, largest ${largestText(recording)}` : "";
    outcome.textContent = recording ? `${count} impact${count === 1 ? "" : "s"}${largest}` : "";
  };
}
