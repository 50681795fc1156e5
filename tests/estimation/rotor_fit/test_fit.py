import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import chi2

from platform_daemon.diagnosis.thresholds import THRESHOLDS as DIAGNOSIS_LIMITS
from platform_daemon.estimation.physics.rigid_rotor.rotor import NO_DRIVE, STARTS, CoilDrive, RigidRotor
from platform_daemon.estimation.rotor_fit.fit import (
    LIMITS,
    RotorFitError,
    exchanged,
    expected_fit,
    fit_rotor,
    made_whole,
    quiet_values,
    with_errors_of_held,
)
from platform_daemon.estimation.rotor_fit.parameters import HELD_WITH_A_DEFECT, free_parameters
from platform_daemon.estimation.rotor_fit.shot import RotorShot, linearised
from platform_daemon.estimation.rotor_fit.valley import Valley
from platform_daemon.estimation.thresholds import THRESHOLDS as FIT_LIMITS
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen
from tests.kit.rotor_shots import shot_of
from tests.kit.simulated_rotors import START_S, TX_S, simulated

RATE_HZ, SAMPLES = 12000.0, 1800
DRIVE = CoilDrive(field_t=(2.15e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
SD = np.array([14e-3, 21e-3, 55e-3])
SHORT_JEWEL = (
    "distance_m",
    "side_damping_per_s",
    "lean_damping_per_s",
    "lambda_per_s",
    "friction_coefficient",
    "creep_m_per_s",
    "creep_spin_rad_per_s",
)


@pytest.fixture
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


def tilted(seed, **values):
    """A thread's shot with a stator tilted by 0.01 rad, and what it was made with."""
    specimen = rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects={"stator_tilt_rad": 0.01})
    rotor = true_rotor(specimen, DRIVE, **values)
    noise = np.random.default_rng(seed).normal(size=(3, SAMPLES)) * SD[:, None]
    samples = rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise
    shot = RotorShot(
        samples=samples, rate_hz=RATE_HZ, sd=SD, geometry=rotor.geometry, drive=DRIVE, values=rotor.values,
        declared=rotor.values.rotation,
    )  # fmt: skip
    return shot, rotor.values


def begun(shot, truth, **other):
    start = replace(truth, f_nat_hz=truth.f_nat_hz + 0.2, m_r_am2=0.99 * truth.m_r_am2, side_damping_per_s=5.0)
    start = replace(start, distance_m=truth.distance_m * (1 - 2e-4))  # by the drawing, at another temperature
    return replace(shot, values=replace(start, stator_tilt_rad=0.02, turn_v_rad=0.0, **other))


@pytest.mark.long
def test_two_shots_together_tell_the_tilt_and_their_own_values_from_a_start_far_off(pool):
    one, truth = tilted(1)
    two, other = tilted(2, f_nat_hz=215.72)
    found = fit_rotor([begun(one, truth), begun(two, other)], "stator_tilt_rad", pool)
    value, std = found.strength
    assert abs(value - 0.01) < 4 * std < 0.004
    assert found.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    for values, errors, wanted in zip(found.values, found.std, (truth, other), strict=True):
        for name in ("f_nat_hz", "m_r_am2", "lambda_per_s"):
            assert abs(getattr(values, name) - getattr(wanted, name)) < 4 * errors[name], name
    assert found.values[0].lambda_per_s == found.values[1].lambda_per_s
    windows = [stage.window_s for stage in found.stages]
    assert windows == sorted(windows)
    assert windows[-1] == pytest.approx(0.7 * SAMPLES / RATE_HZ)
    assert found.places[0]["distance_m"] == found.places[1]["distance_m"]


def test_a_thread_of_another_length_has_its_tilt_right_where_the_drawing_may_be_off(pool):
    """Its side modes tell the length."""
    shot = shot_of("thread", 6000, (2.4e-4, 0.0, 0.0))
    noise = np.random.default_rng(3).normal(size=(3, 6000)) * shot.sd[:, None]
    rotor = RigidRotor(shot.geometry.resized(7.5e-6, -2.4e-4), shot.values, shot.drive)
    made = replace(shot, samples=rotor.dm_dt(6000, shot.rate_hz)[0] + noise)
    by_drawing = fit_rotor([made], "stator_tilt_rad", pool)
    found = fit_rotor([replace(made, geometry=shot.geometry.with_tolerances())], "stator_tilt_rad", pool)
    off = [abs(f.strength[0] - 0.02) / f.strength[1] for f in (by_drawing, found)]
    assert off[0] > 6.0
    assert off[1] < 3.0
    assert found.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    assert abs(found.values[0].link_off_m + 2.4e-4) < 3.0 * found.std[0]["link_off_m"] < 2e-4


@pytest.mark.long
def test_errors_with_those_of_what_is_held_are_those_of_a_fit_in_which_it_is_free(pool):
    """Where both rest on the same shot this is an identity of linear algebra."""
    shot, truth = tilted(6)
    begun_at_truth = [replace(shot, values=truth)]
    free = fit_rotor(begun_at_truth, "stator_tilt_rad", pool, first_window_s=1.0)
    names = ("stator_tilt_rad", "distance_m", "side_damping_per_s")
    rows = [free.places[0][name] for name in names]
    known = free.covariance[np.ix_(rows, rows)]
    held = fit_rotor([replace(shot, values=free.values[0])], None, pool, first_window_s=1.0, held=names)
    whole = with_errors_of_held(held, names, known, pool)
    for name in ("f_nat_hz", "m_r_am2", "lambda_per_s", "turn_v_rad"):
        assert whole.std[0][name] == pytest.approx(free.std[0][name], rel=0.02), name
        assert whole.std[0][name] ** 2 == pytest.approx(whole.covariance[(k := whole.places[0][name]), k])
    assert whole.std[0]["f_nat_hz"] > 1.5 * held.std[0]["f_nat_hz"]


def test_a_fit_for_comparison_is_made_whole_with_what_it_held_and_knew(pool):
    shot, truth = tilted(7)
    off = replace(truth, f_nat_hz=truth.f_nat_hz + 2e-3, drive_size=1.01)
    known = [replace(truth, drive_size=1.02)]
    compared = fit_rotor(
        [replace(shot, values=off)], "stator_tilt_rad", pool, first_window_s=0.1, held=("distance_m",), known=known,
        whole=False,
    )  # fmt: skip
    whole = made_whole(compared, pool)
    assert (compared.whole, whole.whole) == (False, True)
    assert made_whole(whole, pool) is whole
    assert whole.stages == compared.stages != ()
    assert whole.places == compared.places
    assert "distance_m" not in whole.places[0]
    assert whole.known == compared.known == tuple(known)
    assert whole.total_chi2 <= compared.total_chi2
    lost = replace(compared, values=(replace(compared.values[0], stator_tilt_rad=1.5),))
    assert made_whole(lost, pool).values == lost.values


def test_a_start_beyond_any_rotor_is_refused_in_words(pool):
    shot, truth = tilted(3)
    with pytest.raises(RotorFitError, match=r"balance nowhere|cannot be followed"):
        fit_rotor([replace(shot, values=replace(truth, stator_tilt_rad=1.5))], "stator_tilt_rad", pool)


def test_a_creep_moves_by_shares_down_to_its_least_and_a_damping_by_its_logarithm():
    free = {p.name: p for p in free_parameters(shot_of("jewel", 10, (0.0, 0.0, 0.0)).geometry, (), "rest")}
    creep, damping = free["creep_m_per_s"], free["side_damping_per_s"]
    assert creep.moved(1e-3, -0.4) == pytest.approx(6e-4)
    assert creep.moved(1e-3, -3.0) == pytest.approx(1e-4)
    assert creep.moved(1e-4, -3.0) == LIMITS.least_creep_m_per_s
    assert creep.moved(1e-6, -1e-4) == creep.moved(1e-6, 0.0) == 1e-6  # of a model of before
    assert creep.moved(1e-3, creep.apart(1e-3, 1.7e-3)) == pytest.approx(1.7e-3)
    assert damping.moved(2.0, damping.apart(2.0, 3.0)) == pytest.approx(3.0)
    assert damping.moved(2.0, 5.0) == pytest.approx(2.0 * math.exp(0.5))
    assert creep.off(1e-3, 2e-3) == pytest.approx(math.log(2.0))


def test_a_fit_ends_at_once_whose_first_step_does_not_promise_enough(pool, monkeypatch):
    shot, truth = tilted(5)
    made = [replace(shot, values=replace(truth, f_nat_hz=truth.f_nat_hz + 1e-3))]
    least = fit_rotor(made, "stator_tilt_rad", pool, first_window_s=math.inf, whole=False).total_chi2
    trials = []
    trial = Valley.trials
    monkeypatch.setattr(Valley, "trials", lambda *of: trials.append(of) or trial(*of))
    with pytest.raises(RotorFitError, match="another rotor explains"):
        fit_rotor(made, "stator_tilt_rad", pool, first_window_s=math.inf, whole=False, to_beat=0.5 * least)
    assert trials == []
    assert fit_rotor(made, "stator_tilt_rad", pool, first_window_s=math.inf, whole=False, to_beat=1.01 * least)
    assert trials


def test_the_last_window_but_one_ends_where_the_diagnosis_splits_a_single_shot():
    assert FIT_LIMITS.rigid_rotor.predicting_share == DIAGNOSIS_LIMITS.regression.split_share


def test_a_thread_has_no_friction_and_a_shot_after_another_has_its_swing():
    shot, _ = tilted(4)
    names = [p.name for p in free_parameters(shot.geometry, ["bearing_tilt_rad"], "swing")]
    assert "friction_coefficient" not in names
    assert {"bearing_tilt_rad", "start_angle_rad", "start_speed_rad_per_s"} <= set(names)
    jewel = replace(shot.geometry, bearing="jewel")
    assert {"friction_coefficient", "tf_over_i_rad_per_s2"} <= {p.name for p in free_parameters(jewel, (), "rest")}


def test_a_motion_without_a_drive_has_neither_its_size_nor_its_delay():
    shot, _ = tilted(4)
    driven, free = ({p.name for p in free_parameters(shot.geometry, (), start)} for start in ("rest", "free"))
    assert driven - free == {"drive_size", "drive_delay_s"}
    assert free - driven == set(STARTS)
    jewel = {p.name for p in free_parameters(replace(shot.geometry, bearing="jewel"), (), "free")}
    assert set(STARTS) - jewel == {"start_lean_u_rad_per_s", "start_lean_v_rad_per_s"}


@pytest.mark.long
@pytest.mark.parametrize(
    ("bearing", "tilt_rad", "field_t", "held"),
    [
        ("thread", 0.01, 2.15e-4, ()),
        # What so short a shot of a jewel hardly tells is taken as known.
        (
            "jewel",
            0.0354,
            4.9e-4,
            SHORT_JEWEL,
        ),
    ],
)
def test_without_a_known_drive_a_shot_begins_in_any_state_and_tells_the_tilt(bearing, tilt_rad, field_t, held, pool):
    """The motion was driven from rest all the same, and began with side modes."""
    specimen = rigid_specimen(bearing, [0.0, 0.0, -9.81], 5.0, defects={"stator_tilt_rad": tilt_rad})
    rotor = true_rotor(specimen, replace(DRIVE, field_t=(field_t, 0.0, 0.0)))
    noise = np.random.default_rng(8).normal(size=(3, SAMPLES)) * SD[:, None]
    samples, v = rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise, rotor.values
    across, along, _ = v.rotation.T @ samples[:, :5].mean(axis=1) / v.m_r_am2
    angle_rad = math.atan(-across / along)
    start = replace(
        v,
        f_nat_hz=v.f_nat_hz + 0.02,
        stator_tilt_rad=0.97 * tilt_rad,
        start_angle_rad=angle_rad,
        start_speed_rad_per_s=along / math.cos(angle_rad),
    )
    shot = RotorShot(
        samples=samples, rate_hz=RATE_HZ, sd=SD, geometry=rotor.geometry, drive=NO_DRIVE, values=start,
        declared=v.rotation, start="free",
    )  # fmt: skip
    found = fit_rotor([shot], "stator_tilt_rad", pool, held=held)
    assert found.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    value, std = found.strength
    assert abs(value - tilt_rad) < 4 * std < tilt_rad
    assert abs(found.values[0].f_nat_hz - v.f_nat_hz) < 4 * found.std[0]["f_nat_hz"]


@pytest.mark.long
def test_a_contact_that_creeps_at_another_slip_tells_its_losses_all_the_same(pool):
    """Held at the value it begins with, lambda and T_f/I are off by tens of their errors."""
    drive = replace(DRIVE, field_t=(4.9e-4, 0.0, 0.0))
    specimen = rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0, defects={"stator_tilt_rad": 0.0354})
    rotor = true_rotor(specimen, drive, creep_m_per_s=5e-4)
    noise = np.random.default_rng(9).normal(size=(3, 8 * SAMPLES)) * SD[:, None] / 2
    shot = RotorShot(
        samples=rotor.dm_dt(8 * SAMPLES, RATE_HZ)[0] + noise, rate_hz=RATE_HZ, sd=SD / 2, geometry=rotor.geometry,
        drive=drive, values=replace(rotor.values, creep_m_per_s=2e-3), declared=rotor.values.rotation,
    )  # fmt: skip

    def off(fit, name):
        return abs(getattr(fit.values[0], name) - getattr(rotor.values, name)) / fit.std[0][name]

    held = fit_rotor([shot], "stator_tilt_rad", pool, held=["creep_m_per_s"])
    assert min(off(held, name) for name in ("lambda_per_s", "tf_over_i_rad_per_s2")) > 30
    found = fit_rotor([shot], "stator_tilt_rad", pool)
    for name in ("stator_tilt_rad", "f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2", "creep_m_per_s"):
        assert off(found, name) < 4, name


