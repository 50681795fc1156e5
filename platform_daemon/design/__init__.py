"""Design equations of a resonator, and statics of its manufacturing defects."""
