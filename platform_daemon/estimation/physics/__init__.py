"""The equation of motion of a resonator and what follows from it; torques/ are its terms, trajectory/ its exact
solutions."""
