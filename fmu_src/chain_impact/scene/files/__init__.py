"""Files on disk: scene files and their lines, the models of the package, tables of numbers."""
