"""Instances of dual numbers after an instance in memory: together they carry all requested directions."""


def block(d, number):
    """Tangent instance ``number`` of d, from 0; for the compiled kernel see compilation/record_type.py."""
    return d.tangent_instances[number]


def words(record):
    """All numbers of a record, each with its derivatives after it; compiled: as for ``block``."""
    return record.words


def copy_values(source, target):
    """Give a part of an instance of dual numbers the values of that part of the instance.

    Derivatives stay unchanged. All fields are copied, also those of nested records, so a parameter that is
    added to the record needs no change here. The compiled version is also in compilation/record_type.py.
    """
    target.copy_values(source)
