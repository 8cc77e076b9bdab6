// Functions that tests/pages/test_changes.py runs in a page.
import { editedScene, partsOf } from "../../../fmu_src/chain_impact/pages/browser/explore/edited_scene.js";
import { Changes } from "../../../fmu_src/chain_impact/pages/browser/scene/changes.js";
import { contentsOf, tomlText } from "../../../fmu_src/chain_impact/pages/browser/scene/changed_file.js";
import { addLink, removeLink, removePoint, removeWall, setBase, setBox, setOfLink } from "../../../fmu_src/chain_impact/pages/browser/scene/edits.js";
import { asWritten, completedFile } from "../../../fmu_src/chain_impact/pages/browser/scene/scene_file.js";

export const refusedReset = (contents) => {
  const changes = new Changes(sceneOf(contents));
  changes.set({ "box.x_min": -5, "box.x_max": -1 });
  try {
    changes.reset("box.x_min");
  } catch (error) {
    return [error.message, changes.values];
  }
};

export const refusal = ([contents, values]) => {
  try {
    new Changes(sceneOf(contents)).set(values);
  } catch (error) {
    return error.message;
  }
};

export const derivedValues = ([contents, values]) => {
  const scene = sceneOf(contents);
  const changes = new Changes(scene);
  changes.set(values);
  const names = scene.parameters.map(({ name }) => name);
  const all = () => Object.fromEntries(names.map((name) => [name, changes.valueOf(name)]));
  const [shown, text] = [all(), changes.texts().map(([name]) => name)];
  for (const name of Object.keys(values)) changes.reset(name);
  return [shown, text, all(), changes.starts];
};

export const savedText = ([contents, values]) => {
  const changes = new Changes(sceneOf(contents));
  changes.set(values);
  return tomlText(contentsOf(changes), contents.kit.keys);
};

export const keptByEdit = ([contents, values, edit, at]) => {
  const changes = new Changes(sceneOf(contents));
  changes.set(values);
  const edited = contentsOf(changes);
  const before = partsOf(edited);
  ({ addLink, removeLink, removePoint, removeWall, setBase, setBox, setOfLink })[edit](edited, ...at);
  const open = (file) => {
    const whole = completedFile(file, contents.kit);
    return { whole, scene: sceneOf({ file, kit: contents.kit }) };
  };
  const { whole, scene, kept, nameOf, removed } = editedScene(edited, before, changes, { kit: contents.kit, open });
  const names = [changes.scene, scene].map(({ parameters, columns }) => [...parameters, ...columns].map(({ name }) => name));
  return [asWritten(whole), kept.values, Object.fromEntries(names[0].map((name) => [name, nameOf(name)])), names[1], removed];
};
