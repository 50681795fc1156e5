"""Shots of a series after the first one: friction of another size, and a swing that is left over."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.diagnosis.rigid_body import defects
from platform_daemon.diagnosis.rigid_body.each_shot import each_alone, starts_like
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.rotor_fit.fit import RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ, SAMPLES = 12000.0, 3000
SD = np.array([14e-3, 21e-3, 55e-3])


@pytest.fixture(scope="module")
def pool():
    with ThreadPoolExecutor(2) as made:
        yield made


def shot_of(bearing, defects, seed, field_t, *, start, **values):
    """A shot with its start values at the truth."""
    drive = CoilDrive(
        field_t=(field_t, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058
    )
    rotor = true_rotor(rigid_specimen(bearing, [0.0, 0.0, -9.81], 2.0, defects=defects), drive, **values)
    noise = np.random.default_rng(seed).normal(size=(3, SAMPLES)) * SD[:, None]
    return RotorShot(
        samples=rotor.dm_dt(SAMPLES, RATE_HZ)[0] + noise,
        rate_hz=RATE_HZ,
        sd=SD,
        geometry=rotor.geometry,
        drive=drive,
        values=rotor.values,
        declared=rotor.values.rotation,
        start=start,
    )


def test_a_shot_begins_turned_against_the_first_one_as_one_angle_has_it(pool):
    """With a large error one angle takes both for others, in the same way."""
    first = shot_of("thread", {"stator_tilt_rad": 0.045}, 1, 2e-4, start="rest")
    true_first, wrong = first.values.rotation, rotation_from_rodrigues(np.array([-0.7, -0.7, -1.4]))
    turn = rotation_from_rodrigues(np.array([0.0, 0.0, 0.05]))
    one, other = (replace(first, values=replace(first.values, rotation=r)) for r in (wrong, turn @ wrong))
    begun, _ = starts_like(other, one, [SimpleNamespace(values=[first.values])], pool)
    assert begun.rotation == pytest.approx(turn @ true_first)


@pytest.mark.long
def test_a_jewels_shot_with_other_friction_is_found_from_the_first_one(pool):
    first = shot_of("jewel", {"stator_tilt_rad": 0.0354}, 1, 4.9e-4, start="rest")
    v = first.values
    less = {
        "tf_over_i_rad_per_s2": 0.7 * v.tf_over_i_rad_per_s2,
        "friction_coefficient": 0.7 * v.friction_coefficient,
        "f_nat_hz": v.f_nat_hz + 0.08,
    }
    second = shot_of("jewel", {"stator_tilt_rad": 0.0354}, 2, 4.9e-4, start="swing", **less)
    # One angle tells the ratio of the frictions nearly, and f_nat to a part in ten thousand.
    begun = replace(
        second, values=replace(v, tf_over_i_rad_per_s2=0.72 * v.tf_over_i_rad_per_s2, f_nat_hz=v.f_nat_hz + 0.1)
    )
    # What so short a shot hardly tells is taken as known, as longer ones tell it.
    known = ("distance_m", "side_damping_per_s", "lambda_per_s", "friction_coefficient", "creep_m_per_s")
    alone = fit_rotor([first], "stator_tilt_rad", pool, first_window_s=math.inf, held=known)
    _, other = each_alone([first, begun], alone, pool)
    assert other.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    found, std = other.values[0].tf_over_i_rad_per_s2, other.std[0]["tf_over_i_rad_per_s2"]
    assert abs(found - less["tf_over_i_rad_per_s2"]) < 5 * std + 0.01 * found


@pytest.mark.long
def test_a_shot_that_begins_in_the_swing_of_the_one_before_is_found(pool):
    first = shot_of("thread", {"stator_tilt_rad": 0.01}, 3, 2.4e-4, start="rest")
    left = {"start_angle_rad": -0.2, "start_speed_rad_per_s": 250.0}
    second = shot_of("thread", {"stator_tilt_rad": 0.01}, 4, 2.4e-4, start="swing", **left)
    begun = replace(second, values=first.values)
    alone = fit_rotor([first], "stator_tilt_rad", pool, first_window_s=math.inf)
    _, other = each_alone([first, begun], alone, pool)
    assert other.values[0].start_angle_rad == pytest.approx(-0.2, abs=0.02)
    # So short a first shot tells what is common less well than the second one shows it: only both leave noise.
    both = [replace(fit.shots[0], values=fit.values[0]) for fit in (alone, other)]
    joint = fit_rotor(both, "stator_tilt_rad", pool, first_window_s=math.inf)
    assert joint.chi2_per_dof == pytest.approx(1.0, abs=0.05)
    assert abs(joint.values[1].start_angle_rad + 0.2) < 4.0 * joint.std[1]["start_angle_rad"] < 0.02


@pytest.mark.parametrize("fits", [{"b"}, {"a", "b"}, set()])
def test_the_first_error_that_explains_every_shot_is_put_first(fits, monkeypatch):
    """Where none does, the best of the first shot stays, without a limit of what it leaves in the others."""
    limits = []

    def alone(shots, first, pool, *, most_chi2_per_dof=math.inf):
        limits.append(most_chi2_per_dof)
        if first not in fits and most_chi2_per_dof < math.inf:
            raise RotorFitError("not explained")
        return [first, f"{first} in the second shot"]

    monkeypatch.setattr(defects, "each_alone", alone)
    monkeypatch.setattr(defects, "made_whole", lambda fit, pool: fit)
    order, found = defects.like_the_first(["a", "b"], ["first", "second"], None)
    named = "b" if fits == {"b"} else "a"
    assert (order[0], found[0]) == (named, named)
    assert sorted(order) == ["a", "b"]
    assert limits[-1] == (math.inf if not fits else THRESHOLDS.rigid_body.explained_chi2_per_dof)
