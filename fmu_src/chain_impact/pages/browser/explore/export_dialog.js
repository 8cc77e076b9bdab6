// The dialog that exports the command, the page's address, tables, the scene file and pictures.

import { byId } from "../base/dom.js";
import { contentsOf, tomlText } from "../scene/changed_file.js";
import { inputSignals } from "../scene/input_steps.js";
import { lawText } from "../scene/words.js";
import { drawingOfCards, pictureOfCards } from "./chart_picture.js";
import { commandOf, csvOf, impactsCsvOf, pictureOf, save } from "./export.js";
import { lawOf } from "./parameters/main_parameters.js";
import { savePage } from "./saved_page.js";

const LONG_ADDRESS = 2000; // number of characters from which on some programs cut an address

/**
 * Connect the buttons of the dialog with their exports.
 *
 * @param keys the rules of the keys of a scene file. @param ask the function that sends a request to the worker. @param address the
 * address of the page, with the changes. @param openScene the open scene; the command names its file, unless it is the page's own scene.
 * @param linesBelow function that returns the lines of a caption that name changes and pins. @param mapNow function that returns the map,
 * once it is made. @param faultOf function that returns a sentence on the fault of a run.
 */
export function connectExport(changes, { keys, ask, address, linesBelow, openScene, mapNow, faultOf }) {
  const captionOf = () => {
    const title = [document.querySelector("h1").textContent, byId("time").textContent, lawText(lawOf(changes))].join(", ");
    return [{ text: title }, ...linesBelow()];
  };
  byId("export-open").addEventListener("click", async () => {
    byId("command").value = commandOf(changes);
    byId("export").showModal();
    await null; // the dialog has then paused the motion, so that the address has the time
    byId("link").value = address.text;
    const { length } = address.text;
    byId("export-text").textContent = [
      location.protocol === "file:" && "The link works on this computer only: to send it, save this page.",
      openScene.text && "The command needs the scene file: save it first.",
      address.lacksPins && "The link has no pins of other scenes.",
      length > LONG_ADDRESS && `The link has ${length} characters; some programs cut it after ${LONG_ADDRESS}.`,
    ].filter(Boolean).join(" ");
  });
  document.querySelectorAll("[data-copy]").forEach((button) => button.addEventListener("click", async () => {
    const field = byId(button.dataset.copy);
    field.select();
    const copied = navigator.clipboard?.writeText(field.value) ?? Promise.reject(new Error("no clipboard"));
    await copied.catch(() => document.execCommand("copy"));
    button.textContent = "Copied";
    setTimeout(() => Object.assign(button, { textContent: "Copy" }), 1500);
  }));
  connectFile("csv", async () => {
    const result = await ask("rows", { ...changes.values }, { inputSteps: changes.inputSteps });
    save(new Blob([csvOf(result)], { type: "text/csv" }), `${changes.scene.name}.csv`);
    return faultOf(result, result.time.length > 0, changes.values);
  });
  connectFile("impacts-csv", async () => {
    const result = await ask("rows", { ...changes.values }, { names: [], inputSteps: changes.inputSteps });
    const text = impactsCsvOf(result.impacts, changes.scene);
    save(new Blob([text], { type: "text/csv" }), `${changes.scene.name}-impacts.csv`);
    return faultOf(result, result.time.length > 0, changes.values);
  });
  connectFile("toml", async () => {
    const text = tomlText(contentsOf(changes, inputSignals(changes)), keys);
    save(new Blob([text], { type: "application/toml" }), `${changes.scene.name}.toml`);
    return "";
  });
  connectFile("save-page", async () => {
    savePage(new URL(address.text).hash, `${changes.scene.name}.html`, mapNow());
    return "";
  });
  connectFile("png", async () => {
    const background = getComputedStyle(document.body).backgroundColor;
    save(await pictureOf(byId("scene"), background, { caption: captionOf() }), `${changes.scene.name}.png`);
    return "";
  });
  [["png", pictureOfCards], ["svg", drawingOfCards]].forEach(([kind, drawn]) => connectFile(`charts-${kind}`, async () => {
    const cards = [...document.querySelectorAll("aside > section:not(#list, [hidden], .folded:not(.enlarged))")];
    const large = cards.filter((card) => card.matches(".enlarged")); // then the picture has this card alone
    if (!cards.length) return "No chart is open.";
    save(await drawn(large.length ? large : cards, captionOf()), `${changes.scene.name}-charts.${kind}`);
    return "";
  }));
}

/** Let the button with an id call `write`, which saves a file and returns "" or a sentence on a fault; show the sentence or error. */
function connectFile(id, write) {
  byId(id).addEventListener("click", async () => {
    byId("export-text").textContent = await write().catch((error) => `${error.message}.`);
  });
}
