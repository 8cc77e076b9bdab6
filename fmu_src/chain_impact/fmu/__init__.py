"""FMUs: the build of a file that other tools import from a scene, and the run of such a file."""
