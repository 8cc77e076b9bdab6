// Tabs: a list of buttons, of which one is chosen; the part of the page that it names is shown, and the parts of the others are hidden.

import { byId } from "./dom.js";

/** Let the tabs of a list choose their parts, by a click or the arrow keys; `onChoose` is called with the chosen tab. */
export function connectTabs(list, onChoose = () => {}) {
  const tabs = [...list.children];
  const choose = (chosen) => {
    tabs.forEach((tab) => {
      tab.setAttribute("aria-selected", tab === chosen);
      tab.tabIndex = tab === chosen ? 0 : -1;
      byId(tab.getAttribute("aria-controls")).hidden = tab !== chosen;
    });
    onChoose(chosen);
  };
  list.addEventListener("click", ({ target }) => tabs.includes(target) && choose(target));
  list.addEventListener("keydown", (event) => {
    const way = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!way) return;
    event.preventDefault();
    const next = tabs[(tabs.indexOf(document.activeElement) + way + tabs.length) % tabs.length];
    next.focus();
    choose(next);
  });
}
