// Functions that tests/pages/test_screen.py runs in a page.

export const reachable = (name) => {
  const grip = document.querySelector(`[data-grip="${name}"]`), box = grip?.getBoundingClientRect();
  const at = box && [box.x + box.width / 2, box.y + box.height / 2];
  return at && document.elementFromPoint(...at)?.closest("[data-grip]") === grip && at;
};

export const small = (least) => {
  const room = document.querySelector("dialog[open]") ?? document.body;
  return [...room.querySelectorAll("button, input, select, summary")]
    .filter((one) => one.checkVisibility({ visibilityProperty: true }) && !one.closest("svg"))
    .map((one) => [one.id || one.ariaLabel || one.textContent, one.getBoundingClientRect()])
    .filter(([, { width, height }]) => Math.min(width, height) < least).map(([name]) => name);
};

export const numbersOnArrows = () => [...document.querySelectorAll(".velocity-stem, .velocity")].flatMap((line) => {
  const [x1, y1, x2, y2] = ["x1", "y1", "x2", "y2"].map((end) => line[end].baseVal.value);
  const on = Array.from({ length: 101 }, (_, k) => [x1 + (x2 - x1) * k / 100, y1 + (y2 - y1) * k / 100]);
  return [...document.querySelectorAll(".point-number")].filter((number) => {
    const { x, y, width, height } = number.getBBox();
    const isIn = ([px, py]) => px > x && px < x + width && py > y + 2 && py < y + height - 2;
    return getComputedStyle(number).visibility === "visible" && on.some(isIn);
  }).map((number) => number.textContent);
});
