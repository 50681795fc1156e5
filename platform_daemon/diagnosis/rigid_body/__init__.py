"""Does the motion leave its plane, and which manufacturing error of a rotor with five degrees of freedom explains it."""
