"""The size of a repr."""

LINES, COLUMNS = 8, 120  # the largest size of a repr


def is_short(text):
    lines = text.splitlines()
    return len(lines) <= LINES and max(map(len, lines)) <= COLUMNS
