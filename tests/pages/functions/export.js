// Functions that tests/pages/test_export.py runs in a page.

export const simulated = async (changes) => {
  const run = await window.chainImpact.simulate(changes);
  const text = (array) => Array.from(new BigInt64Array(array.buffer), String);
  const some = ["point[4].x", "contact[2].y_min.force", "energy.total", "impact.count",
    "solver.steps"];
  const names = Object.keys(run.columns);
  const impacts = run.impacts.map(({ onset, wall, peak_force }) => [onset, wall, peak_force]);
  const columns = some.map((name) => [name, text(run.columns[name])]);
  return { names, time: text(run.time), columns, impacts };
};

// Draw the text of an SVG file as a picture with a width and a height [pixels]; return the picture as a data address.
export const rasterOf = async ([text, width, height]) => {
  const image = new Image();
  image.src = `data:image/svg+xml;charset=utf-8,${encodeURIComponent(text)}`;
  await image.decode();
  const canvas = Object.assign(document.createElement("canvas"), { width, height });
  canvas.getContext("2d").drawImage(image, 0, 0, width, height);
  return canvas.toDataURL();
};
