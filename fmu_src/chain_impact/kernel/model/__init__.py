"""The equations of motion: geometry and force of contact, constraints of rigid walls."""
