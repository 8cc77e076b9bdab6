"""Several instances of dual numbers, one after the other: together they carry all directions asked for."""


def block(first, number):
    """One of them, by its number from 0. Compiled, it is that of compilation/record_type.py."""
    return first[number]


def words(record):
    """All numbers of a record, with their derivatives behind each. Compiled, likewise."""
    return record.words
