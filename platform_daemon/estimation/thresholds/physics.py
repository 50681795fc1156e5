"""Tuned numbers of the computed motion; none of them changes the equation of motion."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import tuned


@dataclass(frozen=True, kw_only=True)
class PhysicsThresholds:
    """How finely the motion is computed."""

    # A half cycle as a whole: chebyshev.py, collocation.py, half_cycle_table.py, half_cycle_chain.py, table_range.py
    most_sizes: int = tuned(40, "sizes", "at which half cycles are tabulated")
    fewest_sizes: int = tuned(3, "sizes", "the same, at least")
    exact_digits: float = tuned(
        10.5,
        "decimal digits",
        "of the motion in the last pass of a fit",
        "tests/estimation/physics/trajectory/test_trajectory.py",
    )
    coarse_digits: float = tuned(5.5, "decimal digits", "of the motion in the early passes")
    fewest_nodes: int = tuned(8, "nodes", "of a half cycle, a multiple of four")
    most_nodes: int = tuned(64, "nodes", "the same")
    spare_nodes: float = tuned(2.0, "nodes", "beyond those that the motion needs, for its sensitivities")
    fastest_convergence: float = tuned(6.0, "1", "ratio by which the error falls from node to node at most")
    least_elliptic_parameter: float = tuned(
        1e-9, "1", "to which the parameter of the elliptic integrals is limited, and from 1 by the next one"
    )
    elliptic_margin: float = tuned(1e-6, "1", "distance of that parameter from 1")
    collocation_steps: int = tuned(14, "steps", "of Newton's method for one half cycle")
    collocation_stretch_share: float = tuned(0.3, "1", "of the duration, by which one step may change it")
    collocation_widest_rad: float = tuned(
        4.0, "rad", "size of the next half cycle, beyond which the rotor has turned over"
    )
    first_guess_terms: int = tuned(
        16, "1", "order, below which the Fourier terms of the undamped half cycle are summed"
    )
    first_guess_rounds: int = tuned(6, "rounds", "of the arithmetic-geometric mean")
    first_guess_parabola: int = tuned(3, "sizes", "through which the first guess of the next size is drawn")
    alike_low: float = tuned(
        0.8, "1", "ratio of two sizes, from which on the solution of one is the first guess of the other"
    )
    alike_high: float = tuned(1.25, "1", "the same, up to which it is")
    settled_digits_share: float = tuned(
        0.8, "1", "of the digits, to which the last Newton step must be small; the error after it is its square"
    )
    sure_pull: float = tuned(
        0.1, "1", "smallest pull back from rest over the largest, from which between the sizes nothing can stick either"
    )
    shortest_half_cycle: float = tuned(2.0, "1", "duration times w: pi at least, unless something pushes")
    widest_rad: float = tuned(3.0, "rad", "close to the inverted position a half cycle takes forever")
    spare_half_cycles: int = tuned(16, "half cycles", "beyond those that fit into the time, for which there is memory")
    widest_band: float = tuned(
        25.0, "1", "ratio of the sizes in one table: at small sizes more half cycles need no more sizes"
    )
    band_room: float = tuned(
        1.05, "1", "that a band has for the parameters to change before it needs another number of sizes"
    )
    band_margin: float = tuned(1.15, "1", "on the estimated loss of size over the time that is left")
    band_points: int = tuned(8, "points", "in a half cycle, over which the work of the losses is summed")
    band_least_sine: float = tuned(
        0.1, "1", "of the size, to which the restoring torque at the turning point is limited from below"
    )
    band_slack_share: float = tuned(1e-3, "1", "of the size, by which a band is wider than estimated")
    band_most_growth: float = tuned(1.5, "1", "of the size over the time that is left")

    # A half cycle step by step: runge_kutta.py, direct_chain.py, direct.py
    runge_kutta_steps: int = tuned(
        32,
        "steps",
        "per half cycle: the error stays below 1e-9 of the signal up to 75 degrees",
        "tests/estimation/physics/trajectory/test_trajectory.py",
    )
    turning_point_steps: int = tuned(12, "steps", "of Newton's method for the turning point")
    turning_point_close: float = tuned(1e-15, "1", "correction of the last step times w, at which Newton's method ends")
    turning_point_found: float = tuned(1e-12, "1", "the same, up to which it has found the turning point")
    duration_trials: int = tuned(60, "trials", "of the duration of a half cycle")
    duration_shorter: float = tuned(0.9, "1", "factor of the next trial, where the rotor turned before the last step")
    duration_longer: float = tuned(1.08, "1", "factor of the next trial, where it did not turn in the last step")
    last_step_shortest: float = tuned(0.3, "1", "of a step: a shorter last one is distributed over all")
    last_step_longest: float = tuned(2.0, "1", "of a step: the last one may be so long")
    direct_widest_rad: float = tuned(3.0, "rad", "close to the inverted position a half cycle takes forever")
    earliest_anchor: float = tuned(
        -12.0, "1", "time of the first turning point times w: a half cycle from 175 degrees takes less"
    )
    most_half_cycles: int = tuned(
        400_000, "half cycles", "a quarter of an hour at 212 Hz; a trial step may ask for more than there is memory"
    )
    label_rounds: int = tuned(60, "rounds", "of Newton's method from the state at t = 0 to phi_max and psi_start")
    label_close: float = tuned(3e-16, "1", "relative step at which it ends")
    direct_spare_half_cycles: int = tuned(9, "half cycles", "beyond those that fit into the time: memory")

    # Motion under a field: driven.py
    driven_steps: int = tuned(48, "steps", "of the integration in a half period")
    driven_half_periods: float = tuned(2.5, "half periods", "until the velocity must have turned")
    driven_rounds: int = tuned(6, "rounds", "until a half period under its own field has the length that was assumed")
    driven_settled: float = tuned(1e-7, "1", "change of a half period in a round, relative, at which the rounds end")
    driven_sticks: float = tuned(1e-4, "1", "phi'/w below which dry friction is a straight line through rest")
    driven_moved: float = tuned(10.0, "1", "times that: what swings less is held")
    driven_tolerances: tuple[float, ...] = tuned(
        (0.0, 0.4, 0.8, 1.2, 1.6), "1", "tolerances above f_nat that are tried, in units of the tolerance"
    )
    driven_weaker: tuple[float, ...] = tuned((1.0, 0.9, 0.8, 0.7), "1", "shares of the push that are tried")
    driven_least_share: float = tuned(0.02, "1", "of the field along v")
    driven_turn_rounds: int = tuned(40, "rounds", "of the rule of false position for the turn")
    driven_turn_speed: float = tuned(1e-14, "1", "phi'/w at which the turn is found")
    driven_turn_time: float = tuned(1e-13, "1", "time times w to which the turn is known")
    driven_moving: float = tuned(1e-12, "1", "phi'/w from which the rotor moves")

    # Envelopes and initial states: quality.py, ring_down.py, mirror.py, orbit.py, rotation.py
    envelope_points_per_period: int = tuned(8, "points", "at which an envelope is computed")
    envelope_first_periods: int = tuned(64, "periods", "of the first envelope; it is doubled until it has decayed")
    envelope_most_periods: int = tuned(2**14, "periods", "after which a motion does not decay")
    envelope_decayed: float = tuned(1e-3, "1", "of the maximum, below which the rest is an exponential")
    envelope_tail_divisor: int = tuned(10, "1", "part of the envelope from which the rate of this exponential is read")
    envelope_least_decay: float = tuned(1e-9, "1", "relative, that an envelope must have")
    envelope_points: int = tuned(1000, "points", "of a published envelope")
    quality_least_exponent: float = tuned(
        1e-12, "1", "from which the equation of the equivalent quality factor is solved"
    )
    quality_error: float = tuned(1e-15, "1", "absolute error of that solution")
    quality_relative_error: float = tuned(1e-12, "1", "relative error of that solution")
    turning_points_per_period: int = tuned(64, "points", "at which turning points are sought")
    anchor_steps: int = tuned(12, "steps", "of Newton's method from a state to the turning point before it")
    anchor_close: float = tuned(1e-13, "1", "step at which it ends, relative to the time")
    mean_rotations: int = tuned(500, "rotations", "that are averaged at once; speed only")
    mean_rounds: int = tuned(10, "rounds", "of a mean over twins at most; two are usual")
    nome_rounds: int = tuned(60, "rounds", "of the inversion of the nome")
    nome_most: float = tuned(0.2, "1", "to which the nome is limited")
    theta_terms: int = tuned(8, "terms", "of the theta series")
    small_rotation_rad: float = tuned(1e-4, "rad", "below which a series replaces the quotient")
    parallel_share: float = tuned(1e-9, "1", "of its length: what is left of u beside v, below which they are parallel")
    most_log_growth: float = tuned(3.0, "1", "of a value that keeps its sign in a step: it grows twentyfold at most")
    singular_pivot: float = tuned(1e-14, "1", "below which a matrix is singular")
