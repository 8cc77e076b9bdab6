"""Modules that several tests use, by purpose; the first line of each file says more.

Independent models, which share no code with the kernel:
    textbook, chain_model, chain_parts, chain_friction, body_model, driven_chain, driven, derivatives,
    complex_laws, reference, accumulation, beam, coulomb_impact, housner, walker; kept_answers stores answers
    that take long.
Scenes with exact or known answers:
    problems, bodies, friction, stops, folds, turned, moving_scenes, joint_drives, variable_scenes,
    derivative_scenes, friction_derivative_scenes, derived_scenes, coulomb_problems, coulomb_literature,
    asked_elsewhere.
Problems from the literature, with published figures and ours:
    figures, validation, friction_figures, stored, measured, measurements.
Random scenes, and checks that hold for all of them; each file is also a command:
    random_scenes, random_parts, search, oracle, oracle_energy, oracle_friction, load_checks, random_bodies,
    random_derivatives, resting, resting_chains, arches.
Tools:
    plain, stamps, kernel_calls, own_functions, registers, binaries, processes, forks, shared, reader,
    page_data, refusal, cpu_profile.
"""
