"""Tuned numbers of the rotor with manufacturing errors, as thresholds.py explains them."""

from __future__ import annotations

from dataclasses import dataclass

from platform_daemon.estimation.physics.rigid_rotor.contact_law import ContactLaw


@dataclass(frozen=True, kw_only=True)
class RigidBody:
    """When a motion leaves its plane, and when a manufacturing error explains it."""

    # of the power along the main axis: in every shot, or in one while the others may hide it [noise: 1e-15]
    plane_sigma: float = 8.0
    # the same in every shot where one angle leaves more than noise; also of what noise may hide [noise: 6e-3]
    plane_hint_sigma: float = 2.5
    plane_steepest: float = 4.0  # power of the swing with which the share along the axis may fall [unset]
    plane_rate: float = 8.0  # samples per period that are left: side modes and three harmonics [unset]
    plane_from: float = 0.3  # of f_nat, from which on the noise's level is read [unset]
    plane_peak: float = 0.5  # of f_nat: peaks of the noise that are narrower are lines of the motion [unset]
    plane_stretch: int = 9  # frequencies in a stretch of a spectrum that stands out or not [unset]
    plane_out_sigma: float = 4.0  # by which it does [noise: 1e-3]
    # of the measured noise, by which that of the other frequencies may be lower for the cut alone [unset]
    plane_level_share: float = 0.03
    plane_turns: int = 4  # in which the noise of the others is found [cost]
    plane_share: float = 1e-3  # of the signal: less along the axis is not searched for its cause [unset]
    start_rad: float = 0.02  # tilt at which a fit starts, with both signs [unset]
    large_start_rad: float = 0.045  # of a jewel, where that leaves less: 0.047 at 95 % of the threshold [unset]
    start_m: float = 1e-4  # displacement, likewise [unset]
    near_rad: float = 0.1  # between the orientation of one angle and the declared one, up to which they are one [unset]
    upright_rad: float = 1.4  # of a main axis from the vertical, up to which it is meant to be so [unset]
    # The grid where it is further
    largest_rad: float = 0.055  # largest tilt [unset]
    largest_m: float = 3.5e-4  # largest displacement [unset]
    grid_sizes: int = 10  # sizes of each sign [unset]
    # f_nat above the main mode over the square of the size that a tilt would have [unset]
    grid_softening: tuple[float, ...] = (0.0, 1.5, 3.0, 4.5)
    grid_moments: tuple[float, ...] = (0.65, 0.7, 0.75, 0.8, 0.85, 0.9)  # m_r over the stator's by the drawing [unset]
    grid_side_damping_per_s: tuple[float, ...] = (5.0, 20.0)  # 1/s of side modes [unset]
    grid_settled: int = 20  # of each kind whose state at the first sample is fitted, where no drive is known [unset]
    grid_kept: int = 4  # points of each kind from which fits begin [unset]
    # 1/s, lambda at the start, least and most: that of one angle takes what goes to side modes and slip [unset]
    damping_per_s: tuple[float, float] = (0.05, 0.1)
    jewel_softening: float = 4.0  # fall of a jewel's main mode over f_nat and the square of the stator's tilt [physics]
    # stator's tilt that acts like 0.058 mm, the largest drawn error of a jewel that left only noise [unset]
    hidden_rad: float = 0.0104
    side_damping_per_s: float = 5.0  # 1/s of side modes at the start [unset]
    # m/s of slip below which a jewel's contact creeps, at the start [unset]
    creep_m_per_s: float = 2e-3
    creep_spin_rad_per_s: float = 5.0  # rad/s of spin, likewise [unset]
    # of a jewel's contact: its friction falls below a slip as s / sqrt(s^2 + c^2), as s / (s + c), as the first at each
    # point of the disc, or as tanh(s / c), and slip and spin share that of one disc or have their own [physics]
    contact_laws: tuple[ContactLaw, ...] = (
        ContactLaw(0.0, 1.0), ContactLaw(1.0, 1.0), ContactLaw(0.0, 0.0), ContactLaw(2.0, 1.0),
        ContactLaw(3.0, 1.0), ContactLaw(4.0, 1.0), ContactLaw(4.0, 0.0),
    )  # fmt: skip
    damping_axis_to_thread: float = 0.5  # between the rotor's own axis and the thread's, at the start [unset]
    leading_swing: float = 1.3  # times the first shot's, from which on a larger one is fitted before it [unset]
    sign_window_s: float = 0.1  # s in which the sign of a tilt is told [unset]
    # s of the first window where no drive is known; from 0.1 s on one at 93 % of its threshold was not found [unset]
    first_free_window_s: float = 0.02
    jewel_distance_from_s: float = 0.5  # s of a window from which on a jewel's distance is free [unset]
    # m/s, of which each law of a contact begins with the one that leaves least in the shortest window [unset]
    creeps_m_per_s: tuple[float, ...] = (2e-3, 2e-4)
    # s of a window from which on laws of a contact are excluded as look-alikes are, and spared while not needed [unset]
    laws_from_s: float = 0.5
    # of chi2/dof in a window, up to which one law of a contact is enough there [noise: 1e-3]
    noise_sigma: float = 3.0
    same_sigma: float = 1.0  # standard deviations by which two sizes of one error are the same minimum [unset]
    # of the swing at its start: below, where a jewel's contact sticks and slips, a rotor tells nothing more [unset]
    kept_swing: float = 0.03
    swing_periods: float = 10.0  # periods of a stretch in which the swing's size is read [unset]
    exchange_window_s: float = 0.4  # s in which an error takes the place of another one [unset]
    exchange_most_ratio: float = 2.0  # of an error's size in a long window over that in the short one [unset]
    exchange_parts: int = 4  # in which it does at most [cost]
    exchange_part_rad: float = 0.009  # of a tilt that falls at once [unset]
    exchange_part_m: float = 5e-5  # of a displacement that falls at once [unset]
    free_start_periods: float = 2.0  # of a motion of which no drive is known, in which its start is sought [unset]
    free_start_phases: int = 24  # of the swing, which are tried [unset]
    free_start_sizes: tuple[float, ...] = (0.85, 0.93, 1.0, 1.07, 1.15)  # over that which the power tells [unset]
    start_phases: int = 8  # of a swing that is left of the shot before, at which a fit begins [unset]
    like_first_sigma: float = 3.0  # of chi2/dof of another shot's short window, up to which a start is right [unset]
    explained_chi2_per_dof: float = 2.0  # above, the rigid rotor is no explanation either [unset]
    # the same of a window where a rotor counts only if it leaves noise; one of 1.13 had 1.33 minutes later [unset]
    given_up_chi2_per_dof: float = 1.1
    # chi2/dof of predicted ends from which on a rotor lies beside the right one: right ones had up to 1.14, wrong ones
    # 1.49 and 8.5 [unset]
    poor_prediction_chi2_per_dof: float = 1.3
    most_wider_chi2: float = 100.0  # of these by which errors are widened: a lost motion has 1e5 [unset]
    # of the size of the error, or root of the chi^2 that a rotor without it leaves more [noise: 6e-7]
    sure_sigma: float = 5.0
    weighed_sigma: float = 0.5  # of the size, from which on a rotor without the error is fitted beside it [cost]
    least_rad: float = 2e-4  # tilt that is an error: coils and glass scales show the axes no better [unset]
    least_m: float = 1e-6  # displacement, likewise; a perfect jewel at 581 uT is fitted with 4e-5 rad or 0.6 um [unset]
    # chi^2 by which a rotor without an error may leave more than effects of one angle that do not explain all: these
    # follow the noise at the few instants by which both are judged; -0.3 to 22 for four perfect jewels [unset]
    perfect_rotor_chi2: float = 40.0
    doubtful_sigma: float = 5.0  # of a drive's size and delay, and of chi2/dof, beyond which it is left out [unset]
    worth_sigma: float = 1.0  # by which a measurement would part look-alikes, at least; less is none [digits]
    equal_chi2: float = 4.0  # difference of chi^2 by which an error is not preferred to a simpler one [noise: 0.05]