@pytest.mark.long
def test_another_defect_starts_from_what_it_is_to_first_order(pool):
    """In a short window a displacement acts as a tilted stator does."""
    shot, truth = tilted(5)
    found = fit_rotor([replace(shot, values=truth)], "stator_tilt_rad", pool, first_window_s=0.05)
    (values,) = exchanged(found, "lateral_displacement_m", pool)
    assert values.stator_tilt_rad == pytest.approx(0.0, abs=1e-12)
    other = fit_rotor([replace(shot, values=values)], "lateral_displacement_m", pool, first_window_s=0.05)
    assert abs(sum(other.chi2) - sum(found.chi2)) < 25
    assert abs(other.strength[0]) == pytest.approx(1.8e-4, rel=0.2)


@pytest.mark.long
def test_what_is_known_beforehand_need_not_be_what_a_fit_starts_with(pool):
    shot, truth = tilted(6)
    far = replace(truth, distance_m=truth.distance_m + 4 * LIMITS.distance_sd_m)
    at_truth = [replace(shot, values=truth)]
    near = fit_rotor(at_truth, "stator_tilt_rad", pool, first_window_s=math.inf)
    pulled = fit_rotor(at_truth, "stator_tilt_rad", pool, first_window_s=math.inf, known=[far])
    assert pulled.values[0].distance_m > near.values[0].distance_m
    assert sum(pulled.chi2) >= sum(near.chi2)


