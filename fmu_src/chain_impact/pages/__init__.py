"""Pages for a browser: one that shows a recording, and one that simulates."""
