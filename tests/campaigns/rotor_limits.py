"""From which window on the distance of the magnets may be free: fits of tilted threads that begin off the truth.

Each thread is drawn (tilt, field, noise, and by how much the start values are off) and fitted with the distance free
from a window of each length on; in the last window it is free in all of them.
python -m tests.campaigns.rotor_limits [--threads N]
"""

from __future__ import annotations

import argparse
import math
import time
from concurrent.futures import Executor, ThreadPoolExecutor
from dataclasses import replace
from unittest.mock import patch

import numpy as np

from platform_daemon.estimation.physics.rigid_rotor.rotor import CoilDrive
from platform_daemon.estimation.rotor_fit import parameters
from platform_daemon.estimation.rotor_fit.fit import RotorFitError, fit_rotor
from platform_daemon.estimation.rotor_fit.shot import RotorShot
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rigid_rotors import rigid_specimen

FROM_S = (0.0, 0.15, 0.5)
RATE_HZ, SAMPLES = 6000.0, 3600
DRIVE = CoilDrive(field_t=(2.15e-4, 0.0, 0.0), frequency_hz=212.0, phase_rad=0.0, duration_s=0.047, rx_start_s=0.058)
SD = np.array([14e-3, 21e-3, 55e-3])  # of the paper, at about its rate
CONVERGED = 1.1  # chi2/dof


def drawn(seed: int) -> RotorShot:
    """A thread with a tilted stator, and start values such as a fit of one angle gives, the distance by the drawing."""
    rng = np.random.default_rng(seed)
    tilt = math.radians(rng.uniform(0.2, 3.0)) * rng.choice([-1.0, 1.0])
    specimen = rigid_specimen("thread", [0.0, 0.0, -9.81], 22.0, defects={"stator_tilt_rad": tilt})
    drive = replace(DRIVE, field_t=(float(rng.uniform(80e-6, 270e-6)), 0.0, 0.0))
    truth = true_rotor(specimen, drive)
    samples = truth.dm_dt(SAMPLES, RATE_HZ)[0] + rng.normal(size=(3, SAMPLES)) * SD[:, None]
    v, limits = truth.values, parameters.LIMITS
    begun = replace(
        v,
        f_nat_hz=v.f_nat_hz + rng.normal() * 0.1,
        m_r_am2=v.m_r_am2 * (1.0 + 0.005 * rng.normal()),
        distance_m=v.distance_m + limits.distance_sd_m * rng.normal(),
        side_damping_per_s=5.0,
        stator_tilt_rad=0.5 * tilt,
    )
    return RotorShot(
        samples=samples, rate_hz=RATE_HZ, sd=SD, geometry=truth.geometry, drive=drive, values=begun, moving=False
    )


def outcome(shot: RotorShot, from_s: float, pool: Executor) -> str:
    """chi2/dof over the whole window, and how far the distance went from the drawing, in its standard deviations."""
    limits = parameters.LIMITS
    with patch.object(parameters, "LIMITS", replace(limits, distance_from_s=from_s)):
        try:
            fit = fit_rotor([shot], "stator_tilt_rad", pool)
        except RotorFitError as failed:
            return f"fails: {failed}"
    away = (fit.values[0].distance_m - shot.values.distance_m) / limits.distance_sd_m
    said = "" if fit.chi2_per_dof < CONVERGED else "not found: "
    return f"{said}{fit.chi2_per_dof:.3f}, {away:+.1f} sd"


def main() -> None:
    """A line per thread."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--threads", type=int, default=10)
    count = parser.parse_args().threads
    found = dict.fromkeys(FROM_S, 0)
    with ThreadPoolExecutor(2) as pool:
        for seed in range(count):
            shot, told = drawn(seed), []
            for from_s in FROM_S:
                began = time.process_time()
                said = outcome(shot, from_s, pool)
                found[from_s] += said[0].isdigit()
                told.append(f"{said} ({time.process_time() - began:.1f} s)")
            print(f"{seed}: {'; '.join(f'from {a:g} s: {b}' for a, b in zip(FROM_S, told, strict=True))}", flush=True)
    print(f"found of {count}: {', '.join(f'{n} from {a:g} s' for a, n in found.items())}")


if __name__ == "__main__":
    main()
