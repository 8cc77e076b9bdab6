"""animate() for a recording, a result and a scene; tests/results contains the other tests."""

from chain_impact import Recording, animate, record_slowly, simulate


def page(source, folder):
    animate(source, folder / "ball.html", impact_time=0.0)
    return (folder / "ball.html").read_bytes()


def test_a_result_gives_the_page_of_its_own_method(tmp_path):
    result = simulate("bouncing_ball", 0.5)
    content = page(result, tmp_path)
    result.animate(tmp_path / "ball.html", impact_time=0.0)
    assert content == (tmp_path / "ball.html").read_bytes()


def test_a_scene_gives_the_page_of_its_slow_recording(tmp_path):
    recording = record_slowly("bouncing_ball", 0.0)
    assert isinstance(recording, Recording)
    assert page(recording, tmp_path) == page("bouncing_ball", tmp_path)
