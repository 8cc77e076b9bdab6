// Functions that tests/pages/test_explore_page.py runs in a page.

export const many = async () => {
  const output = ["point[4].x"];
  const values = (k) => ({ "contact.restitution": 0.3 + k / 800, "simulation.stop_time": 0.3 });
  const run = (k) => chainImpact.simulate(values(k), { output });
  const whole = async (count) => { for (let k = 0; k < count; k += 1) await run(k); };
  const size = () => { gc(); gc(); return performance.memory.usedJSHeapSize; };
  await whole(100);
  const first = (await run(200)).columns["point[4].x"].at(-1);
  const before = size();
  await whole(400);
  const after = size();
  const held = Array.from({ length: 100 }, () => new Array(10000).fill(0.5));
  return [before, after, size(), first === (await run(200)).columns["point[4].x"].at(-1), held.length];
};
