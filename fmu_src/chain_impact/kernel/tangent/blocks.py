"""Instances of dual numbers behind an instance in memory: together they carry all directions asked for."""


def block(d, number):
    """One of those behind d, by its number from 0. Compiled, it is that of compilation/record_type.py."""
    return d.beside[number]


def words(record):
    """All numbers of a record, with their derivatives behind each. Compiled, likewise."""
    return record.words


def copy_values(source, target):
    """Give a part of an instance of dual numbers the values of that part of the instance.

    Derivatives stay as they are. All fields are copied, also those of records within, so a parameter that is
    added to the record needs nothing here. Compiled, likewise.
    """
    target.copy_values(source)
