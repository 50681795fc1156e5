"""Tuned numbers of the judgement of a fit.

The unit is in the name too: `sigma` counts standard deviations, `share` is relative, `chi2` a fall of chi^2.
"""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import covered_by, false_alarm, tuned

ANGLE_LACK_OF_FIT = covered_by("goodness_of_fit/test_angle_lack_of_fit.py")
FAILURE_CAUSE = covered_by("goodness_of_fit/test_failure_cause.py")
FLAT_TOPS = covered_by("goodness_of_fit/test_flat_tops.py")
VERDICT = covered_by("goodness_of_fit/test_verdict.py")
CHANNEL_GAINS = covered_by("goodness_of_fit/test_channel_gains.py")
TWO_RESONATORS = covered_by("screening/test_two_resonators.py")


@dataclass(frozen=True, kw_only=True)
class GoodnessOfFitThresholds:
    """From where on a fit is doubted or refused."""

    # Is a fit believed at all?
    explained_r2: float = tuned(0.9, "1", "R2 over all channels, below which a fit is refused")
    growth_sigma: float = tuned(
        5.0, "sd", "below 0, of the sum of all losses: the oscillation grows", false_alarm("3e-7 for a loss that is 0")
    )
    chi2_sigma: float = tuned(6.0, "sd", "of chi2 above its mean: much is left", false_alarm("1e-9"))
    wrong_model_share: float = tuned(
        1e-5, "1", "of the signal's energy, left by a wrong variant in 0.24 s; more in longer windows"
    )
    few_periods: float = tuned(12.0, "periods", "below which the errors hold only if the model is exact", VERDICT)
    large_chi2_per_dof: float = tuned(1.1, "1", "above which a fit is warned of", VERDICT)
    large_chi2_sigma: float = tuned(4.0, "sd", "of chi2 and of the noise that it is measured with", false_alarm("3e-5"))
    plausible_f_nat_hz: tuple[float, float] = tuned(
        (5.0, 20_000.0),
        "Hz",
        "of a resonator in a coil, outside of which a number in the file is in another unit than it seems",
        covered_by("goodness_of_fit/test_plausibility.py"),
    )
    plausible_angle_hz: tuple[float, float] = tuned(
        (0.02, 20_000.0),
        "Hz",
        "the same, of an angle: pendulums too",
        covered_by("goodness_of_fit/test_plausibility.py"),
    )
    plausible_m_r_am2: tuple[float, float] = tuned(
        (1e-7, 10.0),
        "A m^2",
        "moment of the rotor, outside of which the same holds; a sphere of 1.3 T has 4e-6 with a radius of 0.1 mm and "
        "4 with 1 cm",
        covered_by("goodness_of_fit/test_plausibility.py"),
    )
    mirror_sigma: float = tuned(3.0, "sd", "by which e_v . x must differ from 0", false_alarm("3e-3 where it is 0"))

    # By how much a result may be wrong: what would move it further is refused
    number_share: float = tuned(0.05, "1", "of m_r, phi_max and losses")
    frequency_share: float = tuned(3e-4, "1", "of f_nat, which is known a hundred times better than anything else")
    loss_share: float = tuned(0.5, "1", "of a loss, where a second oscillation or a further parameter takes some of it")

    # Losses
    collinear_correlation: float = tuned(
        0.99, "1", "of the errors of two losses, from which they are inseparable", VERDICT
    )
    collinear_share: float = tuned(0.2, "1", "relative error of either loss, from which they are", VERDICT)
    loss_seen_sigma: float = tuned(
        2.0, "sd", "below which the record is explained without a loss", false_alarm("2e-2 for a loss that is 0")
    )
    negative_loss_sigma: float = tuned(3.0, "sd", "below 0, of one loss", false_alarm("1e-3 for a loss that is 0"))
    separated_share: float = tuned(
        0.14, "1", "relative error of the loss that is known better: room for chance below a fifth", VERDICT
    )
    separated_other_share: float = tuned(0.25, "1", "of the other one, in the middle of what is plausible", VERDICT)
    separated_correlation: float = tuned(0.98, "1", "of the errors, below which two losses are separated", VERDICT)

    # Is the residual noise?
    colour_sigma: float = tuned(8.0, "sd", "of the flatness", false_alarm("6e-16 per channel"))
    flatness: float = tuned(0.9, "1", "noise of unknown colour, drawn in wide bands, is hardly less flat than this")
    rounding_share: float = tuned(1e-8, "1", "of the signal: the digits of the motion")
    power_sigma: float = tuned(4.0, "sd", "of the power of noise", false_alarm("3e-5"))
    weak_line_share: float = tuned(1e-5, "1", "of the model's power: a line not worth a look")
    line_over_median: float = tuned(
        100.0, "1", "power of a line over the median of the spectrum", false_alarm("1e-30 per bin")
    )
    floor_sigma: float = tuned(4.0, "sd", "of the ratio of two densities", false_alarm("3e-5"))
    floor_colour: float = tuned(
        2.0, "1", "density at low over that at high harmonics, up to which both are called noise", ANGLE_LACK_OF_FIT
    )
    envelope_sigma: float = tuned(
        2.5, "sd", "of amplitude and phase in eight stretches: worth a second fit", false_alarm("2e-2")
    )
    burst_share: float = tuned(0.15, "1", "of the residual's power, in a sixteenth of the window")
    burst_sigma: float = tuned(20.0, "sd", "of that power")
    gain_share: float = tuned(
        0.8, "1", "of the misfit, that gains of the channels and crosstalk explain", CHANNEL_GAINS
    )
    gain_rank_share: float = tuned(
        1e-3, "1", "of the largest singular value of the changes that gains make, below which the fit follows them"
    )

    # Tones and drift beside the signal
    tone_apart_cycles: float = tuned(
        4.0, "cycles", "over the window: a tone nearer to a harmonic cannot be told from it"
    )
    known_tone_apart_cycles: float = tuned(1.5, "cycles", "the same for tones that were seen in blank shots")
    drift_left_share: float = tuned(
        0.1, "1", "of an angle's misfit, that may be left if it was hum or drift", ANGLE_LACK_OF_FIT
    )

    # What a misfit is searched for
    search_share: float = tuned(
        1e-5,
        "1",
        "of the signal's power: what is left of a companion of the smallest size that matters",
        TWO_RESONATORS,
    )
    bend_search_share: float = tuned(1e-4, "1", "the same for a receiver that compresses")
    misfit_sigma: float = tuned(
        10.0, "sd", "of the noise's power, for a second oscillation to be sought", false_alarm("1e-23")
    )
    whole_stretch_share: float = tuned(0.5, "1", "of the misfit, below which a short stretch is tried")
    least_quality: float = tuned(5.0, "1", "quality factor of an oscillation: what dies faster is a transient")

    # A second oscillation
    companion_share: float = tuned(0.03, "1", "of the fitted oscillation: a larger one is refused", TWO_RESONATORS)
    side_mode_share: float = tuned(0.003, "1", "of the fitted oscillation: the smallest that is named", TWO_RESONATORS)
    move_sigma: float = tuned(5.0, "sd", "by which a result moves beside it", false_alarm("6e-7"))
    apart_turns: float = tuned(3.0, "periods", "of the beat with the fitted motion", TWO_RESONATORS)
    locked_turns: float = tuned(0.3, "periods", "the same: a harmonic of the motion itself", TWO_RESONATORS)
    harmonic_share: float = tuned(
        0.1, "1", "of the fitted oscillation: more than a small effect can add to a harmonic", TWO_RESONATORS
    )
    most_of_misfit: float = tuned(0.5, "1", "share: more than one of a pair of side bands can have", TWO_RESONATORS)
    all_of_misfit: float = tuned(0.8, "1", "share: the oscillation is alone in the residual", TWO_RESONATORS)
    decay_sigma: float = tuned(5.0, "sd", "of a decay, beyond which it is not steady", false_alarm("3e-7"))
    steady_decay: float = tuned(
        0.02, "1", "of the logarithm of the size over the window, below which a tone is steady", TWO_RESONATORS
    )
    probable_share: float = tuned(0.6, "1", "of the misfit, where no fit got through", FAILURE_CAUSE)

    # A receiver that clips or compresses
    largest_bend_share: float = tuned(
        0.05, "1", "of the signal at its peak: an error that m_r may not have", FAILURE_CAUSE
    )
    possible_bend_share: float = tuned(1.5, "1", "in linear approximation; nothing bends so far")
    bent_share: float = tuned(0.5, "1", "of the misfit, that compression explains")
    hardly_bent_share: float = tuned(0.3, "1", "of the misfit, up to which flat tops are possible too")
    cut_off_share: float = tuned(0.6, "1", "of the misfit, that flat tops explain", FLAT_TOPS)
    cut_factor: tuple[float, ...] = tuned(
        (0.3, 3.0), "1", "of the excess: the fit follows some of it, its peaks are lower", FLAT_TOPS
    )
    cut_chi2: float = tuned(
        50.0, "chi2", "fall, from which a channel is cut off", false_alarm("2e-12 per place that is tried")
    )
    clip_level_ratio: float = tuned(1.005, "1", "from which the motion is beyond the level that a channel stays at")
    clip_sigma: float = tuned(4.0, "sd", "of a block mean, the same")
    clip_slope: float = tuned(0.2, "1", "of the channel over the motion there")

    # What is left over
    misfit_share: float = tuned(0.02, "1", "of the signal's power: refused")
    everything_share: float = tuned(0.99, "1", "of the signal's power: called as much as the signal itself")
    failed_misfit_share: float = tuned(1e-3, "1", "of the signal's power, where no fit got through")

    # Another model
    alternative_chi2: float = tuned(
        25.0, "chi2", "fall from which another model is better", false_alarm("6e-7 for one more parameter")
    )
    alternative_part: float = tuned(0.1, "1", "of what stands out of the noise: less comes with any further freedom")
    alternative_most: float = tuned(0.5, "1", "the same: decisive")
    alternative_chi2_per_dof: float = tuned(1.5, "1", "explains a record that the given model does not get through")
    number_sigma: float = tuned(5.0, "sd", "by which a number of the two models differs", false_alarm("6e-7"))
    source_sigma: float = tuned(2.0, "sd", "below 0: a loss that feeds energy in", false_alarm("2e-2"))
    coarse_chi2_per_dof: float = tuned(
        0.05, "1", "of a coarse fit that shows how wide the motion swings", FAILURE_CAUSE
    )
    beyond_contact_ratio: float = tuned(
        1.05, "1", "of the angle where contact is lost, for an amplitude that is seen coarsely", FAILURE_CAUSE
    )

    # Block means and stretches of the residual: block_residual.py, residual.py, residual_jacobian.py
    block_points_per_period: float = tuned(
        12.0, "means", "per period: the band reaches to six times the fundamental, to all harmonics that matter"
    )
    block_chunk: int = tuned(1 << 10, "means", "in memory at once; memory only")
    probe_share: float = tuned(1e-9, "1", "of the amplitude, as the noise of a residual that is only looked at")
    burst_stretches: int = tuned(16, "stretches", "in which the residual's power is compared")
    colour_bands_per_octave: int = tuned(4, "bands", "in which the colour of the noise is drawn")
    colour_band_values: float = tuned(6.0, "independent values", "in such a band at least")
    colour_first_bins: int = tuned(8, "bins", "in the first of these bands")
    known_degrees: float = tuned(1e9, "1", "degrees of freedom of a noise that is known exactly")
    jacobian_chunk: int = tuned(1 << 10, "means", "in memory at once; memory only")
    subspace_share: float = tuned(1e-9, "1", "of the largest singular value, below which a direction is none")
    envelope_stretches: int = tuned(8, "stretches", "in which amplitude and phase are compared")
    envelope_stretch_means: int = tuned(3, "means", "in a stretch at least")

    # The noise of an angle above its harmonics: noise_floor.py
    floor_points_per_period: float = tuned(
        36.0, "means", "per period: the band then reaches beyond the neighbourhood", ANGLE_LACK_OF_FIT
    )
    floor_split_harmonics: float = tuned(
        3.5, "harmonics", "where the upper band begins; hardly any misfit is at higher ones alone", ANGLE_LACK_OF_FIT
    )
    floor_highest_harmonics: float = tuned(16.0, "harmonics", "where the upper band ends", ANGLE_LACK_OF_FIT)
    floor_bins: int = tuned(16, "bins", "in either band at least")

    # The window that separates two losses: collinearity.py
    separating_step: float = tuned(2.0**0.125, "1", "ratio of one window to the one before", VERDICT)
    separating_looks: tuple[float, ...] = tuned(
        (3.0, 12.0, 48.0), "windows", "as far as the motion is followed", VERDICT
    )
    separating_reach_sigma: float = tuned(1.5, "sd", "from the fit, to which the truth may lie")
    separating_points: tuple[float, ...] = tuned(
        (0.1, 0.3, 0.5, 0.7, 0.9), "1", "of that reach, at which the losses are tried"
    )
    least_loss_sigma: float = tuned(1e-3, "sd", "to which a plausible loss is limited from below")

    # Candidates of a second oscillation: second_oscillation.py, damped_sinusoid.py, omitted_component.py
    candidate_padding: int = tuned(4, "1", "grid points per resolved frequency step")
    candidate_band: tuple[float, ...] = tuned(
        (0.2, 5.9), "1", "frequencies over the fundamental, between which candidates are sought; block means end at six"
    )
    candidate_decays: tuple[float, ...] = tuned((0.0, 1.0, 3.0), "1", "over the stretch, as exponents")
    candidate_stretch_periods: tuple[float, ...] = tuned(
        (20.0, 60.0),
        "periods",
        "of the two stretches: a friction-damped companion changes its frequency over longer ones",
    )
    phase_ends_divisor: int = tuned(
        20, "1", "part of a stretch at either end, where the phase of a motion is not well known"
    )
    candidate_regularisation: float = tuned(
        1e-3, "1", "of the trace, that is added to the diagonal of a candidate's normal equations"
    )
    sinusoid_steps: int = tuned(8, "steps", "of the refinement of a candidate")
    sinusoid_furthest: tuple[float, ...] = tuned(
        (0.5, 3.0, 3.0, 3.0),
        "1",
        "of a step of frequency, decay, chirp and bend, over the length of the stretch: about where it is linear",
    )
    sinusoid_gain_share: float = tuned(1e-5, "1", "of the explained power, below which no further step is worth it")
    early_divisor: int = tuned(
        16, "1", "part of the stretch, from which the fitted signal's size at the beginning is read"
    )
    early_means: int = tuned(8, "means", "in that part at least")
    component_share: float = tuned(1e-9, "1", "of the largest singular value, below which a direction is none")

    # Steady tones, flat tops, failed fits: interference.py, flat_tops.py, lack_of_fit.py, failure_cause.py
    tone_rounds: int = tuned(2, "rounds", "of the search for tones: a strong one hides a weak one")
    tone_sweep_share: float = tuned(0.01, "1", "of the frequency, by which the range of a harmonic is widened")
    cut_first_share: float = tuned(
        0.004, "1", "of the peak: smallest depth at which a channel may be cut off", FLAT_TOPS
    )
    cut_step: float = tuned(1.35, "1", "ratio of one such depth to the one before", FLAT_TOPS)
    cut_count: int = tuned(16, "depths", "that are tried", FLAT_TOPS)
    cut_periods: float = tuned(
        60.0, "periods", "that are searched: the tops of the beginning are the first to be cut off", FLAT_TOPS
    )
    clip_means: int = tuned(12, "means", "at the top of a channel, whose median is its level")
    contact_periods: float = tuned(
        7.0,
        "periods",
        "of the look at a swing beyond the contact: at a wide swing the frequency changes fast",
        FAILURE_CAUSE,
    )
