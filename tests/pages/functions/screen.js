// Functions that tests/pages/test_screen.py runs in a page.

export const reachable = (name) => {
  const grip = document.querySelector(`[data-grip="${name}"]`), box = grip?.getBoundingClientRect();
  const at = box && [box.x + box.width / 2, box.y + box.height / 2];
  return at && document.elementFromPoint(...at)?.closest("[data-grip]") === grip && at;
};

export const smallControls = (least) => {
  const room = document.querySelector("dialog[open]") ?? document.body;
  return [...room.querySelectorAll("button, input, select, summary")]
    .filter((element) => element.checkVisibility({ visibilityProperty: true }) && !element.closest("svg"))
    .map((element) => [element.id || element.ariaLabel || element.textContent, element.getBoundingClientRect()])
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

export const wallGripsOnOthers = () => {
  const scene = document.querySelector("#scene").getBoundingClientRect();
  const kinds = ".point-number, .ruler-text, .ruler-name, .bar-text, polyline.bar, .joint-ring, .velocity-tip";
  const others = [...document.querySelectorAll(kinds)].filter((element) => getComputedStyle(element).visibility === "visible")
    .map((element) => [element.textContent || element.classList[0], element.getBoundingClientRect()]);
  const links = [...document.querySelectorAll("polyline.link")].flatMap((link) => [...link.points].slice(1).flatMap((to, k) =>
    Array.from({ length: 101 }, (_, part) => [0, 1].map((axis) => {
      const [from, end] = [link.points[k], to].map(({ x, y }) => (axis ? y + scene.top : x + scene.left));
      return from + ((end - from) * part) / 100;
    }))));
  return [...document.querySelectorAll(".wall-grip")].flatMap((grip) => {
    const { left, right, top, bottom } = grip.getBoundingClientRect();
    const isCut = left < scene.left || right > scene.right || top < scene.top || bottom > scene.bottom;
    const below = others.filter(([, box]) =>
      box.left < right - 1 && box.right > left + 1 && box.top < bottom - 3 && box.bottom > top + 3).map(([name]) => name);
    const isOnLink = links.some(([x, y]) => x > left && x < right && y > top && y < bottom);
    return [...below, ...(isCut ? ["an edge"] : []), ...(isOnLink ? ["a link"] : [])];
  });
};
