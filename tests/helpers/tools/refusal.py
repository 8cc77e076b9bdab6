"""The message of an error that refuses arguments."""

import pytest

from chain_impact.scene.errors import SceneError


def refusal(make, *arguments) -> str:
    """Return the message with which `make(*arguments)` refuses, after a check of its form."""
    with pytest.raises(SceneError) as caught:
        make(*arguments)
    message = str(caught.value)
    assert message.isprintable(), "one line"
    return message
