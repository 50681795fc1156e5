"""Every tuned number of the diagnosis, in one place; what is no threshold (indices, guards against 0) is not here.

The unit is in the name or begins the comment: `_s`, `_hz`, `_rad`; `share` and `ratio` are relative, `sigma` counts
standard deviations, `chi2` is a change of chi^2 over the noise factor, `log_p` the natural logarithm of a probability.
The brackets say what set a number:

* noise: it follows from this probability in Gaussian noise. digits: from the rounding of doubles or of first-order
  steps; decades beside it make no difference. physics, Akaike: from theory.
* cost: it bounds time or memory, and a larger search would find no less. drawing: it shapes tables and pictures only.
* D, A: it was chosen while docs/diagnosis-study.md or docs/angle-study.md was made, and the study holds for all such
  numbers together; none was scanned alone. r4: a measured pendulum in tests/data. "was": an earlier value.
* a test by name fails with a third or with three times of the number.
* unset: nothing set it but judgement; a study of its own may move it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from .fluctuation_thresholds import Fluctuation
from .rotor_thresholds import RigidBody
from .shot_thresholds import Shots


@dataclass(frozen=True, kw_only=True)
class Effects:
    """What a candidate may be: grids of hidden scales, and strengths beyond which it is no small effect."""

    settling_zero_shares: tuple[float, ...] = (0.05, 0.2, 0.6)  # time constants of a zero that settles, in windows [A]
    mains_share: float = 0.004  # relative tolerance of the mains frequency: 0.2 Hz of 50 Hz [unset]
    # offsets of the frequency at which a tone is tried again, in bins [unset]
    tone_moves_bins: tuple[float, ...] = (-0.3, -0.15, 0.0, 0.15, 0.3)
    # powers of side_mode_ratio at which a decay time is tried again [unset]
    side_mode_moves: tuple[int, ...] = (-2, -1, 0, 1, 2)
    side_mode_ratio: float = 1.25  # ratio of neighbouring decay times of a side mode [unset]
    # powers of transient_ratio at which a decay time is tried again [unset]
    transient_moves: tuple[int, ...] = (-3, -2, -1, 0, 1, 2, 3)
    transient_ratio: float = 1.2  # ratio of neighbouring decay times of an offset [unset]
    # powers of zero_ratio at which the time constant of a zero is tried again [A]
    zero_moves: tuple[int, ...] = (-2, -1, 0, 1, 2)
    zero_ratio: float = 1.4  # ratio of neighbouring time constants of a zero that settles [A]
    # offsets at which a kick is tried again, in parts of a period [A]
    kick_moves: tuple[float, ...] = (-3.0, -1.0, 0.0, 1.0, 3.0)
    kick_parts: float = 40.0  # number of such parts in a period [A]
    # strength of a receiver effect whose square is nothing, for first derivatives [digits]
    null_strength: float = 1e-12
    largest_gain: float = 0.3  # strength of a gain or of crosstalk beyond which it is no calibration error [D]
    largest_delay_s: float = 1e-3  # s of a delay or pole, beyond which it is no small effect [unset]
    pole_orders: int = 8  # of tau d/dt: time constants up to a third of the second harmonic's [digits]
    # velocity scales that are tried [unset]
    stribeck_rad_per_s: tuple[float, ...] = (5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 640.0)
    # powers of two at which a velocity scale is tried again [unset]
    stribeck_moves: tuple[float, ...] = (-0.6, -0.3, 0.0, 0.3, 0.6)
    slowest_scale: float = 0.05  # least velocity scale of a pendulum's friction, of the swing's peak speed [A]
    fastest_scale: float = 2.0  # greatest velocity scale of a pendulum's friction, of the swing's peak speed [A]
    first_scale: float = 0.3  # velocity scale at which the search begins, of the peak speed [A]
    # angle over which a friction builds up, of the amplitude: least, where its search begins, greatest [unset]
    displacement_shares: tuple[float, float, float] = (0.005, 0.05, 1.0)
    stiffest_contact: float = 1.0  # over w^2; beyond, a small swing is that of the contact itself [physics]
    steepest_scale: float = 0.5  # relative error of an angle scale's slope beyond which it is no scale of it [unset]
    largest_anharmonicity: float = 1.0  # strength at 1 rad of a pendulum beyond which it is another spring [A]
    largest_torsion: float = 1.0  # torsion stiffness of a pendulum beyond which it is another spring [A]
    largest_cubic: float = 0.5  # cubic stiffness at 1 rad of a pendulum beyond which it is another spring [A]
    first_exponent: float = 4.0  # power of the deflection at which the search of a spring begins [unset]
    least_exponent: float = 2.0  # least power of the deflection of a spring [unset]
    greatest_exponent: float = 9.0  # greatest; beyond, it is a stop at the largest amplitude [unset]
    first_settling: float = 4.0  # time constants per window at which the search of a settling f_nat begins [A]
    # the same of a second search: from the first one the way to a quick settling leads over worse fits;
    # one specimen, thread_published, showed it [unset]
    fast_settling: float = 16.0
    slowest_settling: float = 1.0  # fewest time constants per window of a settling f_nat [A]
    fastest_settling: float = 40.0  # most time constants per window of a settling f_nat [A]
    largest_drift: float = 0.2  # share of f_nat over the window; beyond, it is no drift [A]
    hertz_law_rad: float = 0.5 * math.pi  # rad up to which the law of the Hertz contact holds [physics]


@dataclass(frozen=True, kw_only=True)
class Regression:
    """Joint fits, score tests and predictions of held-out data."""

    noise_chi2_per_dof: float = 1.1  # from here on a residual is not noise, whatever its form [A]
    settled_chi2: float = 0.02  # fall of chi^2 below which a further step is not taken [cost]
    most_steps: int = 12  # Gauss-Newton steps of a joint fit [cost]
    # all further steps together are expected to gain at most so many times the present one [cost]
    hope_ratio: float = 3.0
    poor_share: float = 0.1  # share of its promise below which a step is poor [cost]
    most_poor_steps: int = 2  # poor steps before a fit without prospects is given up [cost]
    smallest_fraction: float = 1e-3  # of a step in the line search [unset]
    shortening: float = 0.3  # of the step, from one trial of the line search to the next [unset]
    valley_steps: int = 3  # steps of the shots' own parameters back into a bent valley [D]
    own_share: float = 0.3  # of a held-out shot's window, from which its start is fitted [unset]
    split_share: float = 0.7  # of a single shot's window, from which its end is predicted [unset]
    prediction_steps: int = 8  # Gauss-Newton steps of such a start [cost]
    prediction_fractions: tuple[float, ...] = (1.0, 0.3, 0.1, 0.03)  # of a step that are tried in turn [unset]
    # by which parameters must scatter beyond their errors to be each shot's own [noise: 6e-5]
    scatter_sigma: float = 4.0
    scatter_quantile: float = 0.975  # two-sided 95 % that a variance from few shots is widened to [noise]
    step_rank: float = 1e-10  # of the scaled columns, least singular value of a step [digits]
    # least singular value of the scaled columns where errors of a prediction are removed [digits]
    error_rank: float = 1e-12
    first_order_kick: float = 0.02  # of the swing's speed, up to which a kick counts to first order [physics]
    receiver_step: float = 1e-4  # of the signal, for derivatives of what receivers do to it [digits]
    information_rank: float = 1e-13  # least singular value of scaled normal equations [digits]
    dependent_share: float = 1e-9  # of a column that must be left beside the others to count [digits]
    per_shot_steps: int = 8  # Gauss-Newton steps of a per-shot fit [cost]
    per_shot_settled_chi2: float = (
        0.05  # fall of chi^2 at which it ends, in units of chi2/dof where that is above 1 [cost]
    )
    per_shot_parts: tuple[int, ...] = (4, 16)  # in which effects grow where they lead far from the first fit [cost]
    paired_shots: int = 4  # from so many on the scatter itself is the standard error of N50 - D30 [unset]
    windows_differ_sigma: float = 3.29  # of that, from which they differ: the paper's 0.001 [noise]
    resolved_share: float = 1e-11  # of a column's power that must survive the projection [digits]
    told_apart_eigenvalue: float = 1e-9  # least of a scaled matrix that tells candidates apart [digits]
    rest_determinant: float = 1e-12  # relative; below, the rotor rests and two derivatives are one [digits]
    # rad of dimensionless time per Runge-Kutta step; phase error ~ step^4 [digits, was 0.2]
    response_step_rad: float = 0.04
    least_amplitude_rad: float = 1e-12  # rad, by which a phase is divided [digits]


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Which effects are searched for, and which are accepted."""

    # p-value, corrected for all trials, below which an effect is accepted [noise: 1e-3 per diagnosis]
    level_p: float = 1e-3
    smallest_chance: float = 1e-300  # below, the tail's leading term is used [digits]
    smallest_log_p: float = -745.0  # logarithm of the smallest double [digits]
    unnamed_trials: int = 3  # trials beside the list: mains, tones, side modes [unset]
    largest_set: int = 3  # effects that are searched together [cost]
    leading_sets: int = 6  # sets of a size that are refitted [cost]
    overtaking_share: float = 0.03  # of the best gain: sets within it and overtaking_chi2 are refitted too [unset]
    overtaking_chi2: float = 12.0  # fall of chi^2 within which sets are refitted too [unset]
    negligible_share: float = 0.004  # of what is explained: gains below are digits of first-order corrections [D]
    most_additive: int = 6  # additive effects that every shot has for itself [cost]
    chi2_per_scale: float = 4.0  # that a hidden scale must gain [noise: 5e-2; A]
    near_motion_share: float = 0.15  # of an angle's frequency, within which a tone is the motion itself [A]
    same_place_bins: float = 3.0  # bins, within which two frequencies are one place [unset]
    wide_pairs_from: int = 12  # best blocks that pairs with more than two columns are drawn from [cost]
    narrow_pairs: int = 80  # best pairs of single columns that are scored in full [cost]
    pair_power_share: float = 1e-6  # by which the power of two columns must differ [digits]
    triples_from: int = 12  # best pairs that get a third [cost]
    thirds_from: int = 24  # best blocks that are tried as a third [cost]
    grown_sets: int = 2  # sets of torques of a size that grow [cost]
    compared_sets: int = 6  # of a size whose predictions are compared [cost]
    worth_a_scale: float = 3.0  # times the least chi^2, up to which a better scale may bring a set to the front [A]
    sharpened_sets: int = 5  # whose scales are searched [cost]
    timed_sets: int = 3  # that a torque that depends on time is added to [cost]
    rival_share: float = 0.2  # of the least chi^2, within which sets are rivals [A]
    rejected_share: float = 0.7  # of chi^2: a set that leaves less, but predicts worse, is reported as rejected [A]
    as_good_ratio: float = 1.03  # of held-out errors: as good, so the set with fewer parameters is taken [A]
    # of the misfit of a model that leaves more than noise: another one is as likely [unset]
    alternative_misfit: float = 1.5
    parting_rates: float = 2.0  # ratio of two shots' dampings, from which on time and amplitude are told apart [unset]
    helping_ratio: float = 0.9  # of held-out errors that a further torque must reach [A]
    refined_shares: tuple[float, ...] = (1.0, 0.4, 0.15)  # of a grid step, at which places are refined in turn [unset]
    own_refined_shares: tuple[float, ...] = (1.0, 0.3)  # the same for effects that every shot has for itself [unset]
    # the same for lines beside torques: a thousandth of a step off they show [test_select_effects]
    line_place_shares: tuple[float, ...] = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)
    torque_rounds: int = 3  # in which torques are judged again beside the lines that were found [cost]
    most_place_moves: int = 5  # moves of a place or hidden scale per grid step [cost]
    unclipped_share: float = 0.1  # of a record's samples, without which it is not followed after clipping [unset]
    quieter_share: float = 0.8  # of an angle's noise, below which it was taken for too large [unset]
    flat_ratio: float = 2.0  # of the levels in the second and the last quarter of a flat band, at most [unset]
    kick_move_periods: float = 0.25  # by which the instant of a kick moves at once, at most [physics]
    place_move_chi2: float = 0.5  # fall of chi^2 that makes another move worth while [cost]
    scale_steps: int = 8  # Gauss-Newton steps of a hidden scale [cost]
    scale_fractions: tuple[float, ...] = (1.0, 0.3, 0.1)  # of such a step that are tried in turn [unset]
    furthest_log_scale: float = math.log(2.5)  # greatest step of a scale's logarithm [unset]
    settled_scale_chi2: float = 0.02  # fall of chi^2, predicted or found, at which the search of a scale ends [cost]
    known_log_scale: float = 0.03  # standard deviation of a scale's logarithm below which the valley is straight [A]
    # standard deviations of it at which one refit tests whether the valley is straight [cost]
    checked_sigma: float = 1.5
    straight_share: float = 0.25  # by which a strength may differ there from first order [unset]
    varied_scales: tuple[float, ...] = (0.7, 0.9, 1.1, 1.4)  # times a scale, to see what moves with it [A]
    negative_loss_sigma: float = 3.0  # below 0: a loss is significantly negative [noise: 1e-3]
    told_apart_chi2: float = 10.8  # rise of chi^2 by which a look-alike is excluded [noise: 1e-3, 3.3 sigma]
    refit_chi2: float = 60.0  # rise of chi^2 to first order up to which a look-alike is refitted [unset]
    refit_share: float = 0.05  # share of the effect's gain that is added to refit_chi2 [unset]
    most_refits: int = 10  # look-alikes that are refitted [cost]
    near_misses: int = 2  # torques nearly in the place that get a second one [cost]
    second_torques: int = 3  # that are tried beside each [cost]
    second_chi2: float = 3.84  # fall that a second effect brings by chance [noise: 5e-2]
    polynomial_degree: int = 5  # of phi and v together in the smooth torque of the omnibus test [unset]
    envelope_harmonics: int = 4  # harmonics whose envelopes may change in the omnibus test [D, was 5]
    envelope_degrees: int = 3  # Legendre polynomials of time of each [D, was 4]
    direction_share: float = 1e-7  # of a direction's power that must survive the projection [digits]
    line_chance: float = 1e-6  # of a line anywhere in a residual without one [noise]
    most_tones: int = 12  # lines that are looked for [cost]
    kaiser_beta: float = 8.0  # of the spectrum's window [unset]
    level_edges_from: int = 16  # first bin of the stretches in which the noise's level is read [unset]
    level_edges: int = 40  # number of these stretches [unset]
    lowest_bins: float = 3.0  # bins below which there is no line [unset]
    blanked_bins: int = 6  # on either side of a line that is taken [unset]
    # order of a harmonic from which on its sweep, where it overlaps the next one, hides no line that is narrow [unset]
    hiding_harmonics: float = 7.0
    narrow_ratio: float = 30.0  # of a line over the median around it, by which it is no sweep [unset]
    narrow_reach: int = 3  # half the width of the blocks whose medians are taken, in widths of a line [unset]
    margin_bins: float = 4.0  # bins around what the harmonics sweep through, where no line is searched [unset]
    sweep_share: float = 0.002  # relative widening of the range that the harmonics sweep through [unset]
    missed_mains_hz: float = 0.15  # Hz by which a line of the mains may be misread [unset]
    single_mains_ratio: float = 1.5  # of the mains frequency: a single line above is not called mains [unset]
    side_rate_hz: float = 15e3  # Hz: rate to which residuals are averaged in the search of side modes [cost]
    decay_times: int = 8  # decay times at which side modes are searched [cost]
    fastest_decay_periods: float = 3.0  # shortest of these decay times, in periods of the motion [unset]
    slowest_decay: float = 0.7  # longest of these decay times, in windows; a slower decay is a line [unset]
    steady_decay: float = 0.3  # windows from which on a decay may be none [D]
    peaks_per_decay: int = 2  # places offered per decay time and channel [cost]
    offered_side_modes: int = 8  # side modes that become candidates, in all [cost]
    blanked_side_bins: int = 4  # lowest bins that hold no side mode, and least half width of one [unset]
    least_turns: float = 0.5  # that a side mode makes before it is gone; less is an offset [unset]
    shortest_transient_s: float = 30e-6  # shortest decay time of a transient, s [unset]
    longest_transient: float = 0.1  # longest decay time of a transient, in windows [unset]
    transient_times: int = 14  # decay times of transients [unset]
    offered_kicks: int = 2  # instants [cost]
    most_kicks: int = 6  # in one swing [cost]
    kick_margin_periods: float = 1.5  # periods at either end, and about a kick, where none is told from these [A]
    kick_free_instants: int = 8  # beyond the columns of the few periods around a kick that may show it [unset]
    kick_sigma: float = 5.0  # by which it must be missing there to be no kick [noise: 6e-7]
    kick_shown_sigma: float = 1.5  # by which it must be seen there beside torques: a true one was by 1.7 [noise: 7e-2]
    kick_wide_periods: float = 4.0  # on either side, where the margin hardly shows it beside torques [unset]
    kick_wide_degrees: int = 3  # powers of the time that the swing's size may have there, from 0 on [unset]
    kick_local_share: float = 0.5  # of its size that they must show: the place is known to a part of a period [unset]
    kick_spacing_periods: float = 3.0  # periods between two kicks that are offered at once [A]
    kick_seen_share: float = 1e-6  # of the response to a kick that no parameter takes up [digits]
    gap_log_p: float = -18.0  # logarithm of the chance of a gap beside a model [noise: 1.5e-8]
    most_gaps: int = 4  # of a shot beside a model [cost]
    gap_chi2_per_dof: float = 3.0  # beside which a model follows the motion but for some lost samples [A]
    # of a gap by which it may miss a whole number of samples, if this is more than whole_sigma [unset]
    gap_whole_share: float = 0.15
    whole_sigma: float = 5.0  # standard deviations by which a gap may miss a whole number of samples [noise: 6e-7]
    gap_reach: int = 4  # instants on either side in which a gap is located [unset]
    known_gap_periods: float = 0.25  # periods within which two gaps count as one place [unset]
    gap_seen_share: float = 1e-6  # of the power of a jump that must be visible [digits]
    cubic_reach: int = 4  # samples on either side that fill a gap [unset]
    model_gap_chi2: float = 30.0  # fall of chi^2 by which gaps must leave less than physics [noise: 4e-8]
    most_gap_passes: int = 3  # over a shot: a loss may hide another one [cost]
    angle_window_periods: float = 1.5  # half of a window: short for a swing that changes, long enough for noise [A]
    dipole_window_periods: float = 6.0  # half of a window of dm/dt [D]
    angle_points: int = 40  # points per period to which an angle is averaged [A]
    dipole_points: int = 16  # points per period to which dm/dt is averaged [D]
    smoothed_half_cycles: int = 5  # of which a local frequency is the median [A]
    # harmonics that describe a few periods of any swing [test_clock_gaps]
    swing_harmonics: tuple[int, ...] = (1, 2, 3, 4)
    swing_degrees: int = 3  # terms of the polynomial in time of each harmonic [test_clock_gaps]
    fine_points: int = 160  # points per period for the size of a gap [cost]
    tried_losses: int = 24  # sizes of a gap that are tried per period [cost]
    # periods up to which samples may be repeated; of more the rest of the period is lost more likely [unset]
    most_repeated_periods: float = 1.0 / 3.0
    ridge_share: float = 1e-13  # of the trace, shared between harmonics that look alike [digits]
    as_good_chi2: float = 25.0  # above the least chi^2 per value: the smaller loss is taken [noise: 6e-7]
    place_reach_periods: float = 0.25  # periods within which the place of a loss is refined [unset]
    loss_tolerance: float = 1e-3  # samples to which a size is polished [cost]
    wave_rank: float = 1e-12  # least singular value of the waves [digits]
    alike_frequency_share: float = 0.005  # frequencies for which one set of waves serves [cost]
    step_log_p: float = -30.0  # logarithm of the chance of a step without one [noise: 1e-13]
    step_explained_share: float = 0.7  # of its window's misfit that a step must explain [A]
    step_whole_samples: float = 0.1  # samples by which the size of a gap may miss a whole number [A]
    step_seen_sigma: float = 6.0  # standard deviations by which the size of a gap must differ from 0 [noise: 2e-9]
    # lengths of the windows that are searched, relative to the nominal one [A]
    window_shares: tuple[float, ...] = (1.0, 0.5)
    step_margin_periods: float = 0.3  # periods on either side of a gap that must lie in the window [A]
    # first offsets of the place of a gap, in periods [A]
    step_moves_periods: tuple[float, ...] = (-0.12, -0.06, -0.02, 0.0, 0.02, 0.06, 0.12)
    most_step_moves: int = 4  # moves of the place of a gap [cost]
    suspect_windows: int = 6  # suspicious windows of either kind that are examined [cost]
    windows_in_memory: int = 64  # windows that are fitted at once [cost]
    followed_chi2_per_value: float = 1.5  # of waves that follow the swing [test_clock_gaps]
    neighbour_ratio: float = 5.0  # of a window's misfit over that of its neighbours [A]
    neighbour_hint_ratio: float = 2.0  # the same at a suspect, up to a period beside the place of its step [unset]
    odd_ratio: float = 20.0  # of a window's misfit over the median [A]
    unseen_share: float = 1e-9  # of a column beside the waves that rounding leaves [digits]
    kick_chi2: float = 25.0  # by which a loss must explain more than a kick does [noise: 6e-7]
    edge_points: int = 4  # at either end of a window that hold no step [unset]
    windows_per_width: int = 6  # windows that begin within half a window [cost]
    lag_share: int = 4  # correlations are summed up to one window in so many [unset]
    step_trials: float = 1e6  # places and sizes that a step is corrected for [unset]


