"""The data inside a page with an animation, or a page that simulates."""

import json
import re


def data_of(text):
    """Return the data in the text of a page."""
    return json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.DOTALL)[1])
