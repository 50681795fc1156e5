"""Tuned numbers of start values, minimisation and passes over samples."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import covered_by, false_alarm, tuned


@dataclass(frozen=True, kw_only=True)
class StartValueThresholds:
    """How start values are read from the data."""

    # Angle records: initial_guess/angle.py
    angle_widest_rad: float = tuned(2.98, "rad", "amplitude of a start value")
    angle_periods: float = tuned(3.0, "periods", "beyond the first passage, over which the start holds")
    angle_work_points: int = tuned(64, "points", "in a half cycle, over which the work of the losses is summed")
    angle_speed_shares: tuple[float, ...] = tuned(
        (0.03, 0.06, 0.12, 0.25, 0.5, 1.0, 2.0),
        "1",
        "of the peak speed, that are tried for the speed at which a friction falls",
        covered_by("initial_guess/test_angle.py"),
    )
    held_scale_ratios: tuple[float, ...] = tuned(
        (1.0, 0.4, 2.5, 0.15, 6.0), "1", "of that speed at its start, at which it is held where no fit converges"
    )
    held_scale_reach: float = tuned(1.2, "1", "of the logarithm of that speed, in which the best is sought")
    held_scale_log_error: float = tuned(0.01, "1", "of the logarithm of that speed, to which it is sought")
    held_scale_chi2: float = tuned(
        10.0, "1", "rise of chi^2 over chi^2/dof beside the best one held, from which the speed is not told"
    )
    angle_many_half_cycles: int = tuned(6, "half cycles", "at least, from which the natural frequency is taken")
    angle_wide_rad: float = tuned(0.3, "rad", "down to which half cycles are taken for it")
    angle_most_decline: float = tuned(1.5, "1", "ratio of two turning points that the start state is carried back with")

    # dm/dt and volts: initial_guess/guess.py, initial_guess/harmonic_fit.py
    first_periods: int = tuned(10, "periods", "from which start values are read")
    most_stretches: int = tuned(8, "1", "times as many periods, at most, where noise hides the weak harmonics")
    trusted_snr: float = tuned(8.0, "1", "of a weak harmonic, from which the amplitude is read off it")
    amplitude_range_rad: tuple[float, ...] = tuned((2e-3, 2.7), "rad", "of start values")
    small_amplitude_rad: float = tuned(0.02, "rad", "below which noise makes up much of what is seen")
    blind_amplitudes_rad: tuple[float, ...] = tuned(
        (0.12, 0.35, 0.7, 1.1), "rad", "that are tried where the data do not tell"
    )
    dipole_other_amplitudes: tuple[float, ...] = tuned(
        (0.75, 1.3), "1", "times the best amplitude, tried next for calibrated dm/dt"
    )
    free_gain_other_amplitudes: tuple[float, ...] = tuned((0.6, 1.5), "1", "the same where gains are unknown")
    widest_rad: float = tuned(3.0, "rad", "of a motion whose frequency is computed")
    most_decay: float = tuned(0.3, "1", "of the logarithm of the amplitude from the start to the middle of the stretch")
    least_loss_share: float = tuned(0.1, "1", "of its typical value, for the loss that takes up the observed decay")
    harmonics: int = tuned(4, "harmonics", "that are fitted to a stretch")
    fewest_harmonics: int = tuned(2, "harmonics", "without which there are no start values")
    harmonics_apart_bins: float = tuned(
        2.0, "bins", "of a stretch's resolution, from one harmonic to the next or to where it folds to"
    )
    points_per_period: int = tuned(24, "samples", "per period, to which the stretch is averaged")
    frequency_search_share: float = tuned(0.12, "1", "of the frequency on either side, in which it is searched")
    near_phase_rad: float = tuned(
        0.5, "rad", "drift of the phase over half the stretch, up to which the fundamental's own drift tells it"
    )
    told_phase_rad: float = tuned(
        4.2, "rad", "drift of the phase that is told from none: at about 4.5 rad it looks like none"
    )
    settled_phase_rad: float = tuned(
        0.03, "rad", "drift at the ends of the stretch, below which the rest is of second order"
    )
    frequency_rounds: int = tuned(3, "rounds", "of the refinement of the frequency")

    # Where the first start fails: solve.py
    short_periods: float = tuned(12.0, "periods", "below which a fit without a minimum is called too short")
    coarse_noise_shares: tuple[float, ...] = tuned(
        (0.2, 1.0), "1", "of the rms signal of a channel, taken for the noise of a coarse fit"
    )
    coarse_early_chi2: float = tuned(3.0, "chi2", "fall still to come at which a growing window of a coarse fit ends")
    coarse_final_chi2: float = tuned(1.0, "chi2", "the same for the whole window")


@dataclass(frozen=True, kw_only=True)
class LeastSquaresThresholds:
    """How chi2 is minimised."""

    # Steps and stages: progressive.py, problem.py
    most_iterations: int = tuned(30, "iterations", "of a stage")
    sure_phase_rad: float = tuned(0.05, "rad", "standard deviation of the phase at the end of the next window")
    caution: float = tuned(4.0, "1", "times the estimate of the fall that a step leaves to the next one")
    negligible_fall_sigma: float = tuned(0.2, "sd", "of chi2, by which the last step may lower it without another pass")
    early_samples: int = tuned(3000, "samples", "for an early pass")
    early_half_cycle_samples: int = tuned(24, "samples", "of a half cycle, for an early pass")
    early_stride: int = tuned(15, "samples", "one of which, at least, an early pass takes")
    prior_width: float = tuned(3.0, "1", "standard deviation of a coefficient's prior over its typical size")
    prior_decay_width: float = tuned(30.0, "1", "times that, for the loss that took up the decay of dm/dt or volts")
    prior_amplitude_share: float = tuned(0.5, "1", "standard deviation of the amplitude's prior over the start value")
    first_samples: int = tuned(32, "samples", "in the first window at least")
    least_damping: float = tuned(1e-4, "1", "first damping after a step that made chi2 larger")
    damping_factor: float = tuned(10.0, "1", "by which the damping grows after such a step")
    damping_fall: float = tuned(0.1, "1", "by which it falls after a good one")
    no_damping: float = tuned(1e-6, "1", "below which it is set to 0")
    most_damping: float = tuned(1e8, "1", "beyond which there is no minimum")
    worse_share: float = tuned(1e-12, "1", "by which chi2 may grow on the same samples: rounding")
    worse_subsample_share: float = tuned(
        0.02, "1", "the same where half cycles are left out, and some samples change sides"
    )
    worse_chi2: float = tuned(1e-6, "chi2", "by which it may grow in any case")
    step_phase_rad: float = tuned(0.7, "rad", "largest step of the phase at t = 0")
    step_frequency_rad: float = tuned(2.0, "rad", "largest change of the phase at the end of the window")
    step_amplitude_share: float = tuned(0.4, "1", "largest step of the amplitude")
    quick_growth: float = tuned(16.0, "1", "of the window from stage to stage, quick schedule")
    quick_early_chi2: float = tuned(100.0, "chi2", "fall still to come at which a growing window ends")
    quick_late_chi2: float = tuned(1e3, "chi2", "the same for a subsample of the whole window")
    quick_final_chi2: float = tuned(1e-3, "chi2", "the same for the whole window")
    quick_half_cycles: int = tuned(33, "half cycles", "from which the early passes take their samples")
    quick_last_share: float = tuned(0.1, "1", "of the half cycles, from which the last early pass takes its samples")
    careful_growth: float = tuned(2.0, "1", "of the window from stage to stage, careful schedule")
    careful_early_chi2: float = tuned(0.3, "chi2", "as above")
    careful_final_chi2: float = tuned(1e-4, "chi2", "as above")
    most_passes: int = tuned(250, "passes", "over samples in one fit")
    lost_sigma: float = tuned(0.1, "sd", "of chi2, that rounding may take before chi2 is summed sample by sample")
    residual_chunk_samples: int = tuned(4096, "samples", "whose residual is in memory at once; memory only")
    rounding_share: float = tuned(
        1e-9, "1", "of the data's own chi2: the digits of the trajectory, and those lost in the difference"
    )

    # Minima, constraints, weights: multiple_minima.py, constraints.py, noise_weighting.py, public_parameters.py
    comparable_chi2: float = tuned(
        25.0,
        "chi2",
        "times the best chi2 per degree of freedom: another minimum within it is a rival",
        false_alarm("6e-7"),
    )
    distinct_sigma: float = tuned(10.0, "sd", "between two minima that are two")
    constraint_sigma: float = tuned(5.0, "sd", "by which a value lies beyond its bound", false_alarm("3e-7"))
    same_level_share: float = tuned(
        1e-6, "1", "by which the levels at the harmonics may differ and still be white noise"
    )
    weighting_steps: int = tuned(2, "steps", "the second removes only what the first leaves by being linear")
    poor_chi2_per_dof: float = tuned(1.5, "1", "beyond which other starts are tried")
    faint_share: float = tuned(0.05, "1", "relative error of the amplitude, beyond which a signal is too faint")
    faint_free_gain_share: float = tuned(0.3, "1", "the same where gains are free")
    nuisance_chunk_samples: int = tuned(1 << 10, "samples", "small enough for one thread to be the fastest; speed only")
    nuisance_steps: int = tuned(3, "steps", "of the joint fit")

    # Passes over samples: moments
    direct_chunk_samples: int = tuned(4096, "samples", "whose basis is in memory at once; memory only")
    kernel_chunk_samples: int = tuned(384, "samples", "whose polynomials fit into the fastest cache; speed only")
    kernel_lane_samples: int = tuned(
        8, "samples", "that are handled at once; the last few are filled up with zeros; speed only"
    )
    kernel_batch_half_cycles: int = tuned(8, "half cycles", "whose nodes are summed over at once; speed only")
    block_points: int = tuned(3, "points", "in a block of samples, at which its mean is computed")
    kernel_places: int = tuned(64, "places", "that are looked up at once; speed only")
    block_error_share: float = tuned(
        1e-4, "1", "of the signal: error of so few points, and of the coefficients left out"
    )
    coefficient_error_share: float = tuned(0.01, "1", "of the accuracy asked for: coefficients below it are left out")
