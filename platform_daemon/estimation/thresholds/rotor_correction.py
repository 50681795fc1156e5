"""Tuned numbers of the correction of one-angle fits for a manufacturing error."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import tuned

STUDY = "tests/benchmarks/corrected_fit.py"


@dataclass(frozen=True, kw_only=True)
class RotorCorrectionThresholds:
    """Which rotors are drawn, and how what they do is kept."""

    draws_jewel: int = tuned(288, "rotors", "drawn for a jewel, whose friction differs twofold", STUDY)
    draws_thread: int = tuned(128, "rotors", "drawn for a thread", STUDY)
    held_out: int = tuned(16, "rotors", "one of so many is held out and tells the error", STUDY)
    f_nat_share: float = tuned(5e-4, "1", "of f_nat, by which it may be off: 5 K", STUDY)
    lambda_share_jewel: float = tuned(0.05, "1", "of lambda", STUDY)
    lambda_share_thread: float = tuned(0.02, "1", "of lambda: side modes near their threshold grow with it", STUDY)
    friction_ln: float = tuned(0.7, "1", "of ln T_f/I: 2.6 standard deviations of the shipped jewel's scatter", STUDY)
    size_ln_jewel: float = tuned(0.01, "1", "of ln(drive size times m_r)", STUDY)
    size_ln_thread: float = tuned(0.005, "1", "of ln(drive size times m_r)", STUDY)
    delay_s: float = tuned(1e-5, "s", "of the samples against the drive", STUDY)
    turn_rad_jewel: float = tuned(
        2.5e-3, "rad", "about each axis: 3 standard deviations of the orientation from shot to shot", STUDY
    )
    turn_rad_thread: float = tuned(2.5e-4, "rad", "about each axis: a thread comes back to its place", STUDY)
    margin: float = tuned(1.15, "1", "times these, within which a shot may lie", STUDY)

    outside_sigma: float = tuned(4.0, "sd", "of the noise, beyond which a shot that lies outside is refused")

    most_power: int = tuned(7, "1", "of the bent variable", STUDY)
    most_mixed_power: int = tuned(3, "1", "of it times another variable", STUDY)
    ridge: float = tuned(1e-9, "1", "of the diagonal, that keeps least squares from rounding")
    difference_share: float = tuned(1e-4, "1", "of a box, for derivatives")
    harmonics: int = tuned(4, "1", "of the motion's phase", STUDY)
    thin: int = tuned(8, "samples", "of which one is computed: 7.6 kHz", STUDY)
    samples_per_node: int = tuned(128, "thinned samples", "between nodes of what is slow: 17 ms", STUDY)
    fewest_samples: int = tuned(20, "thinned samples", "in a window at the end")
    enough_share: float = tuned(1.1, "1", "of the expected window, for which the correction is computed")
    late_share: float = tuned(1.05, "1", "times a rotor's own window, from which on it hardly counts")
    late_weight: float = tuned(0.02, "1", "that it then has")
    kept_share: float = tuned(1.1, "1", "times the longest window, for which the correction is kept")

    coarse_window_s_jewel: float = tuned(0.5, "s", "of the first fit, which tells the place in the table", STUDY)
    coarse_window_s_thread: float = tuned(0.24, "s", "of the first fit, which tells the place in the table", STUDY)
    coarse_noise_share: float = tuned(0.02, "1", "of the signal, that stands for misfit and noise there", STUDY)
    noise_share: float = tuned(3e-3, "1", "of the signal, by which samples of drawn rotors are weighted")
    warned_chi2: float = tuned(1.1, "1", "of chi^2/dof over what noise and table explain, from which on a fit warns")
    refused_chi2: float = tuned(3.0, "1", "of chi^2/dof over what noise and table explain, from which on it is refused")
    gauge_noise_share: float = tuned(0.1, "1", "of the signal, in fits of whole ring-downs of drawn rotors", STUDY)
    most_descending: int = tuned(40, "steps", "of Gauss-Newton, to the bottom")
    polished: float = tuned(1e-9, "1", "predicted fall of chi^2 per sample at which these end")
    nearly_polished: float = tuned(1e-8, "1", "the same from a known start: a tenth of what the noise makes")
    start_periods: float = tuned(10.0, "periods", "with which a fit from a known start begins")
    lost_chi2: float = tuned(4.0, "1", "ratio of chi^2 to that before a step, at which steps lead nowhere")
    early_chi2: float = tuned(1.0, "1", "predicted fall at which passes over some of the half cycles end")
    early_half_cycle: int = tuned(7, "half cycles", "of which one is looked at there (odd)")
    decayed_share: float = tuned(0.3, "1", "of the swing, that is left at the end of a drawn rotor's window: D30")
    envelope_periods: float = tuned(3.0, "periods", "in a block of the envelope that tells it")
