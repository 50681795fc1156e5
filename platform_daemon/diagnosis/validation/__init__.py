"""Proof on data that were not used.

cross_validation: Prediction of data that were not used: the proof of an effect.
validated_effects: Which of the refits predicts data that were not used, and which effects of it help there.
"""
