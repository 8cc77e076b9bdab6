"""The chain by itself: its recursion in O(N), where its points are, and the sines that both need."""
