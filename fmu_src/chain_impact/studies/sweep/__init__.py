"""Many runs of one scene, each with different values of some parameters."""
