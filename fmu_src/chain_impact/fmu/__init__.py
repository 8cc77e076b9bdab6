"""FMUs: from a scene to a file that other tools import, and the run of such a file."""
