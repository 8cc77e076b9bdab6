"""Forces on the chain: contact laws, contacts, dry friction, and the forces of constraints."""
