"""A latched trip of the amplifier, and the command that clears it."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from drivers.errors import DeviceFault, DeviceStateError
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.schemas.requests import AcquisitionRequest, CalibrationRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.calibrate.work import plan_calibration
from tests.kit.acquisitions import SHORT_JEWEL, acquire

TRANSMIT = CalibrationRequest(kind="transmit", frequencies_hz=(212.0, 424.0), repetitions=1)


def world_of(engine: Engine) -> Any:
    return engine.platform.backends["simulated"].world  # type: ignore[attr-defined]


def test_a_reset_clears_the_fault_and_leaves_the_amplifier_off(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with()
    world_of(engine).trip_amplifier()
    assert "fault latched" in str(acquire(engine, tmp_path / "latched.h5").error)
    while engine.status().power_amplifier.fault is None:  # read back after the job
        time.sleep(0.01)
    done = engine.reset_fault()
    assert done.fault == "over-current"
    assert done.power_amplifier.model_dump() | {"temperature_c": None} == {
        "enabled": False, "muted": True, "fault": None, "temperature_c": None, "clipped": False
    }  # fmt: skip
    assert engine.status().power_amplifier.fault is None
    assert acquire(engine, tmp_path / "free.h5").error is None


def test_nothing_clears_a_fault_by_the_way(engine_with: Callable[..., Engine]) -> None:
    engine = engine_with()
    world_of(engine).trip_amplifier()
    engine.outputs_off()
    assert engine.platform.amplifier.status().fault == "over-current"


def test_a_reset_without_a_fault_says_that_there_was_none(engine_with: Callable[..., Engine]) -> None:
    assert engine_with().reset_fault().fault is None


def test_a_fault_whose_cause_persists_stays_latched(engine_with: Callable[..., Engine]) -> None:
    engine = engine_with("backends.simulated.amplifier.trip_temperature_c=10.0")
    world_of(engine).trip_amplifier()
    with pytest.raises(DeviceFault, match="the fault stays: over-temperature"):
        engine.reset_fault()
    assert engine.status().power_amplifier.fault == "over-temperature"


def test_a_reset_is_refused_while_a_series_runs(engine_with: Callable[..., Engine], tmp_path: Path) -> None:
    engine = engine_with('backends.simulated.clock.mode="realtime"')
    request = AcquisitionRequest(**{**SHORT_JEWEL, "shots": 1000})  # type: ignore[arg-type]
    job = engine.submit(series_work(engine, plan_series(engine, request), OwnFile(tmp_path / "long.h5", tmp_path)))
    while "listen" not in job.phase:
        assert not job.ended.wait(timeout=0.01), job.error
    with pytest.raises(DeviceStateError, match="a series or a calibration is running"):
        engine.reset_fault()
    job.request_cancel()
    assert job.ended.wait(timeout=60)
    assert job.error is None


def test_a_transmit_calibration_puts_power_out_and_so_begins_with_the_self_test_too(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with("self_test.enabled=true", "backends.simulated.wiring.factors=[1.0, -1.0, 1.0]")
    job = engine.submit(plan_calibration(engine, TRANSMIT, tmp_path))
    assert job.ended.wait(timeout=60)
    assert "the polarity of y is inverted" in str(job.error)
    assert list(tmp_path.iterdir()) == []
    assert world_of(engine).shots == 1
