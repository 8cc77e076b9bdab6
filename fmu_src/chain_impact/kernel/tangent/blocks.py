"""Instances of dual numbers behind an instance in memory: together they carry all directions asked for."""


def block(d, number):
    """One of those behind d, by its number from 0. Compiled, it is that of compilation/record_type.py."""
    return d.beside[number]


def words(record):
    """All numbers of a record, with their derivatives behind each. Compiled, likewise."""
    return record.words
