"""Tuned numbers of what fluctuates along the ring-down, as thresholds.py explains them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Fluctuation:
    """When a friction or a frequency is sought that fluctuates, and when it is one."""

    most_shots: int = 12  # whose courses are fitted: 12 of 2 s take 1.9 GB, 32 of them 3.2 GB [cost]
    knots: int = 80  # of a course, along the window [cost]
    # The phase follows a course of the frequency once integrated, one of the friction twice: it shows faster waves.
    most_shots_of_frequency: int = 4  # likewise [cost]
    knots_of_frequency: int = 240  # with 80 a course left more than noise in two of three series of two shots [unset]
    # What a frequency pumps into the amplitude: at 55 degrees 1.3 times as much as by the formula, and its course
    # between the knots is known by the form of the process alone [unset]
    pumped_times: float = 2.0
    amplitude_steps: int = 60  # along the window, of a walk of the amplitude [cost]
    first_knots: int = 24  # of the linear test before the courses are fitted [cost]
    first_size: float = 0.2  # standard deviation over the mean friction, or in Hz, where a search begins [unset]
    first_tau_share: float = 0.07  # correlation time over the window, likewise [unset]
    least_size: float = 1e-3  # of the standard deviation that is sought [cost]
    largest_share: float = 1.0  # beyond, the friction would be negative for a sixth of the time [physics]
    largest_hz: float = 10.0  # of a frequency: a twentieth of such a resonator's [unset]
    seen_square: float = 1e-6  # of a direction of the noise, below which a formula for it loses digits [digits]
    most_steps: int = 20  # of a course's fit [cost]
    settled_chi2: float = 0.3  # fall of chi^2 over the excess at which it ends [unset]
    # Fall at which fits end that have a course beside them: to first order the course moves chi^2 by 1 to 100 [unset]
    fitted_chi2: float = 3.0
    smallest_fraction: float = 1e-3  # of a step [cost]
    shortening: float = 0.4  # of a step that goes up [unset]
    curvature_step: float = 0.05  # in the logarithms of size and correlation time [digits]
    widest_log: float = 3.0  # standard deviation of what the data do not tell of them [unset]
    furthest_log: float = 0.5  # by which they are moved at once, to see what follows them [unset]
    most_passes: int = 5  # of courses and effects in turn [cost]
    settled_log: float = 0.05  # change of the process's logarithms at which the turns end [unset]
    # of the log likelihood of a course for each shot, from which on one course for all is as good: a law [unset]
    law_share: float = 0.85
    # The same of the smooth courses with which a search begins, before their costly fits, and the difference of the log
    # likelihoods below which one course is a law.  Two jewels with a tilt or shift and shots of two fields had 0.999999
    # and 3, laws of losses 0.99988 to 1.01 and up to 640; a fluctuation of 5 % beside a damping that leaves eight
    # hundred times the noise 0.99972 and 5800, beside one four times as strong 0.9999 and 1700 [test_law_of_amplitude]
    sure_law_share: float = 0.9999
    sure_law_log: float = 1000.0  # see there [test_law_of_amplitude]
    common_amplitudes: float = 0.25  # share of a shot in which the largest swing has its amplitudes too [unset]
    any_law_share: float = 1.0  # the same of a course that changes sooner than a law does [unset]
    # of the window: a law follows the amplitude, which falls all along it; its course does not change sooner.
    # Likeliest correlation times of three laws of Stribeck took 0.7 to 0.9 of it, those of ten drawn fluctuations 0.01
    # to 0.15, with one course for all nearly as good for one of them (0.9 of its log likelihood) [unset]
    smooth_share: float = 0.3
    apart_share: float = 0.02  # of a receiver effect's column that nothing else replaces, to have its own size [unset]
    undetermined_tau: float = 0.9  # of the window: a longer correlation time is not told from any other [unset]
    most_effects: int = 4  # that are sought beside a fluctuation at once [cost]
