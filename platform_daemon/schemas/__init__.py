"""What crosses a boundary: requests, results, jobs, problems, and the table of parameters with symbol and unit.

NoResult: There is no result.
Root: Something whose JSON is a list, a mapping, or one of several schemas.
Schema: Something that crosses a boundary.
Window: An evaluation window: n50, d30 or seconds.
to_json: The JSON text of files and of the command line.
AllanReport: Overlapping Allan deviation of f_nat with its confidence interval of 68.3 % (NIST SP 1065).
DerivedReport: Derived quantities of a fit.
EnvelopesReport: Envelopes of a fitted frame over its window.
FittedFrameQuantities: Quality factors of a good frame, with its number.
FrameQuantities: Quality factors of one good frame.
FrequencyNoise: Power law of the noise of a frequency.
OrientationDeviation: Angles between the orientations of a series and one of reference.
OrientationErrors: Orientation errors of a series with a calibration.
SeriesQuantities: What the frames of a series tell together.
UnfittedFrameQuantities: A frame without a fit.
ErrorSummary: An error in a list of results.
FileError: A file that could not be read or fitted at all.
FileState: What tells that a file has changed.
FitBatch: The fits of several files, in the order in which they were named.
FitReport: The fits of one file.
FrameFit: The fit of one frame, or why it was refused.
LedgerLine: One line of the ledger of a batch (`fit --jsonl`).
NoiseReport: Where the noise of a fit was measured.
ParameterEstimate: An estimated parameter, in the SI unit that its name holds.
ParameterSummary: A parameter over the good frames of a series, in the SI unit that its name holds.
unfitted: A frame that could not even be offered to the fit.
HarmonicEstimate: Frequency, amplitude, moment, orientation and decay in the first 24 periods.
HarmonicsBatch: The same of several files, in the order in which they were named.
HarmonicsReport: What the harmonics of the frames of one file tell.
RefusedHarmonicEstimate: The harmonics cannot be read.
ShotHarmonics: What the harmonics of one shot tell, or why they cannot be read.
PAPER_DEFLECTION_DEG: Deflection at the paper's fields by bearing, degrees.
PAPER_NOISE_AM2_PER_S: Noise of x, y, z per sample in the paper, A m^2/s.
PARAMETERS: The table of parameters by name.
ParameterDefinition: One parameter.
RODRIGUES: Names of the three components of an orientation.
definition_of: Of a parameter.
names_in_order: Parameters of the table in the order in which they are told.
PredictionReport: How precise a planned measurement can be at best, per window.
WindowPrecision: The smallest standard deviations that an evaluation window can reach.
SelfTestOptions: The self-test before a series, table `[self_test]` of a platform file.
SequencePatch: The keys of a sequence that differ from the resonator's preset.
FlatnessReport: Do the windows agree on one value of a parameter? In the SI unit that its name holds.
SlidingReport: Fits along one ring-down.
WindowFitReport: The fit of one window.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
