"""From files to results: open, calibrate, estimate the noise, fit, derive, diagnose, register a model.

dask_cluster: The workers of the scheduler at `address`.
WorkerPool: Who fits.
cores: Cores that this process may use.
in_this_process: No other process.
processes: So many processes, warm from the compiled kernels' cache, one thread each.
Ledger: Appends finished files.
FitSettings: How to fit every file of a batch.
InputFile: A recording.
count_frames: Frames of a recording that can be fitted as asked.
Advanced: So much of a file is fitted, 0 to 1.
Finished: A file is fitted.
fit_files: Fit files in the order given and hand each out as it finishes.
reason_of: Why a frame that cannot be read is refused.
ring_down: The record that a fit takes.
frame_envelopes: Envelopes of v and u, A(t) and f(t) - f_nat over the window of a good frame.
frame_quantities: Q of the viscous losses alone, and the equivalent Q over the window and to infinity, of one good
    frame.
frame_times_s: When each frame was triggered, s from any zero.
series_quantities: Orientation errors against mean and best, and the Allan deviation of f_nat, over the frames of a
    report.
DiagnosisInput: What is to be diagnosed.
NothingToDiagnoseError: The files can be read, but none of their shots can be diagnosed.
OBSERVABLES: What a recording can hold: dm/dt or an angle.
Observable: One of OBSERVABLES.
check_diagnosis_input: What load_specimen raises before it has read any samples.
diagnose_input: Diagnose, and add what was seen while reading.
load_diagnosis_input: Read recordings or angle series of one specimen.
file_report: The fixed JSON form for one file from its frames' reports.
fit_frame: Calibrate and fit one RX window, (c, n) V.
fit_recording: Fit every excited frame of a recording, or those chosen.
fit_table: On-line fits of a series as the store keeps them.
frame_report: One frame in the fixed JSON form, plus notes, warnings, chi2 by channel and where the noise came from.
refused_report: A frame that could not even be offered to the fit.
ring_down_plot_data: What to draw of one frame.
FITTED_NAMES: Names of all parameters that a fit can have, in order.
FitRefused: A fit that everything else rests on was refused.
FitRequest: How to fit.
NAMED_WINDOWS: Evaluation windows that have a name.
Window: An evaluation window: n50, d30 or seconds.
check_fixed: Raises InputError for a parameter that cannot be held or hinted at, or not at that value.
checked_variant: The name of a declared model with further torque terms.
choose_variant: The caller's variant, else the file's, with further torque terms.
why_refused: Why a report has no good frame, each reason once.
chosen_frames: The frames asked for, in order, each once.
frame_harmonics: The report of a stored frame.
harmonics_report: Frequency, amplitude, moment, orientation and decay in the first periods of (c, n) V, or why there
    are none.
PENDULUM: The model that an angle is taken for unless another one is named.
angle_variant: The caller's variant, else a pendulum, with further torque terms.
angles_report: The fixed JSON form for one angle file.
fit_angles: The one frame of an angle file, fitted or refused.
refuse_calibration: Raises RecordingError if one is given.
AdoptedModel: A named, versioned model.
model_from_diagnosis: The model that a diagnosis in its JSON form carries, to be added to the library.
file_digests: Name, size and SHA-256 of files.
Library: The adopted models in a folder.
UnknownModel: No adopted model has that name or version.
ModelChoice: A declared model by its name, or an adopted one.
label_of: What results are marked with.
model_of: What a fit takes.
resolve: A declared name as it is, an adopted one as its model.
learn_noise: Let a series' noise learn from one RX window, (c, n) V, unless it is clipped.
RingDownPlotData: What a picture shows.
min_max_decimate: Smallest and largest value per bucket, (c, buckets) each, and samples per bucket.
PAPER_DEFLECTION_DEG: Deflection at the paper's fields by bearing, degrees.
planned_precision: Smallest possible standard deviations per window, of the specimen's own variant or of another
    model.
amplitude_course: (start in s, phi_max in degrees, its standard deviation) of the good windows.
flatness_lines: For the terminal.
slide_angles: The same of an angle file.
slide_frame: Fit a frame window by window.
sliding_report: JSON form.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
