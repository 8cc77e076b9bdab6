"""The tests of pages: a package, so that pytest ends the browser of their fixtures with the last of them."""
