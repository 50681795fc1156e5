"""Proof on data that were not used.

validated_effects: Which of the refits predicts data that were not used, and which effects of it help there.
"""
