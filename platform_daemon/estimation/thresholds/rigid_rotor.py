"""Tuned numbers of the rotor of five degrees of freedom."""

from __future__ import annotations

from dataclasses import dataclass

from .tuned import false_alarm, tuned

STUDY = "tests/campaigns/perfect_rotors.py"
START = "tests/estimation/rotor_fit/test_fit.py"
AGREEMENT = "tests/estimation/physics/rigid_rotor/test_rotor.py"


@dataclass(frozen=True, kw_only=True)
class RigidRotorThresholds:
    """How finely its motion is computed, and how it is fitted."""

    first_step: float = tuned(0.1, "samples", "first trial of a step")
    safety: float = tuned(0.9, "1", "of the step that would just meet the tolerance")
    shrink: float = tuned(0.2, "1", "least ratio of a step to the one before")
    grow: float = tuned(5.0, "1", "largest ratio of a step to the one before")
    failed_error: float = tuned(
        1e6, "1", "error relative to the tolerance, from which on a step says nothing of the next"
    )
    last_step_share: float = tuned(1e-3, "1", "of a step, by which it may be longer to end where it must")
    shortest_step_s: float = tuned(1e-13, "s", "below which the motion cannot be followed")
    most_steps_per_s: float = tuned(
        3e6, "1/s", "beyond which values are far from any rotor: a jewel takes 8e4, at rest 1.4e6, a thread 2e4"
    )
    settling_s: float = tuned(
        0.02, "s", "added to a motion's own time where its steps are counted: it begins with short ones"
    )
    tolerance: float = tuned(
        1e-9, "1", "error per step of the swing, of 1 for directions and of omega_nat for speeds", AGREEMENT
    )
    contact_tolerance: float = tuned(
        1e-10,
        "1",
        "the same for a jewel, whose contact bounds most steps: with 1e-9 chi^2 of two seconds moved by up to 200 with "
        "the steps, with this by 8, for a tenth more time",
    )
    side_factor: float = tuned(10.0, "1", "times that for what is not the swing", AGREEMENT)
    # By what roots of squares are off where a slow slip, or none, goes beside a spin at each point of a Hertz disc,
    # polynomials in the share of the spin in the square: least squares of the integrals over the disc, good to 1e-3.
    slides_bent: tuple[float, ...] = tuned((0.0640, -0.0424, 0.1118), "1", "of the slip's friction")
    turns_bent: tuple[float, ...] = tuned((0.1360, -0.0990, 0.2132), "1", "of the spin's friction")
    # Friction of a Hertz disc that slips faster than its edge spins, powers 4 to 9 of the root of 1 - (spin / slip)^2:
    # least squares of the closed forms, good to 2e-7.  The first powers follow from value and slope where both are
    # alike: a kink there would make differences of neighbours noisy.
    slipping_force: tuple[float, ...] = tuned(
        (-0.077571466, 0.176058371, -0.23636537, 0.200120927, -0.09697526, 0.020324928), "1", "of the force", AGREEMENT
    )
    slipping_torque: tuple[float, ...] = tuned(
        (0.080912597, -0.177499511, 0.233390844, -0.195180164, 0.093885566, -0.019587171),
        "1",
        "of the torque over mu N a",
        AGREEMENT,
    )
    sticking_per_s: float = tuned(
        5e5,
        "1/s",
        "rate at which a contact that does not spin takes slip back, above which steps are implicit, which takes twice "
        "as long",
        AGREEMENT,
    )
    quiet_per_s: float = tuned(
        3.3e5,
        "1/s",
        "the same above which differences are too noisy to state errors: at 3.9e5 those of a swing that dies were ten "
        "times too small, at 3.3e5 they agree with those of a tenth of the step to 4 %",
        AGREEMENT,
    )
    sticking_tolerance: float = tuned(1e-11, "1", "the same for implicit steps, whose errors add up", AGREEMENT)
    sticking_order: int = tuned(8, "1", "of their extrapolation; 6 takes twice as long, 10 as long", AGREEMENT)
    rest_rounds: int = tuned(25, "rounds", "of Newton's method for the position of rest")
    rest_step: float = tuned(1e-6, "rad", "of its differences")
    rest_close: float = tuned(1e-11, "rad", "step at which it ends")
    rest_farthest: float = tuned(
        0.8, "1", "displacement of the held point over its link, beyond which there is no rest"
    )
    slowest_spin_rad_per_s: float = tuned(
        0.01,
        "rad/s",
        "spin below which any contact creeps, 1e-5 of the swing's speed: a step of the torque at rest would make the "
        "differences of neighbours noisy",
        AGREEMENT,
    )

    least_creep_m_per_s: float = tuned(
        2e-5, "m/s", "slip below which a contact creeps, that no fit goes below: at 3e-6 neighbours cannot be followed"
    )
    most_step_share: float = tuned(
        0.9,
        "1",
        "of itself, by which a step may change a creep: by its logarithm it took 13 steps in place of 9, in one window",
    )
    most_step_ln: float = tuned(0.5, "1", "by which a step may change a logarithm: more leads far starts astray", START)

    # What one angle leaves out: one_angle_error
    usual_side_damping_per_s: float = tuned(5.0, "1/s", "of side modes where no fit tells it", STUDY)
    usual_creep_m_per_s: float = tuned(
        2e-3, "m/s", "slip below which a jewel's contact creeps where no fit tells it", STUDY
    )

    # Least squares: rotor_fit
    step_f_nat_hz: float = tuned(1e-5, "Hz", "of the difference for f_nat")
    step_m_r_am2: float = tuned(3e-7, "A m^2", "of the difference for m_r")
    step_rad: float = tuned(1e-6, "rad", "of the difference for angles and ratios")
    step_s: float = tuned(3e-8, "s", "of the difference for the delay")
    step_per_s: float = tuned(
        3e-6, "1/s", "of the difference for dampings; from ten times that on errors of lambda and T_f/I are a third low"
    )
    step_m: float = tuned(3e-9, "m", "of the difference for a displacement")
    step_speed_rad_per_s: float = tuned(3e-3, "rad/s", "of the difference for the speed at the start")
    step_ln: float = tuned(1e-4, "1", "of the difference for the logarithm of the slip below which a contact creeps")
    step_weak_ln: float = tuned(
        1e-3,
        "1",
        "the same of what moves little: dampings of side modes, and the spin below which a contact creeps",
    )
    creep_spin_sd_ln: float = tuned(
        3.0,
        "1",
        "how well the logarithm of the spin is known below which a jewel's contact creeps: a contact of 20 um that "
        "creeps below 1 mm/s of slip does so below 50 rad/s; other contacts do not tell",
    )
    step_share: float = tuned(1e-4, "1", "of the difference for the axis of the damping")
    damping_axis_sd: float = tuned(0.5, "1", "how well that is known: from the rotor's own, 0, to the thread's, 1")
    radius_sd_share: float = tuned(5e-3, "1", "how well the radius of magnets is known that no file declares")
    link_sd_share: float = tuned(
        2e-2,
        "1",
        "the same for a thread's length and a cup's radius less the magnet's: rotors by others, whose drawing is off "
        "by as much, had their errors 2 to 6 % off, 3 to 20 stated errors",
    )
    creep_sd_ln: float = tuned(1.5, "1", "how well the logarithm of the slip below which a contact creeps is known")
    step_friction_rad_per_s2: float = tuned(3e-3, "rad/s^2", "of the difference for T_f/I, likewise")
    drive_size_sd: float = tuned(0.03, "1", "of the field over the commanded one: transmit calibration and coils")
    drive_delay_sd_s: float = tuned(1e-4, "s", "of the samples against the drive: filters and gates")
    drive_lag_s: float = tuned(
        3e-4, "s", "L/R of Helmholtz pairs of such a size: a sine of whole periods hardly shows it"
    )
    start_sd_rad: float = tuned(0.2, "rad", "of the swing that may be left of the shot before")
    start_side_sd: float = tuned(0.1, "1", "of links and of radians, in side modes of a free start")
    typical_rad_per_s: float = tuned(1300.0, "rad/s", "omega_nat of such a resonator, for the speeds of both")
    # The distance follows from f_nat, m_r and the stator's design moment as its cube root (eq:T_m, eq:omega_nat).  A
    # grade of magnets leaves the remanence open by 1.5 %, 10 K by 1.2 %, a radius of 1.5 mm good to 10 um the volume
    # by 2 %: together 3 %, which is 1 % of the distance of 4.6 mm.
    distance_sd_m: float = tuned(5e-5, "m", "of the magnets' distance by the drawing", "tolerances of the drawing")
    damping_sd_per_s: float = tuned(
        0.5, "1/s", "of lambda: some times that of such resonators, which only keeps the shortest windows from nonsense"
    )
    side_damping_sd_ln: float = tuned(2.0, "1", "how well the logarithms of the side modes' dampings are known")
    friction_coefficient_sd: float = tuned(0.05, "1", "of mu by the materials")
    # If the other one is true, the likelihood of the first over its own is a martingale while the window grows, of mean
    # 1: it ever passes exp(25 / 2) with a probability below exp(-25 / 2) (Ville's inequality).
    rival_chi2: float = tuned(
        25.0, "1", "rise of chi^2 in a window at which another defect is given up", false_alarm("4e-6 over all windows")
    )
    first_window_s: float = tuned(0.05, "s", "of the windows that grow; each is twice the one before")
    predicting_share: float = tuned(
        0.7,
        "1",
        "of the ring-down: the last window but one, which predicts the rest",
        "the split of a single shot in the diagnosis, which scores what is predicted",
    )
    window_growth: float = tuned(2.0, "1", "ratio of a window to the one before")
    shots_at_once: int = tuned(3, "1", "whose Jacobians are computed beside each other: bounds the memory")
    most_steps: int = tuned(40, "steps", "of Gauss-Newton in the last window")
    few_steps: int = tuned(20, "steps", "in the windows before it; from a good start they take 2 to 16", START)
    strong_share: float = tuned(
        1e-4, "1", "of the largest eigenvalue of scaled J^T J, above which a direction leads back to the floor", START
    )
    strong_share_of_several: float = tuned(
        1e-5, "1", "the same for shots together: six of jewel_imperfect take half as many steps as with 1e-4"
    )
    most_returns: int = tuned(8, "steps", "back to the floor after a trial", START)
    acceleration_share: float = tuned(1e-3, "1", "of the largest, below which a singular value of returns counts as 0")
    worth_returning: float = tuned(0.05, "1", "fall of chi^2 over the rise of a trial, worth another step back", START)
    good_fall: float = tuned(0.3, "1", "of the fall that a step promised, at which the next one is damped less")
    first_damping: float = tuned(
        1e-7, "1", "of the step, relative to the diagonal; from 1e-5 or 1e-9 it takes up to twice the steps", START
    )
    first_damping_of_several: float = tuned(
        1e-9, "1", "the same for shots together: twelve of jewel_imperfect take 7 steps, and 10 with 1e-7", START
    )
    damping_grows: float = tuned(4.0, "1", "by which it grows after a failure, twice as much after the next one")
    damping_falls: float = tuned(0.03, "1", "factor of the damping after a good step: trials cost little")
    room_falls: float = tuned(
        0.3, "1", "factor of the largest step of a logarithm after a failure with one that large", START
    )
    least_room: float = tuned(0.03, "1", "of that factor: below it a failure has another cause")
    floor_chi2_per_dof: float = tuned(
        1.1, "1", "below which that is done: further up such short steps do not reach the floor", START
    )
    at_bound: float = tuned(1.0 - 1e-9, "1", "of a bound, from which on a component is at it")
    surely_falls: float = tuned(
        2.0,
        "1",
        "times what a whole step promises, by which chi^2 falls at most: the promise at the start of three windows was "
        "within 1 % of the whole fall",
    )
    near_chi2_per_dof: float = tuned(
        10.0, "1", "below which all parameters go along with one whose step is limited; not so from far starts", START
    )
    least_damping_share: float = tuned(1e-2, "1", "of the first damping, below which it does not fall", START)
    most_damping: float = tuned(1e8, "1", "at which a window that grows ends")
    found_chi2: float = tuned(
        3e-2,
        "1",
        "predicted fall of chi^2 at which a fit ends that is not only to be compared: a sixth of a standard error; "
        "1 left tilts one error low",
        START,
    )
    kept_chi2: float = tuned(
        30.0,
        "1",
        "fall of a step that brought what it promised, up to which a window that grows ends with it: after larger ones "
        "a law of a contact was 30 above its minimum in a window of 0.2 s",
    )
    settled_chi2: float = tuned(1.0, "1", "the same of a window that grows, and of a fit that is only to be compared")
