"""Processes, files, pages and messages.

- ``processes``: processes that have already imported a module; ``forks`` is their program, ``reader`` their
  task for the docs
- ``shared``: files that all workers of a session share; ``sources``: whether the sources are installed
- ``binaries``: symbols and libraries of a shared library; ``registers``: floating-point registers;
  ``processors``: marks of tests that need a processor
- ``text_layouts``, ``tick_layouts``: layouts of texts, and ticks of axes, which are computed once
- ``page_data``: the data inside a page; ``refusal``: the message of an error; ``reprs``: the size of a repr
- ``measurements``: results with noise, as measurements for fits
- ``planted_faults``: faults of FMUs, and FMUs that contain them
- ``fakes``: fakes of the package's functions, which take what the functions take
- ``differences``: derivatives by central differences
- ``zig``: the project's C compiler for test programs
- ``cpu_profile``: a plug-in for pytest that prints CPU seconds of each test
"""
