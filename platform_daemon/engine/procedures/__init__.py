"""Work of several jobs: each step is submitted to the engine like anybody else would.

diagnose: The loop: measure, diagnose, run the next measurement that the diagnosis proposes, diagnose all shots
    together.
"""
