"""What tables are made of."""

from __future__ import annotations

from collections.abc import Iterable

import common


def table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    """A Markdown table."""
    head = list(head)
    lines = ["| " + " | ".join(map(str, row)) + " |" for row in (head, *rows)]
    return "\n".join([lines[0], "|" + "---|" * len(head), *lines[1:]])


def run(name: str, packages: Iterable[str] = ()) -> str:
    """When and on what a benchmark ran, and with which versions of the packages that matter."""
    record = common.load(name)
    changed = ", with uncommitted changes" if record["sources_changed_since"] else ""
    versions = "".join(f", {key} {record['versions'][key]}" for key in packages if key in record["versions"])
    where = f"{record['machine']['processor']}, {record['machine']['cores']} cores"
    return f"Run {record['date'][:10]} at commit `{record['commit'][:7]}`{changed}; {where}{versions}."
