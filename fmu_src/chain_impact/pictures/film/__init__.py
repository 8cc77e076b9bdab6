"""Films: the figure with chain, arrows of forces, charts and caption, and the files."""