@pytest.mark.long
def test_lambda_is_true_whichever_axis_it_damps_and_whatever_damps_the_side_modes(pool):
    """Held at the rotor's own axis, lambda is off by many errors, and so little is left that nothing would tell it."""
    specimen = rigid_specimen("thread", [0.0, 0.0, -9.81], 15.0, defects={"rotor_tilt_rad": 0.03})
    drive = replace(DRIVE, field_t=(3e-4, 0.0, 0.0))
    rotor = true_rotor(specimen, drive, damping_axis_to_thread=1.0, lean_damping_per_s=4.0)
    noise = np.random.default_rng(10).normal(size=(3, 8 * SAMPLES)) * SD[:, None] / 3
    start = replace(rotor.values, damping_axis_to_thread=0.5, side_damping_per_s=5.0, lean_damping_per_s=5.0)
    shot = RotorShot(
        samples=rotor.dm_dt(8 * SAMPLES, RATE_HZ)[0] + noise, rate_hz=RATE_HZ, sd=SD / 3, geometry=rotor.geometry,
        drive=drive, values=start, declared=rotor.values.rotation,
    )  # fmt: skip

    def off(fit, name):
        return abs(getattr(fit.values[0], name) - getattr(rotor.values, name)) / fit.std[0][name]

    found = fit_rotor([shot], "bearing_tilt_rad", pool)
    for name in ("bearing_tilt_rad", "f_nat_hz", "m_r_am2", "lambda_per_s", "lean_damping_per_s"):
        assert off(found, name) < 4, name
    assert found.chi2_per_dof == pytest.approx(1.0, abs=0.03)
    own = replace(shot, values=replace(start, damping_axis_to_thread=0.0))
    held = fit_rotor([own], "bearing_tilt_rad", pool, held=["damping_axis_to_thread"])
    assert off(held, "lambda_per_s") > 10


