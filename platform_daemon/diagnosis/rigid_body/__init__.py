"""Does the motion leave its plane, and which manufacturing error of a rigid rotor explains that it does."""
