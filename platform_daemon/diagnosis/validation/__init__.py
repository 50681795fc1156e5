"""Proof on data that were not used.

further_shots: Shots of a long series that were not searched: what is found must hold for them too.
validated_effects: Which of the refits predicts data that were not used, and which effects of it help there.
"""
