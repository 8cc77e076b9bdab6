"""The chain without contacts: O(N) recursions, kinematics, joints, slider, sites, motions and signals."""