@pytest.mark.long
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ({"creep_law": 1.0}, {"creep_law": 0.0}),
        ({"contact_coupling": 0.0}, {"contact_coupling": 1.0}),
        ({"creep_law": 2.0}, {"creep_law": 0.0}),
        ({"creep_law": 3.0}, {"creep_law": 2.0}),
        ({"creep_law": 4.0}, {"creep_law": 3.0}),
        ({"creep_law": 4.0, "contact_coupling": 0.0}, {"creep_law": 0.0, "contact_coupling": 1.0}),
    ],
)
def test_a_shot_tells_the_law_of_a_contact_and_with_it_all_else_is_true(right, wrong, pool):
    specimen = rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0, defects={"stator_tilt_rad": 0.0354})
    drive = replace(DRIVE, field_t=(4.9e-4, 0.0, 0.0))
    rotor = true_rotor(specimen, drive, **right, creep_m_per_s=1e-3, creep_spin_rad_per_s=20.0)
    noise = np.random.default_rng(11).normal(size=(3, 3 * SAMPLES)) * SD[:, None] / 5
    start = replace(rotor.values, creep_m_per_s=2e-3, creep_spin_rad_per_s=5.0)
    shot = RotorShot(
        samples=rotor.dm_dt(3 * SAMPLES, RATE_HZ)[0] + noise, rate_hz=RATE_HZ, sd=SD / 5, geometry=rotor.geometry,
        drive=drive, values=start, declared=rotor.values.rotation,
    )  # fmt: skip
    found = fit_rotor([replace(shot, values=start.with_numbers(right))], "stator_tilt_rad", pool)
    to_beat = sum(found.chi2) + DIAGNOSIS_LIMITS.selection.told_apart_chi2
    other = replace(shot, values=start.with_numbers(wrong))
    with pytest.raises(RotorFitError, match="another rotor explains"):
        fit_rotor([other], "stator_tilt_rad", pool, first_window_s=math.inf, to_beat=to_beat)
    for name in ("stator_tilt_rad", "f_nat_hz", "m_r_am2", "lambda_per_s", "tf_over_i_rad_per_s2"):
        assert abs(getattr(found.values[0], name) - getattr(rotor.values, name)) < 4 * found.std[0][name], name


