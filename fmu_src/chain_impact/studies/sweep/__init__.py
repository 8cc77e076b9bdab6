"""Many runs of one scene, each with other values of some parameters."""
