"""Problems with figures of others: published or measured values, second solutions, and ours.

- ``figures``: what a problem and a figure are
- ``validation``: the list of all problems, which docs/validation.md shows, and most of these problems
- ``friction_figures``: problems with dry friction; ``coulomb_literature`` has their scenes
- ``measured``: measured motions; ``stored``: values of other programs; ``walker``: a walker with knees
- ``validation_table``, ``beside_measurements``: the table and the pictures of the docs
- ``asked_elsewhere``: questions from public threads about other programs
"""
