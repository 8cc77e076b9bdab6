"""What a reader searches for in the docs leads to the page that explains it."""

import math
import re
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"
WEIGHTS = {"title": 8.0, "heading": 4.0}  # of a word there, over one in the text
SATURATED = (
    1.2  # occurrences in a text after which another one adds less than half (BM25, Robertson & Walker 1994)
)
FIRST = 3  # pages that a reader looks at


def sections(page):
    """Yield the sections of a page as title of the page, heading and text; blocks of code are no text."""
    text = re.sub(
        r"^```.*?^```$|<!--.*?-->|\]\([^)]*\)", " ", page.read_text(encoding="utf-8"), flags=re.M | re.S
    )
    parts = re.split(r"^#+ (.*)$", text, flags=re.M)
    for heading, body in zip(parts[1::2], parts[2::2], strict=True):
        yield {"title": parts[1], "heading": heading, "text": body}


def occurrences(word, text):
    """How often words of a text begin with a word, as a search counts what is typed."""
    return len(re.findall(rf"\b{re.escape(word)}", text, re.IGNORECASE))


@pytest.fixture(scope="module")
def pages():
    """Return page → its sections."""
    found = {str(page.relative_to(DOCS)): list(sections(page)) for page in DOCS.rglob("*.md")}
    return {name: all_ for name, all_ in found.items() if all_}


def ranked(pages, query):
    """Return the pages with all words of a query in a section, the best section first."""
    words = query.split()
    everything = [section for all_ in pages.values() for section in all_]
    rarity = {}
    for word in words:
        count = sum(any(occurrences(word, part) for part in section.values()) for section in everything)
        rarity[word] = math.log(1.0 + len(everything) / max(count, 1))

    def score(section):
        found = 0.0
        for word in words:
            counts = {part: occurrences(word, text) for part, text in section.items()}
            if not any(counts.values()):
                return 0.0
            own = sum(WEIGHTS[part] * (counts[part] > 0) for part in WEIGHTS)
            found += rarity[word] * (own + counts["text"] / (counts["text"] + SATURATED))
        return found

    best = {name: max(map(score, all_)) for name, all_ in pages.items()}
    return [name for name in sorted(best, key=lambda name: -best[name]) if best[name] > 0.0]


@pytest.mark.parametrize(
    ("query", "page"),
    [
        ("peak force", "sensitivities.md"),
        ("joint load", "mount.md"),
        ("material", "material.md"),
        ("ranking", "sensitivities.md"),
        ("signal", "drive.md"),
        ("cart", "models/cart_pole.md"),
        ("brick", "models/thrown_brick.md"),
        ("foot", "models/hopper.md"),
    ],
)
def test_a_search_leads_to_its_page(pages, query, page):
    assert page in ranked(pages, query)[:FIRST]
