"""Files with a user's own contact law: this package reads and checks them, but never runs them."""
