"""Random scenes, and checks that hold for all of them.

The random search:
- ``search``: runs scenes in processes with a time limit, and judges them (a command)
- ``random_scenes``: the scene of each seed; ``random_parts``: its parts, and random numbers for all campaigns
- ``oracle``: the checks; ``oracle_energy``, ``oracle_friction`` and ``load_checks`` are parts of it
- ``folds``: the limits of Newton's law for folds

Campaigns with scenes of their own; each is a command, except the module with scenes of bodies:
- ``random_bodies``: bodies, boxes and sliders
- ``random_derivatives``: derivatives against differences; ``body_derivatives``: its scenes of bodies
- ``resting``: scenes that come to rest; ``resting_chains``: derivatives of the places where chains rest
- ``arches``: chains whose sticking elements depend on each other
"""
