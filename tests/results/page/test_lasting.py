"""What lasts: memory after many runs, a map that is closed, a motion that takes long."""

from tests.tiers import needs_browser

pytestmark = needs_browser
THOUSAND = """async () => {
  const output = ["point[4].x"];
  const values = (k) => ({ "contact.restitution": 0.3 + k / 2000, "simulation.stop_time": 0.6 });
  const run = (k) => chainImpact.simulate(values(k), { output });
  const whole = async (from, to) => { for (let k = from; k < to; k += 1) await run(k % 1000); };
  const size = () => { gc(); gc(); return performance.memory.usedJSHeapSize; };
  await whole(0, 100);
  const first = (await run(500)).columns["point[4].x"].at(-1);
  const before = size();
  await whole(0, 1000);
  const after = size();
  const held = Array.from({ length: 100 }, () => new Array(10000).fill(0.5));
  return [before, after, size(), first === (await run(500)).columns["point[4].x"].at(-1), held.length];
}"""


def test_a_thousand_runs_leave_the_memory_as_it_was(show):
    page = show()
    before, after, holding, same, _ = page.evaluate(THOUSAND)
    assert same
    assert after - before < 1e6
    assert holding - after > 5e6  # this is how 8 MB would be seen


def test_a_map_that_is_closed_stops(show):
    page = show(hash_="#simulation.stop_time=400")
    page.get_by_role("button", name="Map…").click()
    page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.wait_for_function("document.getElementById('map-text').textContent.includes('of 41 rows')")
    assert len(page.workers) > 1
    page.keyboard.press("Escape")
    page.wait_for_function("document.getElementById('map-text').textContent.startsWith('Stopped after')")
    while len(page.workers) > 1:  # but that of the motion, they end
        page.wait_for_timeout(50)


def test_another_map_takes_the_place_of_one_that_is_not_complete(show):
    page = show(hash_="#simulation.stop_time=0.3")
    page.get_by_role("button", name="Map…").click()
    for output in ("impact.last_time", "impact.count"):
        page.get_by_label("Colour").select_option(output)
        page.get_by_role("button", name="Simulate 41 × 41 runs").click()
    page.locator("#map-text").get_by_text("1681 runs in").wait_for()
    page.locator("#map-canvas").hover()
    page.wait_for_function("document.getElementById('map-text').textContent.includes('impact.count = ')")


def test_a_long_run_does_not_freeze_the_page_and_gives_way_to_the_next(show):
    page = show()
    page.evaluate("chainImpact.show({'simulation.stop_time': 100000, 'contact.model': 'newton_impact'})")
    page.wait_for_function("document.body.classList.contains('computing')")
    frames = page.evaluate("""() => new Promise((done) => {
      const began = performance.now(); let longest = 0, before = began;
      const tick = (now) => { longest = Math.max(longest, now - before); before = now;
        if (now - began > 600) done(longest); else requestAnimationFrame(tick); };
      requestAnimationFrame(tick); })""")
    assert frames < 400  # ms, on a machine that does other work, too
    page.get_by_role("button", name="Reset all").click()
    page.wait_for_function("!document.body.classList.contains('computing')")
    page.wait_for_function("document.getElementById('subtitle').textContent.includes('14 impacts in 2 s')")
