"""The list of impacts of a page."""

from chain_impact.results.page.recorded import PLAYER, program
from tests.tiers import needs_browser

pytestmark = needs_browser
LIST = """(count) => {
  const impact = (k) => ({ onset: k / count, point: 1, wall: "y_min", speed: 1, peak: 2 });
  const element = document.body.appendChild(document.createElement("div"));
  new ImpactList(element, () => {}).show({ impacts: Array.from({ length: count }, (_, k) => impact(k)) });
  return [element.querySelectorAll("tbody tr").length, element.lastChild.textContent];
}"""


def test_a_long_list_ends_with_how_many_more_there_are(browser):
    page = browser.new_page()
    page.set_content(f"<script>{program(PLAYER)}</script>")
    assert page.evaluate(LIST, 2345) == [2000, "and 345 more, which the animation shows"]
    rows, table = page.evaluate(LIST, 2000)
    assert rows == 2000
    assert "more" not in table
    page.close()