@dataclass(frozen=True, kw_only=True)
class Validation:
    """Which accepted effects stay after the test on held-out data."""

    shots_in_memory: int = 2  # shots of a long series in memory at once [cost]
    dropped_p: float = 0.05  # p-value above which an accepted effect is dropped again [noise]
    compared_look_alikes: int = 4  # that held-out data choose from [cost]
    fewest_own_strengths: int = (
        3  # shots, of which each has a strength of its own: a scatter of two says little [unset]
    )
    own_strength_share: float = 0.5  # of chi^2 with common strengths that own ones may leave, if not noise [unset]
    better_chi2: float = 2.0  # fall of the held-out chi^2 for which a look-alike replaces the best fit [D]


@dataclass(frozen=True, kw_only=True)
class Findings:
    """The verdict, the maps and the proposals of a diagnosis."""

    confident_share: float = 0.5  # of what could be gained that named effects must explain to be named [unset]
    negligible_rest: float = 0.01  # of what is explained: a rest that does not spoil an explanation [unset]
    believed_effects: int = 2  # common effects that are believed together [D]
    predicted_chi2_per_dof: float = 1.03  # of held-out data, of a complete model [D]
    predicted_sigma: float = 3.0  # by which that exceeds 1, at least, where held-out data are few [noise: 1e-3]
    followed_nrmse: float = 0.2  # of held-out data, of a model that follows the motion [r4, was 0.05]
    patch_share: float = 0.02  # of the largest gain: an effect that gains less mends the larger one [D]
    sure_share: float = 0.8  # of what may be missing, at sure_chance, that an explanation must account for [D]
    sure_chance: float = 0.05  # probability of the upper limit of what may be missing [noise]
    noted_chi2_per_dof: float = 1.05  # from which on a note says that errors are widened [unset]
    told_sets: int = 5  # as likely as what is named, in a note [drawing]
    noted_growth: float = 1.5  # of a standard deviation that is worth a note [unset]
    # of chi^2 with common strengths, that strengths of each shot's own must leave to be told [unset]
    own_strength_share: float = 0.5
    odd_shot_ratio: float = 3.0  # of its distance to the others over what these differ by [unset]
    negligible_tried: int = 2  # effects beside the named ones that are refitted [cost, was 3]
    scale_chi2: float = 4.0  # rise up to which another hidden scale tells of the strength's error [noise: 2 sigma]
    scale_shares: tuple[float, ...] = (0.1, 0.4, 1.5, 4.0)  # of a grid step at which a hidden scale is varied [unset]
    planning_shots: int = 3  # shots that represent all in a plan [cost]
    more_shots_ratio: float = 3.0  # further shots per present one in the plan `more_shots` [unset]
    apart_sigma: float = 3.3  # that a proposed measurement is to bring [noise: 1e-3]
    promised_share: float = 0.5  # of chi^2 left after a step, above which a rival is near its end [unset]
    planned_steps: int = 4  # of Gauss-Newton by which a rival follows a planned shot [cost]
    blank_shots_power: float = 3.0  # by which blank shots widen the difference of two effects: a rule of thumb [unset]
    # by which another excitation axis widens the difference of two effects: likewise [unset]
    other_axis_power: float = 2.0
    bias_field_power: float = 3.0  # by which a bias field does: likewise [unset]
    calibrate_2f_power: float = 4.0  # by which a calibration at 2 f does: likewise [unset]
    fewest_blocks: int = 120  # fewest blocks of a ring-down in which responses are summed [cost]
    most_blocks: int = 600  # most blocks of a ring-down in which responses are summed [cost]
    fewest_knots: int = 4  # fewest knots of a trace [unset]
    most_knots: int = 10  # most knots of a trace [cost]
    group_ratio: float = 1.15  # of the amplitudes of shots that share a trace [unset]
    most_groups: int = 4  # groups of shots with a trace of their own [cost]
    moving_p: float = 1e-3  # p-value, corrected for the number of parameters, below which one moves [noise: 1e-3]
    moving_share: float = 0.1  # of what earlier ones gain that a further one must gain [digits, was 0.05]
    alike_chi2: float = 6.0  # fall of chi^2 by which laws or parameters must differ to be distinguished [noise: 1.4e-2]
    alike_share: float = 0.003  # of the best one's fall by which they must differ [unset]
    # of amplitude and speed; -1: a loss that is dry friction in truth [physics]
    law_powers: tuple[float, ...] = (-1.0, 1.0, 2.0)
    law_settling: tuple[float, ...] = (0.05, 0.15, 0.5)  # time constants of a law of time, in windows [unset]
    chi2_per_freedom: float = 2.0  # penalty per free parameter of a course [Akaike]
    law_share: float = 0.5  # of what any course would gain that a law must gain [unset]
    least_ratio: float = 1e-6  # of the largest amplitude or speed in a law [digits]
    course_rank: float = 1e-10  # least singular value of a course [digits]
    walk_share: float = 1e-10  # of the largest eigenvalue that is visible [digits]
    near_mean: float = 1e-4  # relative; the formula for tails has a removable pole at the mean [digits]
    variance_decades: float = 9.0  # of a walk's variance that are searched to either side [unset]
    variance_points: int = 109  # of this search: four a decade [unset]
    map_points: int = 25  # of angle and velocity in the map of the missing torque [drawing]
    map_share: float = 1e-7  # of the largest eigenvalue that is visible [digits]
    map_rounding: float = 1e-12  # of the largest variance [digits]
    map_beside: float = 1e-2  # share of a column's power that declared parameters must leave for the map [unset]
    drawn_harmonics: int = 5  # of a residual [drawing]
    stretches: int = 24  # in which harmonics are drawn, at most [drawing]
    stretch_periods: float = 4.0  # periods of a stretch at least [drawing]
    few_stretches: int = 6  # stretches of a short record [drawing]
    short_stretch_periods: float = 1.5  # periods of a stretch of a short record [drawing]
    at_start_s: float = 0.02  # s whose residual is reported by itself [drawing]
    line_power: float = 30.0  # of a line over that of the noise [noise: 1e-13 per bin]
    line_end: float = 3.0  # part of this power down to which bins belong to a line [drawing]
    most_lines: int = 12  # lines of a residual that are listed [drawing]
    lobe_bins: int = 4  # of the Blackman window, half a line at least [drawing]
    angle_window_periods: float = 6.0  # of a sliding window along an angle [drawing]
    fewest_windows: int = 3  # sliding windows that can be flat or not [drawing]
    ranked_candidates: int = 40  # in the report [drawing]


@dataclass(frozen=True, kw_only=True)
class Thresholds:
    """All thresholds of the diagnosis, one group per part of it."""

    shots: Shots = field(default_factory=Shots)
    effects: Effects = field(default_factory=Effects)
    regression: Regression = field(default_factory=Regression)
    selection: Selection = field(default_factory=Selection)
    validation: Validation = field(default_factory=Validation)
    findings: Findings = field(default_factory=Findings)
    rigid_body: RigidBody = field(default_factory=RigidBody)
    fluctuation: Fluctuation = field(default_factory=Fluctuation)


THRESHOLDS = Thresholds()