@pytest.mark.parametrize("law", [0.0, 1.0, 3.0, 4.0])
def test_errors_of_a_contact_that_sticks_are_those_of_one_that_creeps_more_but_for_its_creep(law, pool):
    """Differences of neighbours that stick hold noise, which counts as knowledge."""
    field_t, names = (4.9e-4, 0.0, 0.0), ("stator_tilt_rad", "f_nat_hz", "m_r_am2", "lambda_per_s")
    sticks = shot_of("jewel", 3000, field_t, creep_law=law, creep_m_per_s=2e-5, creep_spin_rad_per_s=1.0)
    window_s = 3000 / sticks.rate_hz
    quiet = quiet_values(sticks, sticks.values)
    assert quiet.creep_m_per_s == sticks.rotor(sticks.values).least_quiet_creep_m_per_s > 1e-3
    assert quiet_values(sticks, quiet) is quiet
    stated = expected_fit(sticks, "stator_tilt_rad", window_s, pool).std[0]
    moving = expected_fit(replace(sticks, values=quiet), "stator_tilt_rad", window_s, pool).std[0]
    assert {name: stated[name] for name in names} == pytest.approx({name: moving[name] for name in names}, rel=1e-3)
    apart = math.log(quiet.creep_m_per_s / 2e-5)
    assert stated["creep_m_per_s"] == pytest.approx(2e-5 * apart, rel=1e-6)


