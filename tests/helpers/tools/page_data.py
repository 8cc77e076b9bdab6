"""The data inside a page with an animation, or a page that simulates."""

import base64
import json
import re
import zlib


def data_of(text):
    """Return the data in the text of a page, which a page that simulates has compressed."""
    kind, data = re.search(r'<script id="data" type="([^"]*)">(.*?)</script>', text, re.DOTALL).groups()
    return json.loads(data if "json" in kind else zlib.decompress(base64.b64decode(data), -zlib.MAX_WBITS))
