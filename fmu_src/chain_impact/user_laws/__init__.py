"""Files with a user's own contact law: the modules of this folder read and check them, but run none."""
