"""Instances of dual numbers after an instance in memory: together they carry all requested directions.

The compiled versions of these functions are in compilation/record_type.py.
"""

from chain_impact.kernel.record.fields import GIVEN


def block(d, number):
    """Tangent instance ``number`` of d, from 0."""
    return d.tangent_instances[number]


def words(record):
    """All numbers of a record, each with its derivatives after it."""
    return record.words


def copy_values(source, target):
    """Give a part of an instance of dual numbers the values of that part of the instance.

    Derivatives stay unchanged. All fields are copied, also those of nested records, so a parameter that is
    added to the record needs no change here.
    """
    target.copy_values(source)


def copy_given(d, t, when):
    """Give t the values of all parts of d that the scene or an importer gives and that apply then.

    ``when`` is a constant: AT_START or AT_ANY_TIME, as it stands beside the layout of each part.
    """
    for part, applies in GIVEN.items():
        if applies == when:
            copy_values(getattr(d, part), getattr(t, part))
