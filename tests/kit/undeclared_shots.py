"""Shots of the simulated platform with undeclared effects, as the diagnosis takes them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.calibration.apply import calibrate
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.record import RingDownRecord
from sim_backend.study import play
from tests.kit.simulated_bench import CLOCK, FIELD_T, Bench, specimen, timeline

STEADY: dict[str, Any] = {
    "effects__temperature__enabled": False,
    "effects__wear__enabled": False,
    "switch__transient_v": [0.0, 0.0, 0.0],
}
SECONDS = {"thread": 2.0, "jewel": 1.6}


def shots_with(
    variant: str,
    undeclared: Sequence[Mapping[str, Any]] = (),
    count: int = 3,
    *,
    rx_s: float | None = None,
    seed: int = 1,
    pose: Sequence[float] | None = None,
    **changes: Any,
) -> tuple[list[DiagnosisShot], list[dict[str, Any]]]:
    """Shots of one series with their truths; undeclared: tables as in the platform's configuration."""
    bench = Bench(None, undeclared=[dict(u) for u in undeclared], seed=seed, **(STEADY | changes))
    rotor = specimen(variant)
    if pose is not None:
        turned = type(rotor.pose)(**rotor.pose.model_dump() | {"rodrigues_rad": list(pose)})
        rotor = rotor.model_copy(update={"pose": turned})
    rx = int((rx_s or SECONDS[variant]) * CLOCK.rate_hz)
    program = timeline(bench.channels[0], FIELD_T[variant], rx=rx)
    sensitivity, noise, records, truths = np.asarray(bench.calibration.sensitivity), SeriesNoise(), [], []
    for shot in play(bench.backend, rotor, program, shots=count, lna_gain=40.0):
        records.append(calibrated_record(bench, shot.volts))
        noise.learn(records[-1])
        truths.append(shot.truth)
    names = [f"shot {k}" for k in range(count)]
    return [
        DiagnosisShot(n, r, noise.for_shot(r).model, sensitivity, variant) for n, r in zip(names, records, strict=True)
    ], truths


def calibrated_record(bench: Bench, volts: NDArray[np.float32]) -> RingDownRecord:
    """dm/dt of one shot, (3, n) V."""
    known = bench.calibration
    sensitivity = np.asarray(known.sensitivity)
    done = calibrate(volts.astype(np.float64), CLOCK.rate_hz, sensitivity, known.frequency_hz, known.frequency_response)
    return RingDownRecord(done.dmdt, CLOCK.rate_hz, "dmdt", valid_from=done.valid_from, valid_to=done.valid_to)
