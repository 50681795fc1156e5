"""Swapping the wire changes nothing above it: a shot over emulated wires is what it is in the simulation.

What the two worlds would do differently by themselves (temperature and friction that vary with time) is switched off.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from drivers.registry import build_platform
from platform_daemon.core.command_line.parsing import parse_window
from platform_daemon.core.settings import load_platform, load_sequence, load_specimen
from platform_daemon.features.acquire.series_records import store_calibration
from platform_daemon.features.fit.fit import fit_frame
from platform_daemon.features.fit.fit_request import FitRequest
from sequences.compiler import TransmitSide, compile_shot
from tests.kit.emulated_lab import watched_shot

STEADY = ("effects.temperature.enabled=false", "effects.friction_scatter.enabled=false", "effects.wear.enabled=false")
RX_S = 0.6


def shot_of(platform, limits, name):
    """One shot of a resonator, and its fit."""
    side = TransmitSide(platform.transmit, platform.card.capabilities(), platform.switch.timing(), limits)
    plan = compile_shot(load_sequence(name).model_copy(update={"rx_s": RX_S}), side)
    raw = watched_shot(platform, plan)
    assert raw.reason is None
    rx = raw.volts[:, plan.timeline.rx_start :].astype(np.float64)
    ask = FitRequest(name, parse_window("0.5"))
    return plan.timeline, fit_frame(rx, plan.timeline.clock.rate_hz, store_calibration(platform), ask)


@pytest.mark.parametrize("name", ["thread", "jewel"])
def test_timing_is_the_same_and_the_fits_agree_within_their_errors(lab_of_its_own, name):
    lab = lab_of_its_own(f'specimen="../resonators/{name}.toml"', *(f"world.{s}" for s in STEADY))
    over_wires = lab.platform()
    found_timeline, found = shot_of(over_wires, lab.file().limits, name)
    over_wires.close()
    file = load_platform(
        "simulated",
        ["io_card.step_samples=16", f"io_card.output_step_v={1 / 32767}", *(f"backends.simulated.{s}" for s in STEADY)],
    )
    in_process = build_platform(file.section)
    in_process.mount(load_specimen(name)[0])
    wanted_timeline, wanted = shot_of(in_process, file.limits, name)
    in_process.close()
    assert found_timeline == wanted_timeline
    assert found.parameters
    for key, value in wanted.parameters.items():
        other = found.parameters[key]
        if value.std:
            assert abs(other.value - value.value) < 5 * math.hypot(value.std, other.std), key
    assert lab.violations() == ()
