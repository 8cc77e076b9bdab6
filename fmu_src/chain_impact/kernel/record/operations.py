"""Operations on parts of the record; in compiled code they are those of compilation/built_in.py."""


def clear_numbers(part):
    """Set all numbers of a part of the record, also those of its subparts, to zero."""
    part.clear()


def copy_row(table, source, row):
    """Copy all columns of row ``source`` of a table of the record to the row with the index ``row``."""
    table[row] = table[source]
