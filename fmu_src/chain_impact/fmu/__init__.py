"""FMUs: a scene becomes a file that other tools import; and such a file is run."""
