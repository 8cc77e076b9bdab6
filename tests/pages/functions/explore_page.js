// Functions that tests/pages/test_explore_page.py runs in a page.

export const memoryOfRuns = async () => {
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

export const lineOfForces = () => {
  const canvas = document.querySelector("#force canvas");
  const [middle, height] = [Math.round(0.6 * canvas.width), canvas.height];
  const { data } = canvas.getContext("2d").getImageData(middle, 0, 1, height);
  const [red, green, blue] = getComputedStyle(document.querySelector(".force")).color.match(/\d+/g);
  const far = ([r, g, b]) => Math.abs(r - red) + Math.abs(g - green) + Math.abs(b - blue);
  return Array.from({ length: height }, (_, y) => data.slice(4 * y, 4 * y + 4))
    .flatMap((pixel, y) => (pixel[3] > 200 && far(pixel) < 60 ? [y] : []));
};

export const longestFrame = () => new Promise((resolve) => {
  const began = performance.now(); let longest = 0, before = began;
  const tick = (now) => { longest = Math.max(longest, now - before); before = now;
    if (now - began > 600) resolve(longest); else requestAnimationFrame(tick); };
  requestAnimationFrame(tick);
});
