// The files of a map: its runs as CSV, and its picture.

import { byId } from "../../base/dom.js";
import { pictureOf, save } from "../export.js";
import { valuesAt } from "./map_rows.js";

/** Let the buttons of the dialog save the files of the map that it shows. */
export function connectFiles(map) {
  const nameOf = (ending) => `${map.changes.scene.name}-map.${ending}`;
  byId("map-csv").addEventListener("click", () => save(new Blob([csvOfMap(map.shown)], { type: "text/csv" }), nameOf("csv")));
  byId("map-png").addEventListener("click", async () => save(await pictureOfMap(map), nameOf("png")));
}

/** Return the runs of a map as CSV, with a column for each of the two parameters and for the output. */
function csvOfMap(shown) {
  const { names, output, results } = shown;
  const textOf = (value) => output.places?.[value] ?? value ?? "";
  const lines = Array.from(results, (value, index) => [...Object.values(valuesAt(shown, index)), textOf(value)].join(","));
  return [[...names, output.name].join(","), ...lines, ""].join("\r\n");
}

/** Return the picture of a map: its `canvas` with axes and scale, on the background colour of its `dialog`. */
function pictureOfMap({ canvas, dialog }) {
  const { offsetLeft: left, offsetTop: top, offsetWidth: width, offsetHeight: height } = canvas;
  return pictureOf(byId("map-scales"), getComputedStyle(dialog).backgroundColor, { below(context) {
    context.imageSmoothingEnabled = false;
    context.drawImage(canvas, ...[left, top, width, height].map((length) => 2 * length));
  } });
}
