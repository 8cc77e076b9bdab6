"""The panel of the motion: poses, bodies, walls, joint forces, and impacts as rings."""
