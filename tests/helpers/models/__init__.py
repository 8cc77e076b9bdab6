"""Independent models: they share no code with the kernel.

Chains:
- ``textbook``: an assembled mass matrix, no recursion; ``driven_chain`` adds drives in the joints
- ``lagrange``: Lagrange's equations by SymPy, for a few links
- ``derivatives``: motions through impacts and their derivatives, by complex step, of the chain that
  ``chain_model``, ``chain_parts``, ``chain_friction`` and ``complex_laws`` describe
- ``body_model``: the same with offsets of centres of mass, points of links, and sliders
- ``kept_answers``: a file for each answer that takes seconds; its command computes all of them again

The parts of each chain; the module of derivatives runs the last two chains:

    ================================= ======== ============ ======== =========== ==========
    part                              textbook driven chain lagrange chain model body model
    ================================= ======== ============ ======== =========== ==========
    springs, dampers, given torques   yes      yes          yes      yes         yes
    forces on points                  yes      –            yes      tip         –
    offset of a centre of mass        yes      yes          –        –           yes
    targets of joints                 –        yes          –        yes         yes
    armatures, limits of torques      –        yes          –        –           yes
    walls, stops, friction, signals   –        –            –        yes         yes
    derivatives by parameters         –        –            –        yes         yes
    points of links, sliding base     –        –            –        –           yes
    ================================= ======== ============ ======== =========== ==========

Walls and bases that move are among the driven models below.

Small models, each in its own equations:
- ``reference``: closed forms and plain algebra: mass matrix, clearances, impacts, damping factors
- ``driven``: shaken and carried arms, a ball on a moving table, a belt
- ``accumulation``: impacts whose times accumulate
- ``beam``: a beam as a sum of modes; ``housner``: a rocking block
- ``coulomb_impact``: an impact of one point with Coulomb friction
"""
