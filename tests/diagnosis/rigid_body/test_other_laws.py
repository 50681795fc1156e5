"""Other laws of a jewel's contact, and where fits with them begin."""

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from platform_daemon.diagnosis.rigid_body import search
from platform_daemon.diagnosis.rigid_body.other_laws import fits_with_other_laws, is_chance
from platform_daemon.diagnosis.rigid_body.starts import Start, starts_of
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.rotor_fit.fit import fit_rotor
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

RATE_HZ = 12000.0
SD = np.array([3e-3, 4e-3, 1.1e-2])
DRIVE = CoilDrive(field_t=(4.9e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
CONTACT = {"creep_m_per_s": 1e-3, "creep_spin_rad_per_s": 5.0}
TILT = "stator_tilt_rad"


def shot_of(tilt_rad, seconds, **contact):
    specimen = rigid_specimen("jewel", [0.0, 0.0, -9.81], 2.0, defects={TILT: tilt_rad})
    rotor = true_rotor(specimen, DRIVE, **CONTACT | contact)
    samples = rotor.dm_dt(round(seconds * RATE_HZ), RATE_HZ)[0]
    noise = np.random.default_rng(3).normal(size=samples.shape) * SD[:, None]
    return RotorShot(
        samples=samples + noise, rate_hz=RATE_HZ, sd=SD, geometry=rotor.geometry, drive=DRIVE, values=rotor.values,
        declared=rotor.values.rotation,
    )  # fmt: skip


@pytest.fixture
def pool():
    with ThreadPoolExecutor(2) as pool:
        yield pool


@pytest.mark.long
def test_another_law_is_led_from_the_leaders_values_to_what_it_has_from_the_true_ones(pool):
    """The leader has the wrong law in a window that does not tell laws apart."""
    shot = shot_of(0.0148, 0.8)
    wrong = shot.values.with_numbers({"creep_law": 1.0})
    leader = fit_rotor([replace(shot, values=wrong)], TILT, pool)
    right = fit_rotor([shot], TILT, pool)
    start = Start(TILT, shot.values.with_numbers({"friction_coefficient": 0.25, TILT: 0.012}), shot.values)
    assert is_chance(leader)
    (found,) = fits_with_other_laws(shot, [replace(leader, stages=())], [start, start], pool)
    assert found.values[0].creep_law == 0.0
    assert found.total_chi2 == pytest.approx(right.total_chi2, abs=1.0)
    better = replace(leader, chi2=(0.9 * leader.chi2[0],))
    assert fits_with_other_laws(shot, [replace(better, stages=())], [start], pool) == []


@pytest.mark.parametrize(("tilt_rad", "begun_rad"), [(0.012, 0.02), (-0.045, 0.045)])
def test_a_jewel_begins_with_a_large_tilt_where_that_leaves_less(tilt_rad, begun_rad, pool):
    shot = shot_of(tilt_rad, 0.1)
    main_hz = shot.values.f_nat_hz * (1.0 - THRESHOLDS.rigid_body.jewel_softening * tilt_rad**2)
    one_angle = shot.values.with_numbers({TILT: 0.0, "f_nat_hz": main_hz})
    starts = next(starts_of(replace(shot, values=one_angle), pool))
    assert [getattr(start.values, TILT) for start in starts] == [begun_rad, -begun_rad]


def test_noise_is_what_chance_leaves():
    chance = math.sqrt(2.0 / 1e4)
    level = 1.0 + THRESHOLDS.rigid_body.noise_sigma * chance
    assert is_chance(SimpleNamespace(chi2_per_dof=level - 1e-6, dof=(1e4,)))
    assert not is_chance(SimpleNamespace(chi2_per_dof=level + 1e-6, dof=(1e4,)))


@pytest.mark.parametrize(
    ("window_s", "left", "whole", "fitted", "led"),
    [(0.4, 1.0, False, 3, 0), (0.8, 1.0, False, 2, 0), (0.8, 1.5, False, 2, 1), (2.0, 1.0, True, 2, 1)],
)
def test_laws_that_are_not_needed_are_spared_in_long_windows_but_not_at_the_end(
    window_s, left, whole, fitted, led, monkeypatch
):
    values = shot_of(0.01, 0.01).values.with_numbers({TILT: 0.01})
    starts = [
        Start(TILT, values, values),
        Start(TILT, values.with_numbers({"creep_law": 1.0}), values),
        Start(TILT, values.with_numbers({TILT: -0.01}), values),
    ]
    counts, excluded = [], 1.0

    def fit_of(start):
        size = getattr(start.values, TILT)
        return SimpleNamespace(
            defect=TILT, values=(start.values,), strength=(size, 1e-4), dof=(1e4,),
            total_chi2=left * 1e4 + (excluded if size < 0 else 0.0),
            chi2_per_dof=left, stages=(), known=(values,), window_s=window_s,
        )  # fmt: skip

    def fits(_shot, _window_s, tried, _pool, *, whole):
        counts.append(len(tried))
        return [fit_of(start) for start in tried]

    def others(_shot, _leaders, spared, _pool, *, whole):
        counts.append(len(spared))
        return [fit_of(start) for start in spared]

    monkeypatch.setattr(search, "_fits", fits)
    monkeypatch.setattr(search, "fits_with_other_laws", others)
    monkeypatch.setattr(search, "replace", lambda one, **_: one)
    shot = SimpleNamespace(samples=np.zeros((3, 1)), count=lambda _: 1)
    field, spared = search.contest(shot, window_s, starts, [], 2.0, SimpleNamespace(), whole=whole)
    assert counts == [fitted, *([1] if led else [])]
    assert len(field) + len(spared) == 3
    # Where a later window excludes an error and sign, its laws go with it, and none is tried by itself.
    excluded = 1e3
    both = [*spared, Start(TILT, starts[2].values.with_numbers({"creep_law": 1.0}), values)]
    begun = [Start(TILT, c.fit.values[0], c.known, c.stages) for c in field]
    field, spared = search.contest(shot, 1.6, begun, both, 2.0, SimpleNamespace())
    assert all(c.fit.strength[0] > 0.0 for c in field)
    assert all(getattr(start.values, TILT) > 0.0 for start in spared)
