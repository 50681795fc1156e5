"""Results in words, tables, pictures and pages; nothing is computed here.

print_calibration: Sensitivity by channel, or field and inductance by coil.
print_self_test: Gain and isolation by coil.
characterisation_html: The page in UTF-8.
characterisation_text: The tables for the terminal.
print_devices: A row per device.
print_findings: A row per thing that `doctor` has looked at.
diagnosis_html: The page in UTF-8.
defects_text: Forces for the terminal.
design_text: Numbers of a design and the six steps, for the terminal.
defects_png: The picture of a defect as PNG.
save_defects_png: Write it to a file.
summary_text: For the terminal.
ring_down_png: The picture of a ring-down as PNG.
save_png: Write the picture as PNG.
save_sliding_png: Write the picture as PNG.
fit_line: One file's fits in one line.
fit_table_text: One file's fits.
shot_line: One shot of a series with what its fit says.
prediction_table_text: The smallest standard deviations of a plan, a row per window.
dry_run_text: A series as it would be, for the terminal.
outcome_text: What tune has found, a line each.
plan_text: Every step of a procedure with its values, then shots, duration, disk and warnings.
steps_text: A row per step of a procedure.
ramp_text: A ramp for the terminal.
save_ramp_png: Write the picture of a ramp as PNG.
fits_csv: A row per fit.
fits_parquet: The same as Parquet.
trend_csv: A row per point.
trend_text: A row per quantity, then what has changed.
trend_png: The picture of a trend as PNG.
save_trend_png: Write it to a file.
print_recording: Facts, windows, calibration, excitation and shots of a recording, on standard output.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
