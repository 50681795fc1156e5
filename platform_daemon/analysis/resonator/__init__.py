"""What a resonator is by its design, and what manufacturing defects do to it.

checked_defect: From a request to a defect of a resonator, or what, where and why it makes no sense.
curves: Curves of the perpendicular force for a picture like the paper's figures.
defects: Perpendicular forces of a defect, case by case.
numbers: Numbers of a design, and the paper's procedure in six steps.
"""
