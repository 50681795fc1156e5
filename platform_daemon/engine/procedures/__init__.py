"""Work of several jobs: each step is submitted to the engine like anybody else would.

diagnose: The loop: measure, diagnose, run the next measurement that the diagnosis proposes, diagnose all shots
    together.
procedure: What a procedure is: steps one after another, each decided from the reports of those before it; who makes
    steps, and who fits them.
conductor: The job of a procedure: makes its steps, repeats refused shots, rests when asked to, keeps the log, and
    puts the one recording together whatever happens.
engine_steps: Steps made by an engine in this process, by its public `submit`.
step_series: The one recording of a procedure.
step_report: What a step has brought, from the jobs that made it.
sweep: A sweep: the same acquisition with other values of some keys, all combinations, until a rule ends it.
sweep_keys: The keys that a sweep may go over, and the names that people use for them.
ramp: The field is raised until side modes show in the z channel.
computed_side_modes: The z channel of its shots, looked at by whoever computes for the engine.
kept_limits: What a ramp has found, kept with the specimen.
tune: From the design's natural frequency to the measured one, and to the sequence that suits the resonator.
tune_shots: What one shot of it tells.
tune_numbers: What it computes.
stop_rule: When a procedure ends early: a rule on a result of its last step.
characterise: Characterise: many shots of one resonator, and the paper's tables from its recording.
planned: From a request to the work of its procedure.
"""
