"""Whole motions, by what moves and what is compared.

Contacts and events:

- ``test_impacts``: force laws and rigid walls; ``test_impact_oscillator``: a mass on a driven spring
- ``test_grazes``: slight and almost contacts, in the motions of ``grazes``; ``test_faults``: hard searches
- ``test_walls``: walls at any angle; ``test_wall_at_base``: a wall that reaches the base
- ``test_friction``: dry friction; ``test_friction_studies``: studies of it
- ``test_arches``: dry friction with dependent constraints; ``test_folds``: held chains that fold
- ``test_law_file``: a user's own law

Rest, by what rests:

- ``test_rest``: one given chain, its cost and its release; ``test_rest_of_bodies``: balls and rods
- ``test_resting``: random scenes; ``test_resting_chains``: where thrown chains come to lie

Parts of a chain:

- ``test_joints``: springs, dampers and stops; ``test_joint_drives``: servos and limits of torque;
  ``test_armatures``: armatures; ``test_sliders``: sliding bases; ``test_point_masses``: massless rods
- ``test_bodies``: bodies and points against closed forms, with ``changed_scenes``; ``test_body_models``: the
  models of them; ``test_body_motions``: against an independent model; ``test_recorded_bodies``: recordings
- ``test_motion``: a moving base and walls; ``test_followed_motion``: motions by samples or functions;
  ``test_motion_search``: random ones; ``test_driven_models``: the models of them

Single models:

- ``test_models``: the references of all; ``test_kneed_leg``: the knee strike
- ``test_carried_arm``, ``test_cart_pole``, ``test_controlled_arm``: co-simulations
- ``test_measured``: measured motions; ``test_validation``: problems from the literature

All scenes:

- ``test_conservation``: energy and momenta; ``test_certificate``: bounds of single steps
- ``test_random_scenes``, ``test_random_bodies``, ``test_random_derivatives``: random searches
- ``test_rough_tolerances``: the cost of a tighter tolerance
- ``test_derivatives``: derivatives through impacts; ``test_derivative_limits``: where they end;
  ``test_derived_values``: each way to change a value
- ``test_runs``: a scene and its FMU; ``test_python_use``: help, copies, pickles and reprs
"""
