"""What happens at a moment: the search for it, impulses, release, and the log of contacts."""
