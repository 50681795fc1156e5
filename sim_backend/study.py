"""Many shots for a study, without card, engine and file: the same world, as fast as the computer allows.

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
    """One shot.  volts: (3, n) float32 of the RX window at the ADC, V; truth: see `truth.record`."""

    volts: NDArray[np.float32]
    truth: dict[str, Any]


def play(
    backend: SimulatedBackend,
    specimen: Specimen,
    timeline: Timeline,
    shots: int,
    lna_gain: float,
    between_s: float = 15.0,
    *,
    at_rest: bool = True,
) -> Iterator[StudyShot]:
    """Simulate a timeline repeatedly.

    lna_gain: V/V; between_s: world time from the end of a shot to the next, s, at least the dead time of the contacts;
    temperature and mains continue meanwhile; at_rest: the rotor is stopped before every shot, otherwise it goes on
    swinging.  With the clock in mode "fast" this time costs no computing. Raises
    ConfigError for a gain that the LNA does not have or hidden effects that the specimen cannot have, DeviceError if
    the motion cannot be integrated.
    """
    world = backend.world
    backend.lna({"gain": lna_gain})
    world.mount(specimen)
    world.amplifier(enabled=True, muted=False)
    for _ in range(shots):
        if at_rest:
            world.hold_still()
        world.start(timeline)
        setup, result = world.shot_simulator.result()
        truth = world.truth()
        assert truth is not None
        world.clock.sleep(setup.stop_s + between_s)
        yield StudyShot(result.received.volts[:, timeline.rx_start :], truth)
