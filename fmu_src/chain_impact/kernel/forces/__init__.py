"""Forces: contact laws, contacts, dry friction, inputs, and the forces of constraints."""
