"""Names in plain words, for titles of pictures."""

import pytest

from chain_impact.scene.texts.plain_names import plain_name


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("contact.restitution", "restitution"),
        ("contact.static_friction", "static friction"),
        ("contact.model", "contact law"),
        ("stop.stiffness", "stop stiffness"),
        ("link[2].mass", "link 2 mass"),
        ("initial.angular_velocity[3]", "link 3 initial angular velocity"),
        ("initial.vx", "initial vx"),
        ("gravity.y", "gravity y"),
        ("energy.total", "total energy"),
        ("wall.floor.friction", "wall.floor.friction"),
    ],
)
def test_names_have_plain_words(name, words):
    assert plain_name(name) == words
