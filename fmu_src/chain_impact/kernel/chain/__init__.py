"""The chain without contacts: the O(N) recursion, the kinematics, and the sines and cosines that both use."""
