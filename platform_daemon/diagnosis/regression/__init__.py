"""The regression of many shots on effects.

cross_validation: Prediction of data that were not used: the proof of an effect.
hypothesis: A declared model together with the effects that are supposed to act as well, and how their strengths are
    stored.
information: Normal equations of strengths, whose units differ by many powers of ten.
joint_fit: Joint fit of several shots: every shot keeps its declared parameters, effects have common strengths.
linearised_shot: One shot at one state, its own parameters in triangular form: what a joint fit adds up over the
    shots.
own_fit: One shot's own fit, with the common strengths held.
parameters: Public parameters of all shots under a hypothesis, and the disagreement of short and long windows.
prediction: The whole record that a hypothesis predicts, at every sample: for scores, clean records and pictures.
score_test: Score tests: how much of every candidate is visible beside what is fitted, and how much of it is in the
    residual.
start_changes: A parameter that changes along a ring-down, as changes of the start.
torque_response: The motion itself at a shot's instants, and how it answers to a small extra torque of any form.
"""
