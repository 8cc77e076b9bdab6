"""resources/model.bin with a checksum that is right and numbers that are not: refused, or of no harm."""


def fates_of_tables(fmu):
    """What becomes of mutants, with all that broken_tables.py has."""
    return fates(fmu)  # noqa: F821


def test_no_number_in_the_table_does_harm(native, clean):
    found, sizes = clean(fates_of_tables, native["rod_drop"], module="broken_tables")
    assert found.pop("none") == 0
    assert not {what: code for what, code in found.items() if code not in (0, 1)}
    assert all(code == 1 for what, code in found.items() if what.startswith(tuple(sizes)))
    assert sum(found.values()) > len(found) // 4
