"""The chain without contacts: its O(N) recursion, its kinematics, and the sines that both need."""
