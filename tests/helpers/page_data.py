"""What a page of an animation, or one that simulates, was made of."""

import json
import re


def data_of(text):
    """The data in the text of a page."""
    return json.loads(re.search(r'<script id="data"[^>]*>(.*?)</script>', text, re.DOTALL)[1])
