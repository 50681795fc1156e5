"""What follows from the fits of a series: orientation and its spread, Allan deviation, the summary of a file.

allan: Allan deviation of f_nat over a series: how long averaging helps, and what drifts.
orientation: How far orientations lie apart: the error angle of tab:model_params_fit_result, over the frames of a
    series.
summary: Mean and scatter of each parameter over the frames of a series.
"""
