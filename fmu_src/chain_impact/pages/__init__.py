"""Pages for a browser: a page that shows a recording, and a page that simulates."""
