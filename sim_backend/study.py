"""Shots for a study, without card, engine and file: the same world, as fast as it can be computed.

backend = SimulatedBackend(tables["backends"]["simulated"] | {"undeclared": [{"id": "quadratic_drag", ...}]})
calibration = backend.receive_calibration(...)
for shot in play(backend, specimen, timeline, shots=12, lna_gain=40.0): ...
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from drivers.specimen import Specimen
from drivers.timeline import Timeline
from sim_backend.backend import SimulatedBackend


@dataclass(frozen=True)
class StudyShot:
    """volts: (3, n) float32 of the RX window, V at the ADC; truth: see `truth.record`."""

    volts: NDArray[np.float32]
    truth: dict[str, Any]


def play(
    backend: SimulatedBackend,
    specimen: Specimen,
    timeline: Timeline,
    shots: int,
    lna_gain: float,
    between_s: float = 15.0,
) -> Iterator[StudyShot]:
    """Play a timeline again and again on a rotor that is stopped before every shot.

    between_s: world time from the end of a shot to the next, in which temperature and mains run on and the contacts go
    home (their dead time at least); it costs no computing with the clock in mode "fast".
    Raises ConfigError for a gain the LNA does not have or a specimen that the undeclared effects do not fit,
    DeviceError if the motion cannot be followed.
    """
    world = backend.world
    backend.lna({"gain": lna_gain})
    world.mount(specimen)
    world.amplifier(enabled=True, muted=False)
    for _ in range(shots):
        world.hold_still()
        world.start(timeline)
        setup, result = world.player.result()
        truth = world.truth()
        assert truth is not None
        world.clock.sleep(setup.stop_s + between_s)
        yield StudyShot(result.heard.volts[:, timeline.rx_start :], truth)