@pytest.mark.parametrize("name", ["tf_over_i_rad_per_s2", "lambda_per_s"])
def test_differences_are_so_small_that_the_errors_of_losses_do_not_depend_on_them(name, pool):
    """The phase follows friction and damping so fast that ten times the step makes their errors a third too small."""
    shot = shot_of("jewel", 9000, (4.9e-4, 0.0, 0.0), creep_m_per_s=2e-3, creep_spin_rad_per_s=3.0)
    free = free_parameters(shot.geometry, ["stator_tilt_rad"], shot.start)
    stated = []
    for factor in (1.0, 0.3):
        finer = [replace(p, step=factor * p.step) for p in free]
        matrix = linearised(shot, shot.values, finer, 9000 / shot.rate_hz, pool).matrix
        matrix[np.diag_indices(len(free))] += [0.0 if p.sd is None else p.sd**-2 for p in free]
        errors = np.sqrt(np.diag(np.linalg.inv(matrix)))
        stated.append(errors[[p.name for p in free].index(name)])
    assert stated[0] == pytest.approx(stated[1], rel=0.05)


@pytest.mark.parametrize(
    ("defects", "seed"), [({"stator_tilt_rad": 0.01}, 11), ({"rotor_tilt_rad": -0.03}, 12), ({}, 13)]
)
def test_the_bound_of_a_planned_shot_is_what_fits_of_the_simulators_rotor_state_and_how_they_scatter(
    defects, seed, pool
):
    """The simulator's rotor shares no line with that of the fit."""
    rate_hz, samples, fits = 4000.0, 600, 12
    specimen = rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects=defects)
    exact = simulated(specimen, 215e-6, 212.0, samples, rate_hz)
    drive = CoilDrive(
        field_t=(215e-6, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=TX_S, rx_start_s=START_S, lag_s=0.0
    )
    rotor = true_rotor(specimen, drive)
    shot = RotorShot(
        samples=np.zeros_like(exact), rate_hz=rate_hz, sd=SD, geometry=rotor.geometry, drive=drive, values=rotor.values,
        declared=rotor.values.rotation,
    )  # fmt: skip
    bound = expected_fit(shot, None, samples / rate_hz, pool, held=HELD_WITH_A_DEFECT).std[0]
    rng, off = np.random.default_rng(seed), []
    told = ("f_nat_hz", "m_r_am2", "lambda_per_s", "turn_u_rad", "turn_v_rad", "turn_w_rad")
    for _ in range(fits):
        noisy = replace(shot, samples=exact + SD[:, None] * rng.standard_normal(exact.shape))
        found = fit_rotor([noisy], None, pool, first_window_s=1.0, held=HELD_WITH_A_DEFECT)
        wider = math.sqrt(max(1.0, found.chi2_per_dof))
        assert {name: std / wider for name, std in found.std[0].items()} == pytest.approx(bound, rel=0.02)
        off.append([(getattr(found.values[0], n) - getattr(rotor.values, n)) / bound[n] for n in told])
    squares = np.sum(np.square(off), axis=0)
    low, high = chi2.ppf([1e-4, 1.0 - 1e-4], fits)
    assert np.all((low < squares) & (squares < high)), dict(zip(told, squares / fits, strict=True))
