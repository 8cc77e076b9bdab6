"""What tables are made of."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping

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


def fill(page: str, functions: Mapping[str, Callable[[], str]]) -> None:
    """Put what each function returns between ``<!-- name -->`` and ``<!-- end -->`` in a page of the docs."""
    path = common.ROOT / "docs" / page
    text = re.sub(
        r"<!-- (?!end )(\w+) -->\n.*?<!-- end -->",
        lambda found: f"<!-- {found[1]} -->\n\n{functions[found[1]]()}\n\n<!-- end -->",
        path.read_text(encoding="utf-8"),
        flags=re.DOTALL,
    )
    path.write_text(text, encoding="utf-8")
    print(f"filled {path.relative_to(common.ROOT)}")
