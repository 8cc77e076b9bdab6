"""Builders of scenes.

- ``problems``: scenes with exact answers, and the short builders that most tests use
- ``bodies``, ``friction``, ``stops``, ``joint_drives``, ``moving_scenes``: small scenes of one feature
- ``coulomb_problems``: scenes with Coulomb friction that have exact answers
- ``derivative_scenes``, ``friction_derivative_scenes``: scenes whose derivatives are known
- ``derived_scenes``: a scene with given and derived values
- ``variable_scenes``: scenes with all kinds of FMU variables
- ``signal_arm``: an arm with signals; ``law_texts``: files of contact laws
- ``model_files``: tables in the folders of models
- ``turned``: any scene, mirrored or rotated
"""
