"""Files with a user's own contact law: they are read and checked, but not run."""
