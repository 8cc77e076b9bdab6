"""No label overlaps a control on small screens, by the drawn boxes."""

# Tests: pages/explore.py

import pytest

from tests.pages.in_pages import ON_ITS_SIDE, PHONE, until
from tests.tiers import needs_browser

pytestmark = needs_browser
SIZES = [{"width": 360, "height": 800}, PHONE, ON_ITS_SIDE, {"width": 768, "height": 1024}]
SCENES = {
    "pinned_arm": {"inputs.joint_targets": True, "outputs.loads": True},
    "bouncing_table": {"simulation.stop_time": 0.3},
}
DIALOGS = ("edit", "map", "curves", "export", "help")
CLASHES = """() => {
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
  return wider > 0 ? [...found, `the page is ${wider} pixels too wide`] : found; }"""
"""Overlapping pairs of controls and texts among elements that scroll together."""


@pytest.mark.parametrize("model", SCENES)
def test_no_label_runs_into_a_control(show, model):
    page = show(model, SCENES[model], viewport=SIZES[0], has_touch=True)
    page.evaluate("location.hash = '#curves=point[*].*y,impact.count&gravity.y=-9.5'")
    until(page, "document.querySelectorAll('#outputs-over-time dt').length > 5")
    page.evaluate("document.querySelector('summary').click(), document.getElementById('pin').click()")
    for size in SIZES:
        page.set_viewport_size(size)
        assert page.evaluate(CLASHES) == [], size
        for name in DIALOGS:
            page.evaluate(f"document.getElementById('{name}-open').click()")
            assert page.evaluate(CLASHES) == [], (size, name)
            page.keyboard.press("Escape")
    page.add_style_tag(content=".main-parameter-label { white-space: nowrap; font-size: 50px; }")
    assert any("contact.stiffness" in one for one in page.evaluate(CLASHES)), (
        "what runs into a control is found"
    )
