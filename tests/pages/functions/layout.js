// Functions that tests/pages/test_layout.py runs in a page.

export const clashes = () => {
  const roomOf = (one) => one.closest("dialog form, dialog, footer, #stage, #pins, #status");
  const open = document.querySelector("dialog[open]");
  const isThere = (one) => one.checkVisibility({ visibilityProperty: true, opacityProperty: true }) &&
    !one.closest("svg, .hidden") && (!open || open.contains(one));
  // what is seen of a box within the parts of the page that cut it off
  const seen = (one, box) => {
    let { left, top, right, bottom } = box;
    for (let at = one; at; at = at.parentElement) {
      if (getComputedStyle(at).overflow === "visible" || at === document.documentElement) continue;
      const limits = at.getBoundingClientRect();
      [left, top] = [Math.max(left, limits.left), Math.max(top, limits.top)];
      [right, bottom] = [Math.min(right, limits.right), Math.min(bottom, limits.bottom)];
    }
    return { left, top, right, bottom };
  };
  const controls = [...document.querySelectorAll("button, input, select, summary")].filter(isThere)
    .map((one) => ({
      one,
      name: one.ariaLabel || one.textContent || one.id,
      box: seen(one.parentElement, one.getBoundingClientRect()),
    }));
  const texts = [], nodes = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  while (nodes.nextNode()) {
    const [name, one] = [nodes.currentNode.textContent.trim(), nodes.currentNode.parentElement];
    if (!name || !isThere(one) || one.closest("script, option")) continue;
    const range = document.createRange();
    range.selectNodeContents(nodes.currentNode);
    for (const box of range.getClientRects()) texts.push({ one, name, box: seen(one, box) });
  }
  const shared = (a, b, low, high) => Math.min(a[high], b[high]) - Math.max(a[low], b[low]);
  const meet = (a, b) => shared(a, b, "left", "right") > 0.5 && shared(a, b, "top", "bottom") > 1;
  const clash = (a, b) => !a.one.contains(b.one) && !b.one.contains(a.one) &&
    roomOf(a.one) === roomOf(b.one) && meet(a.box, b.box);
  const others = [...controls, ...texts];
  const found = others.flatMap((a, k) =>
    others.slice(k + 1).filter((b) => clash(a, b)).map((b) => `${a.name} on ${b.name}`));
  const wider = document.documentElement.scrollWidth - innerWidth;
  return wider > 0 ? [...found, `the page is ${wider} pixels too wide`] : found;
};

/** Return pairs of cards of the page that lie on one another. */
export const overlappingCards = () => {
  const cards = [...document.querySelectorAll("#stage, #parameters, #pins, aside > section")].filter((card) => card.checkVisibility());
  const column = document.querySelector("aside");
  const end = column.scrollHeight > column.clientHeight + 1 ? column.getBoundingClientRect().bottom : Infinity; // of what is seen
  const boxes = cards.map((card) => {
    const { left, right, top, bottom } = card.getBoundingClientRect();
    const name = card.id || card.getAttribute("aria-labelledby");
    return [name, { left, right, top, bottom: card.parentElement === column ? Math.min(bottom, end) : bottom }];
  });
  return boxes.flatMap(([name, a], k) => boxes.slice(k + 1)
    .filter(([, b]) => a.left < b.right - 1 && b.left < a.right - 1 && a.top < b.bottom - 1 && b.top < a.bottom - 1)
    .map(([other]) => `${name} on ${other}`));
};

/** Return the cards of the column that are lower than what they contain. */
export const overfullCards = () => [...document.querySelectorAll("aside > section")].filter((card) => card.checkVisibility())
  .filter((card) => [...card.children].some((part) =>
    part.checkVisibility() && part.getBoundingClientRect().bottom > card.getBoundingClientRect().bottom + 0.5))
  .map((card) => card.id);

/** Return whether a table needs more width than the card has in which it is. */
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
    .sort((one, other) => top(one) - top(other))
    .map((section) => section.id || section.getAttribute("aria-labelledby"));
};
