"""Independent models: they share no code with the kernel.

Chains:
- ``textbook``: an assembled mass matrix, no recursion; ``driven_chain`` adds drives in the joints
- ``lagrange``: Lagrange's equations by SymPy, for a few links
- ``derivatives``: motions through impacts and their derivatives, by complex step, of the chain that
  ``chain_model``, ``chain_parts``, ``chain_friction`` and ``complex_laws`` describe
- ``body_model``: the same with offsets of centres of mass, points of links, and sliders
- ``kept_answers``: a file for each answer that takes seconds; its command computes all of them again

Small models, each in its own equations:
- ``reference``: closed forms and plain algebra: mass matrix, clearances, impacts, damping factors
- ``driven``: driven arms and bases; ``accumulation``: impacts whose times accumulate
- ``beam``: a beam as a sum of modes; ``housner``: a rocking block
- ``coulomb_impact``: an impact of one point with Coulomb friction
"""
