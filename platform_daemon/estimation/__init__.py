"""From calibrated dm/dt, volts or an angle to a `FitResult`; no files, no devices, no web.

calibrate: dm/dt = -P^+ H^-1 u.
Phasors: Complex amplitudes of a tone in all channels, with their standard deviations.
combine: Mean of equally good segments (n, channel) with its standard deviation, from their scatter.
segment_length: Samples of a segment of so many samples.
segment_phasors: Complex amplitudes in successive segments of (channel, n) samples.
ReceiveResult: What a calibration of the receive side found.
receive_result: Split P (channel, 3, k) into geometry, which is real, and each channel's frequency response.
sensitivity_from: One column of P, (channel,) complex, and its standard deviation, from phasors of voltage and
    moment.
unlike_declared: What a new P (channel, 3) says of the wiring, against the declared one.
CORRECTABLE: Ids of the receiver effects that can be taken out of samples before a fit.
correct_receiver_effects: A dm/dt record (3, n) without these effects.
TransmitResult: What a calibration of the transmit side found.
transmit_result: Explain each coil's field per volt as gain * b / (R + i omega L), b and L free.
systematic_std: Standard uncertainty of m_r, A m^2, from that of P at f_nat and 2 f_nat.
Conditions: How a shot was taken, as far as known.
out_of_validity: What a fit with this calibration must be told.
warm_up: Compile all kernels (or load them from numba's cache).
MeasurementPlan: A measurement to come: what the Cramer-Rao bound is asked for.
planned_window_s: Seconds of "n50", "d30" (until 30 % of hat m_dot_v is left) or of the number itself.
predict_precision: Cramer-Rao bound of every public parameter for the samples in [0, window_s].
fit_ring_down: Fit a declared model to a ring-down.
estimate_from_harmonics: Read frequency, amplitude, moment, orientation and decay off the first 24 periods of a
    dm/dt record.
FitState: Everything that is fitted, as one point of the parameter space.
NormalEquations: Quadratic model of chi^2 around a state.
coefficient_jacobian: Derivatives of the channels' coefficients in the kernel's basis by all parameters, (size,
    channels, b).
DipoleObservation: dm/dt through m_r and R, seen by channels that mix the world axes.
FreeGainObservation: Channels with free gains: u_c = Sv_c phi' cos(phi) + Su_c (-phi' sin(phi)); no calibration is
    needed.
PublicParameters: The published parameters of a fit with their covariance.
by_convention: Resolve phi -> -phi so that the observation obeys its sign convention.
propagate_to_public: Public values and covariance of a fitted state (already by convention).
Workspace: What all passes over the same record with the same model share.
sd_at: Standard deviation of white noise with the density that stands at each frequency (m,).
NoiseModel: Noise of a record's channels, white or coloured.
estimate_noise: Noise of a record, from all its valid samples.
SeriesNoise: Noise learnt from all shots of a series.
Array: A numpy array of float64.
REACH: Samples that `derivative` looks at on either side.
derivative: Time derivative of (..., n), n >= 9, from the nearest nine samples.
one_thread_for_products: Keep BLAS from starting threads, once per process.
kernel: Compile `function` at its first call (nogil, float64, cached on disk).
Estimate: A value and its standard deviation.
RODRIGUES: Orientation of the resonator, e_u, e_v, e_w in world axes, as a Rodrigues vector.
mean_over_mirror_images: Chordal mean on SO(3) of vectors (frames, 3), each by its twin nearest to that mean.
mirror_images: The same motions with phi -> -phi.
on_one_branch: Public parameters of several frames, each as those of its twin nearest to their mean orientation
    (3,), and that.
rotations: Rotations of vectors (frames, 3) or (3,).
DrivenModel: A model with values, and the push of a field.
NoPlanError: The model does not swing under this field, or too far.
plan_for_all: The plan from rest that swings the rotor furthest in the worst case of f_nat off by `tolerance`.
MODELS: The declared models by name.
RingDownModel: An equation of motion, the sum of its torque terms (in units of I w^2), and how it is observed.
model_named: The declared model of this name, or one with further torque terms, as in "thread+quadratic_drag".
envelopes: Envelopes at `points` equidistant times from 0 to duration_s.
equivalent_quality_factor: tilde Q over [0, T] (eq:tilde-Q), from the traced motion.
quality_factor: Q = omega_nat / (2 lambda) of viscous damping alone (eq:lambda).
RingDown: A motion whose parameters are known, and the moment that makes it visible.
TERMS: The torque terms by name.
acceleration: Sum of all autonomous terms.
TorqueTerm: One torque term.
DIPOLE: Basis of a signal that is seen as dm/dt.
STATE: Basis of a signal that is seen as the angle itself.
LostTrajectoryError: The trajectory found no further turning point.
Trajectory: A traced ring-down from its anchor to t_end.
turning_points: (times in s, |angles| in rad) from the anchor to beyond until_s, or to the last before the rotor
    sticks.
RingDownRecord: Samples of one ring-down.
Refusal: Codes of refused fits.
RefusedError: Ends a fit early.
FitResult: Result of one ring-down fit.
model_signal: The fitted model at the sample times of a record.
Clipping: Samples of a channel that pile up at its top or bottom.
find_half_cycles: Half cycles of an angle; None if there are fewer than two.
find_oscillation: The strongest line of a record; None if there is none.
screen_free_swing: Check an angle for what a free swing must have beside what every record must.
find_clipping: The largest pile of clipped samples, None if there is none.
saturation: Why these samples are too clipped for a fit, None if they are not.
MAINS_HZ: Frequencies of mains.
Zones: Frequencies that belong to the signal.
is_mains: Near a multiple of a mains frequency, which may be off by a share `relative`.
median_level: Medians of power (channels, bins) in the bands between the edges, drawn through their middles.
peak_shift: How far the maximum near bin k of power (bins,) lies from it, in bins.
periodogram: Power of windowed samples (channels, n), (channels, bins).
CalibrationError: A calibration that cannot be applied.
LambdaMode: How sliding windows treat the viscous loss: free, held, or held where it cannot be told.
ReferenceRefusedError: The D30 fit, from which the length of the windows was to be taken, was refused.
SlidingBounds: So many windows at most, and so many samples in all of them together.
SlidingFit: Windows along one ring-down, and the D30 fit of the same record that they are compared with.
WindowFit: The fit of one window.
fit_sliding: Fit a ring-down window by window.
find_minimum: Minimise chi^2 from start values found in the data.
task_of: Screen the record, measure its noise, choose the samples.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
