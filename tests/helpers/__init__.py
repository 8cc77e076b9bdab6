"""Modules that several tests use, in folders by trade; the head of each folder says what each module is for.

- ``models``: independent models, which share no code with the kernel, and their stored answers
- ``scenes``: builders of scenes, most of them with exact answers
- ``literature``: problems with published or measured figures, second solutions and ours
- ``campaigns``: random scenes, and checks that hold for all of them; some modules are also commands
- ``kernel``: the kernel's functions without the package around them
- ``tools``: processes, files, pages and messages

Which helper:

- a scene in one line: ``scenes.problems.build``; scenes with exact answers: the rest of that module
- the record of a scene, for functions of the kernel in plain Python: ``kernel.plain``
- a second computation of a motion: ``models.textbook`` (any chain), ``models.body_model`` (offsets, points,
  sliders), ``models.driven_chain`` (drives), ``models.derivatives`` (derivatives through impacts)
- any random scene: ``campaigns.random_scenes.scene``; its checks: ``campaigns.oracle``
- a published or measured figure: ``literature.validation``
- the message of an error: ``tools.refusal``; a derivative by central differences: ``tools.differences``

Modules that only one room of the tests uses stand in that room.
"""
