"""Many runs of a scene: every contact law side by side."""
