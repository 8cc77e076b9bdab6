"""What tests share, by what it makes; the first line of each file says more.

Independent models, which share nothing with the kernel:
    textbook, chain_model, body_model, driven_chain, driven, derivatives, complex_laws, reference,
    accumulation, beam, coulomb_impact, housner, walker; kept_answers keeps what takes them long.
Scenes with exact or known answers:
    problems, bodies, friction, stops, folds, turned, derivative_scenes, friction_derivative_scenes,
    derived_scenes, coulomb_problems, coulomb_literature, asked_elsewhere.
Problems of others, with their figures and ours:
    figures, validation, friction_figures, stored, measured, measurements.
Random scenes, and what all of them must keep; each file is also a command:
    random_scenes, search, oracle, load_checks, random_bodies, random_derivatives, resting,
    resting_chains, arches.
Tools:
    plain, stamps, kernel_calls, registers, binaries, processes, forks, shared, reader, page_data, refusal,
    cpu_profile.
"""
