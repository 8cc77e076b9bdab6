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
