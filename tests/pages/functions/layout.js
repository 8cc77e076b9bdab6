// Functions that tests/pages/test_layout.py runs in a page.

export const clashes = () => {
  const roomOf = (element) => element.closest("dialog form, dialog, footer, #stage, #pins, #status");
  const open = document.querySelector("dialog[open]");
  const isThere = (element) => element.checkVisibility({ visibilityProperty: true, opacityProperty: true }) &&
    !element.closest("svg, .hidden") && (!open || open.contains(element));
  // the visible part of a box, which parts of the page may cut off
  const seen = (element, box) => {
    let { left, top, right, bottom } = box;
    for (let at = element; at; at = at.parentElement) {
      if (getComputedStyle(at).overflow === "visible" || at === document.documentElement) continue;
      const limits = at.getBoundingClientRect();
      [left, top] = [Math.max(left, limits.left), Math.max(top, limits.top)];
      [right, bottom] = [Math.min(right, limits.right), Math.min(bottom, limits.bottom)];
    }
    return { left, top, right, bottom };
  };
  const controls = [...document.querySelectorAll("button, input, select, summary")].filter(isThere)
    .map((element) => ({
      element,
      name: element.ariaLabel || element.textContent || element.id,
      box: seen(element.parentElement, element.getBoundingClientRect()),
    }));
  const texts = [], nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (nodes.nextNode()) {
    const [name, element] = [nodes.currentNode.textContent.trim(), nodes.currentNode.parentElement];
    if (!name || !isThere(element) || element.closest("script, option")) continue;
    const range = document.createRange();
    range.selectNodeContents(nodes.currentNode);
    for (const box of range.getClientRects()) texts.push({ element, name, box: seen(element, box) });
  }
  const shared = (a, b, low, high) => Math.min(a[high], b[high]) - Math.max(a[low], b[low]);
  const meet = (a, b) => shared(a, b, "left", "right") > 0.5 && shared(a, b, "top", "bottom") > 1;
  const clash = (a, b) => !a.element.contains(b.element) && !b.element.contains(a.element) &&
    roomOf(a.element) === roomOf(b.element) && meet(a.box, b.box);
  const others = [...controls, ...texts];
  const clashingPairs = others.flatMap((a, k) =>
    others.slice(k + 1).filter((b) => clash(a, b)).map((b) => `${a.name} on ${b.name}`));
  const wider = document.documentElement.scrollWidth - innerWidth;
  return wider > 0 ? [...clashingPairs, `the page is ${wider} pixels too wide`] : clashingPairs;
};

/** Return pairs of cards that overlap. */
export const overlappingCards = () => {
  const cards = [...document.querySelectorAll("#stage, #parameters, #pins, aside > section")].filter((card) => card.checkVisibility());
  const column = document.querySelector("aside");
  const end = column.scrollHeight > column.clientHeight + 1 ? column.getBoundingClientRect().bottom : Infinity; // of the visible part
  const boxes = cards.map((card) => {
    const { left, right, top, bottom } = card.getBoundingClientRect();
    const name = card.id || card.getAttribute("aria-labelledby");
    return [name, { left, right, top, bottom: card.parentElement === column ? Math.min(bottom, end) : bottom }];
  });
  return boxes.flatMap(([name, a], k) => boxes.slice(k + 1)
    .filter(([, b]) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1)
    .map(([other]) => `${name} on ${other}`));
};

/** Return the cards of the column that are too low for their contents. */
export const overfullCards = () => [...document.querySelectorAll("aside > section")].filter((card) => card.checkVisibility())
  .filter((card) => [...card.children].some((part) =>
    part.checkVisibility() && part.getBoundingClientRect().bottom > card.getBoundingClientRect().bottom + 0.5))
  .map((card) => card.id);

/** Return whether the contents of a card are wider than the card. */
export const isCutOff = (card) => document.getElementById(card).scrollWidth > document.getElementById(card).clientWidth;

/** Return the charts of the column that the list of impacts covers in part. */
export const cutCharts = () => {
  const edge = document.getElementById("list").getBoundingClientRect().top;
  return [...document.querySelectorAll("aside .chart")].filter((chart) => {
    const { top, bottom } = chart.getBoundingClientRect();
    return top < edge && bottom > edge;
  }).map(({ id, className }) => id || className);
};

export const sectionsDownwards = () => {
  const top = (section) => section.getBoundingClientRect().top;
  return [...document.querySelectorAll("main > section, main > aside > section")].filter((section) => section.checkVisibility())
    .sort((card, other) => top(card) - top(other))
    .map((section) => section.id || section.getAttribute("aria-labelledby"));
};
