"""Modules that several tests use, in folders by trade; the head of each folder says what each module is for.

- ``models``: independent models, which share no code with the kernel, and their stored answers
- ``scenes``: builders of scenes, most of them with exact answers
- ``literature``: problems with published or measured figures, second solutions and ours
- ``campaigns``: random scenes, and checks that hold for all of them; most modules are also commands
- ``kernel``: the kernel's functions without the package around them
- ``tools``: processes, files, pages and messages

Modules that only one room of the tests uses stand in that room.
"""
