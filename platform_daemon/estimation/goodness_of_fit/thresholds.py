"""From where on a fit is doubted or refused: every threshold of the judgement, in one place.

The unit is in the name: `sigma` counts standard deviations, `share` is relative, `chi2` a fall of chi^2. A false-alarm
rate stands where it follows from the noise being Gaussian; the others were set by what a result may be wrong by, and
are held by the tests of this room and the campaigns.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Thresholds:
    """Thresholds of the judgement of a fit."""

    # Is a fit believed at all?
    explained_r2: float = 0.9  # below: refused
    growth_sigma: float = 5.0  # below 0, of all losses: the oscillation grows; 3e-7 for a loss that is 0
    chi2_sigma: float = 6.0  # of chi^2 above its mean: much is left; 1e-9
    wrong_model_share: float = 1e-5  # of the signal's energy: left by a wrong variant in 0.24 s, more in longer windows
    few_periods: float = 12.0  # below: errors hold only if the model is exact
    large_chi2_per_dof: float = 1.1
    large_chi2_sigma: float = 4.0  # of chi^2 and of the noise that it is measured with; 3e-5
    mirror_sigma: float = 3.0  # by which e_v . x must differ from 0; 3e-3 where it is 0

    # By how much a result may be wrong: what would move it further is refused
    number_share: float = 0.05  # of m_r, phi_max and losses
    frequency_share: float = 3e-4  # of f_nat, which is known a hundred times better than anything else
    loss_share: float = 0.5  # of a loss, where a second oscillation or a further parameter takes some of it

    # Losses
    collinear_correlation: float = 0.99
    collinear_share: float = 0.2  # relative error of either loss
    loss_seen_sigma: float = 2.0  # below: explained without it; 2e-2 for a loss that is 0
    negative_loss_sigma: float = 3.0  # 1e-3 for a loss that is 0
    separated_share: float = 0.14  # relative error of the loss that is told better: room for chance below a fifth
    separated_other_share: float = 0.25  # of the other one, in the middle of what is plausible
    separated_correlation: float = 0.98

    # Is the residual noise?
    colour_sigma: float = 8.0  # of the flatness; 6e-16 per channel
    flatness: float = 0.9  # noise of unknown colour, drawn in wide bands, is hardly less flat than this
    rounding_share: float = 1e-8  # of the signal: the digits of the motion
    power_sigma: float = 4.0  # of the power of noise; 3e-5
    weak_line_share: float = 1e-5  # of the model's power: a line not worth a look
    line_over_median: float = 100.0  # of the spectrum: 1e-30 per bin
    floor_sigma: float = 4.0  # of the ratio of two densities; 3e-5
    floor_colour: float = 2.0  # so much more may stand below than above in what is still called noise
    envelope_sigma: float = 2.5  # of amplitude and phase in eight stretches: worth a second fit; 2e-2
    burst_share: float = 0.15  # of the residual's power, in a sixteenth of the window
    burst_sigma: float = 20.0

    # Tones and drift beside the signal
    tone_apart_cycles: float = 4.0  # over the window: what is nearer to a harmonic cannot be told from it
    known_tone_apart_cycles: float = 1.5  # the same for tones that were seen in blank shots
    drift_left_share: float = 0.1  # of an angle's misfit that may be left if it was hum or drift

    # What a misfit is searched for
    search_share: float = 1e-5  # of the signal's power: what is left of a companion of the smallest size that matters
    bend_search_share: float = 1e-4  # the same for a receiver that compresses
    misfit_sigma: float = 10.0  # of the noise's power, for a second oscillation to be sought; 1e-23
    whole_stretch_share: float = 0.5  # of the misfit, below which a short stretch is tried
    least_quality: float = 5.0  # of an oscillation: what dies faster is a transient

    # A second oscillation
    companion_share: float = 0.03  # of the fitted oscillation: a larger one is refused
    side_mode_share: float = 0.003  # smallest that is named
    move_sigma: float = 5.0  # 6e-7
    apart_turns: float = 3.0  # periods of the beat with the fitted motion
    locked_turns: float = 0.3  # the same: a harmonic of the motion itself
    harmonic_share: float = 0.1  # of the fitted oscillation: more than a small effect can add to a harmonic
    most_of_misfit: float = 0.5  # more than one of a pair of side bands can have
    all_of_misfit: float = 0.8
    decay_sigma: float = 5.0  # beyond: not steady; 3e-7
    steady_decay: float = 0.02  # over the window, below which a tone is steady
    probable_share: float = 0.6  # of the misfit, where no fit got through

    # A receiver that clips or compresses
    largest_bend_share: float = 0.05  # of the signal at its peak: an error that m_r may not have
    possible_bend_share: float = 1.5  # in linear approximation; nothing bends so far
    bent_share: float = 0.5  # of the misfit
    hardly_bent_share: float = 0.3
    cut_off_share: float = 0.6  # of the misfit
    cut_factor: tuple[float, float] = (0.3, 3.0)  # of the excess: the fit follows some of it, its peaks are lower
    cut_chi2: float = 50.0  # 2e-12 per place that is tried
    clip_level_ratio: float = 1.005  # from which the motion is beyond the level that a channel stays at
    clip_sigma: float = 4.0  # of a block mean, the same
    clip_slope: float = 0.2  # of the channel over the motion there

    # What is left over
    misfit_share: float = 0.02  # of the signal's power: refused
    everything_share: float = 0.99  # called as much as the signal itself
    failed_misfit_share: float = 1e-3  # of the signal's power, where no fit got through

    # Another model
    alternative_chi2: float = 25.0  # 6e-7 for one more parameter
    alternative_part: float = 0.1  # of what stands out of the noise: less comes with any further freedom
    alternative_most: float = 0.5  # the same: decisive
    alternative_chi2_per_dof: float = 1.5  # explains a record that the asked one does not get through
    number_sigma: float = 5.0  # 6e-7
    source_sigma: float = 2.0  # below 0: a loss that feeds energy in; 2e-2
    coarse_chi2_per_dof: float = 0.05  # of a coarse fit that shows how wide the motion swings
    beyond_contact_ratio: float = 1.05  # of the angle where contact is lost, for an amplitude that is seen coarsely


LIMITS = Thresholds()
