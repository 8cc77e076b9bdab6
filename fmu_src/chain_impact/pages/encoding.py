"""The encoding of bytes as text, for pages."""

import base64


def base64_text(content: bytes) -> str:
    """Return bytes in base64."""
    return base64.b64encode(content).decode("ascii")
