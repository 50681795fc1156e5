"""From files to results: open, calibrate, estimate the noise, fit, derive, diagnose, register a model.

dask_cluster: The workers of the scheduler at `address`.
WorkerPool: Who fits.
cores: Cores that this process may use.
in_this_process: No other process.
processes: So many processes, warm from the compiled kernels' cache, one thread each.
Ledger: Appends finished files, a LedgerLine each.
error_summary: An error among results.
InputFile: A file.
count_frames: Frames of a file that can be fitted as asked.
Advanced: So much of a file is fitted, 0 to 1.
Finished: A file is fitted.
fit_files: Fit files in the order given and hand each out as it finishes.
calibrated_signal: The RX window of a frame, (c, n) V.
reason_of: Why a frame that cannot be read is refused.
CharacterisationTask: What is to be characterised, checked.
characterisation_task: Everything that can be checked before the first fit.
characterise: Fit every shot in both windows and make the tables.
check_held_in_n50: What it raises of losses that cannot be held.
shown_shot: The shot of the figures with its D30 fit.
NothingToDiagnoseError: The files can be read, but none of their shots can be diagnosed.
OBSERVABLES: What a recording can hold: dm/dt or an angle.
Observable: One of OBSERVABLES.
check_diagnosis_input: What load_diagnosis_input raises before it has looked at any frame.
diagnose_input: Diagnose, and add what was seen while reading.
load_diagnosis_input: Read recordings or angle series of one specimen.
fit_measurement: Fit every frame of a file, or those chosen.
FitRefused: A fit that everything else rests on was refused.
FitSettings: How to fit any file.
NAMED_WINDOWS: Evaluation windows that have a name.
checked_variant: The name of a declared model with further torque terms.
why_refused: Why a report has no good frame, each reason once.
chosen_frames: The frames asked for, in order, each once.
Harmonics: What the harmonics of a shot tell, or why they cannot be read.
frame_harmonics: Of a stored frame, with its number.
CheckModel: Is there such a model?
NamedModel: A model by its label.
OnlineFit: Reads a stored shot, learns from its noise and fits it.
SeriesTable: Puts the fits of a series together.
Warmth: Compiles or loads the estimator's kernels.
VoltageMeasurement: A recording of coil voltages.
open_for_fit: A file as the settings want it, and what to ask of it.
open_measurement: A recording under this calibration or its own, or an angle.
open_voltages: A recording under this calibration or its own.
AdoptedModel: A named, versioned model.
model_from_diagnosis: The model that a diagnosis carries, to be added to the library.
file_digests: Name, size and SHA-256 of files.
Library: The adopted models in a folder.
UnknownModel: No adopted model has that name or version.
ModelChoice: A declared model by its name, or an adopted one.
resolve: A declared name as it is, an adopted one as its model.
RingDownPlotData: What a picture shows.
min_max_decimate: Smallest and largest value per bucket, (c, buckets) each, and samples per bucket.
RINGING_SPAN: A line is looked for from the expected frequency divided by this to its multiple.
ringing_line: The strongest line near the expected frequency in the only frame of a shot's file.
ring_down_plot_data: What to draw of one frame.
Escalation: The state of one ramp, and its next field.
RampPlan: What a ramp may do.
RecordedSideModes: What recorded shots show out of the plane.
SideLine: A line in the z residual.
ZResidual: What a shot shows out of the plane of the main mode.
planned_precision: Smallest possible standard deviations per window, of the specimen's own variant or of another
    model.
checked_defect: What is asked for of a defect, or what, where and why it makes no sense.
ForceCurves: What a picture of a defect shows.
force_curves: Perpendicular force over the size of a defect.
defects_report: Every size of a defect at every deflection.
design_report: What follows from magnets and bearing alone, and the paper's procedure in six steps.
amplitude_course: (start in s, phi_max in degrees, its standard deviation) of the good windows.
flatness_lines: For the terminal.
slide_frame: Fit a frame window by window.
preview_derived: Derived quantities of a stored fit.
preview_envelopes: Envelopes of a fitted frame.
preview_harmonics: Harmonics of a frame.
preview_picture: What to draw of a frame.
preview_sliding: Sliding windows along one ring-down.
sliding_report: Every window with its estimates or the reason of its refusal, and how flat each constant is.
accept: A specimen is what it is now; its charts begin anew.
UnknownSpecimen: No recording is of that specimen.
exported_fits: All on-line fits of a specimen as one table.
find_recordings: Names of the files of what is looked for.
indexed_recordings: Recordings of a specimen with on-line fits.
indexed_specimens: Names of all specimens with shots that were fitted.
indexed_trend: The trend of a specimen between two times.
update_index: Look at the recordings that are new or have changed.
POINTS_TO_FALSE_ALARM: Of a specimen that does not change, unless somebody asks for another number.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
