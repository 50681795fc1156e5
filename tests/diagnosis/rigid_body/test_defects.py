"""Which error of manufacture a shot of a rotor with five degrees of freedom shows, and what acts alike."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from platform_daemon.diagnosis.findings.rotor_parting import PLANS, parting
from platform_daemon.diagnosis.rigid_body.found_error import (
    LATERAL_DISPLACEMENT,
    STATOR_TILT,
    Alike,
    ManufacturingError,
)
from platform_daemon.diagnosis.rigid_body.held_out import HeldOutRotor
from platform_daemon.diagnosis.rigid_body.search import ranked
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.rotor_fit.fit import RotorFitError
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES = 12000.0, 6000
DRIVE = CoilDrive(field_t=(2.4e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
SD = np.array([14e-3, 21e-3, 55e-3])

pytestmark = pytest.mark.long


def shot_with(defects, seed=1, samples=SAMPLES):
    """A thread's shot as a fit of one angle would begin it: moment, frequency and damping off, no error known."""
    rotor = true_rotor(rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects=defects), DRIVE)
    noise = np.random.default_rng(seed).normal(size=(3, samples)) * SD[:, None]
    v = rotor.values
    f_nat_hz, m_r_am2 = v.f_nat_hz - 0.2, 0.9 * v.m_r_am2
    start = replace(
        v,
        f_nat_hz=f_nat_hz,
        m_r_am2=m_r_am2,
        distance_m=rotor.geometry.distance_m(f_nat_hz, m_r_am2),
        lambda_per_s=0.1,
        side_damping_per_s=5.0,
        stator_tilt_rad=0.0,
        bearing_tilt_rad=0.0,
        lateral_displacement_m=0.0,
    )
    seen = rotor.dm_dt(samples, RATE_HZ)[0] + noise
    return RotorShot(
        samples=seen, rate_hz=RATE_HZ, sd=SD, geometry=rotor.geometry, drive=DRIVE, values=start, declared=v.rotation
    )


@pytest.fixture(scope="module")
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


@pytest.mark.parametrize(
    ("defects", "kind", "size"),
    [
        ({"rotor_tilt_rad": -0.037}, "bearing_tilt_rad", -0.037),
        ({"stator_tilt_rad": 0.02}, "stator_tilt_rad", 0.02),
        ({"stator_offset_m": [1.6e-4, 0.0]}, "lateral_displacement_m", 1.6e-4),
    ],
)
def test_a_large_error_of_a_thread_is_among_those_that_the_shot_leaves(defects, kind, size, pool):
    fits = ranked(shot_with(defects), pool)
    assert fits[0].chi2_per_dof == pytest.approx(1.0, abs=0.05)
    (found,) = (f for f in fits if f.defect == kind)
    value, std = found.strength
    assert abs(value - size) < 4 * std < 0.2 * abs(size)
    assert sum(found.chi2) - sum(fits[0].chi2) < 25


def test_what_no_rotor_explains_gets_no_error(pool):
    shot = shot_with({"stator_tilt_rad": 0.01})
    time_s = np.arange(SAMPLES) / RATE_HZ
    beating = shot.samples * (1.0 + 0.5 * np.cos(2.0 * np.pi * 7.0 * time_s))
    with pytest.raises(RotorFitError, match="no manufacturing error explains the first"):
        ranked(replace(shot, samples=beating), pool)


def test_a_rotor_that_leaves_more_than_noise_is_given_up_where_only_noise_will_do(pool):
    shot = shot_with({"stator_tilt_rad": 0.02}, samples=3 * SAMPLES)
    leaves_more = replace(shot, sd=0.8 * shot.sd)  # chi2/dof 1.56
    assert ranked(leaves_more, pool)[0].chi2_per_dof == pytest.approx(1.56, abs=0.05)
    with pytest.raises(RotorFitError, match=r"no manufacturing error explains the first 1\.05 s"):  # of 1.5
        ranked(leaves_more, pool, 1.3)


def named(best, rival):
    """The stator's tilt of one fit, which acts as the displacement of another one."""
    rise = sum(rival.chi2) - sum(best.chi2)
    return ManufacturingError(
        effect=STATOR_TILT,
        strength=best.strength[0],
        std=best.strength[1],
        alike=(Alike(effect=LATERAL_DISPLACEMENT, strength=0.0, std=1.0, rise=rise, fit=rival),),
        fit=best,
        held_out=HeldOutRotor(chi2=(1.0,), dof=(1.0,), squares=(1.0,), energy=(1.0,)),
        before_chi2=0.0,
        parameters={},
    )


def test_measurements_that_would_part_two_errors_are_weighed_by_their_rotors(pool):
    fits = {f.defect: f for f in ranked(shot_with({"stator_tilt_rad": 0.01}), pool)}
    tilt, moved = fits["stator_tilt_rad"], fits["lateral_displacement_m"]
    found = {p.measurement.key: p for p in parting(named(tilt, moved), pool)}
    assert {"more_shots", "twice_the_field", "second_amplitude", "longer_window", "on_its_side"} == set(found)
    assert found["twice_the_field"].expected_sigma > found["second_amplitude"].expected_sigma
    assert found["on_its_side"].separates == ("stator_tilt", "lateral_displacement")
    itself = parting(named(tilt, tilt), pool)
    assert max(p.expected_sigma for p in itself) < 0.1


def test_a_plan_to_which_no_step_follows_is_left_out_and_the_others_are_not(pool, monkeypatch):
    """A field far above the threshold, where steps that lead away from the named rotor promised 900 sigma."""
    fits = {f.defect: f for f in ranked(shot_with({"stator_tilt_rad": 0.01}), pool)}
    rotor = named(fits["stator_tilt_rad"], fits["lateral_displacement_m"])
    before = {p.measurement.key: p.expected_sigma for p in parting(rotor, pool)}

    def strong(shot):
        return replace(shot, drive=replace(shot.drive, field_t=(4e-3, 0.0, 0.0)))

    planned = strong(rotor.fit.shots[0])
    planned.rotor(rotor.fit.values[0]).dm_dt(SAMPLES, RATE_HZ)  # the named rotor is followed there
    monkeypatch.setitem(PLANS, "second_amplitude", strong)
    after = {p.measurement.key: p.expected_sigma for p in parting(rotor, pool)}
    assert set(before) - set(after) == {"second_amplitude"}
    assert after["on_its_side"] == before["on_its_side"]
