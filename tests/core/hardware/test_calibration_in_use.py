"""A daemon that runs changes its calibration when it is told to, and only then."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.errors import ConfigError, DeviceStateError, InputError, SequenceRejected
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.recordings.calibrations import read_transmit_calibration
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.calibrations import CalibrationsInUse
from platform_daemon.core.schemas.requests import AcquisitionRequest, ActivationRequest, CalibrationRequest
from platform_daemon.features.acquire.destination import OwnFile
from platform_daemon.features.acquire.series_plan import plan_series, series_work
from platform_daemon.features.calibrate.work import plan_calibration
from tests.kit.acquisitions import SHORT_JEWEL, acquire
from tests.kit.data import DATA

WEAK = "backends.simulated.wiring.factors=[0.8, 1.0, 1.0]"


def made(engine: Engine, folder: Path, kind: str) -> str:
    """The name of a calibration that a job of this engine has written."""
    request = CalibrationRequest(kind=kind, name="lab", frequencies_hz=(212.0, 424.0), repetitions=1)  # type: ignore[arg-type]
    job = engine.submit(plan_calibration(engine, request, folder))
    assert job.ended.wait(timeout=60)
    assert job.error is None
    return str(job.result.root.calibration)


def stored(path: Path) -> str | None:
    """The receive calibration that a recording was made with."""
    found = open_recording(path).calibration
    return None if found is None else found.identifier


def adopt(engine: Engine, folder: Path, kind: str, calibration: str | None = None) -> CalibrationsInUse:
    return engine.activate(ActivationRequest(kind=kind, calibration=calibration), folder)  # type: ignore[arg-type]


def test_a_series_uses_the_old_calibration_until_the_new_one_is_adopted(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with()
    old = engine.platform.calibration.identifier
    name = made(engine, tmp_path, "receive")
    acquire(engine, tmp_path / "before.h5")
    assert stored(tmp_path / "before.h5") == old
    assert adopt(engine, tmp_path, "receive", name).calibration.id == name
    assert engine.status().calibration.id == name
    job = acquire(engine, tmp_path / "after.h5")
    assert stored(tmp_path / "after.h5") == name
    assert job.result.fit.calibration == name
    assert stored(tmp_path / "before.h5") == old


def test_an_adopted_transmit_side_decides_the_currents_of_the_next_series(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with(WEAK)
    request = AcquisitionRequest(**SHORT_JEWEL)  # type: ignore[arg-type]
    declared = plan_series(engine, request).excited.currents_a()["x"]
    name = made(engine, tmp_path, "transmit")
    assert plan_series(engine, request).excited.currents_a()["x"] == declared
    adopt(engine, tmp_path, "transmit", name)
    assert plan_series(engine, request).excited.currents_a()["x"] == pytest.approx(declared / 0.8, rel=2e-3)
    acquire(engine, tmp_path / "jewel.h5", window=None)
    assert read_transmit_calibration(tmp_path / "jewel.h5").identifier == name


def test_a_plan_made_before_is_not_played_with_the_new_transmit_side(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with(WEAK)
    plan = plan_series(engine, AcquisitionRequest(**SHORT_JEWEL))  # type: ignore[arg-type]
    adopt(engine, tmp_path, "transmit", made(engine, tmp_path, "transmit"))
    with pytest.raises(DeviceStateError, match="request the series again"):
        engine.submit(series_work(engine, plan, OwnFile(tmp_path / "jewel.h5", tmp_path)))


def test_a_file_that_was_replaced_by_hand_is_read_anew_when_asked(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    writer = engine_with()
    first, second = made(writer, tmp_path, "receive"), made(writer, tmp_path, "receive")
    named = tmp_path / "named.h5"
    shutil.copy(tmp_path / f"{first}.h5", named)
    engine = engine_with(f'calibration={{file="{named}"}}')
    shutil.copy(tmp_path / f"{second}.h5", named)
    acquire(engine, tmp_path / "before.h5", window=None)
    assert stored(tmp_path / "before.h5") == first
    adopt(engine, tmp_path, "receive")
    acquire(engine, tmp_path / "after.h5", window=None)
    assert stored(tmp_path / "after.h5") == second


def test_nothing_is_adopted_under_a_series_that_runs_or_waits(
    engine_with: Callable[..., Engine], tmp_path: Path
) -> None:
    engine = engine_with('backends.simulated.clock.mode="realtime"')
    request = AcquisitionRequest(**{**SHORT_JEWEL, "shots": 1000})  # type: ignore[arg-type]
    job = engine.submit(series_work(engine, plan_series(engine, request), OwnFile(tmp_path / "long.h5", tmp_path)))
    before = engine.platform.calibration
    shutil.copy(DATA / "example_jewel.mmr.h5", tmp_path / "lab@1_20260101.h5")
    with pytest.raises(DeviceStateError, match="runs or waits"):
        adopt(engine, tmp_path, "receive", "lab@1_20260101")
    job.request_cancel()
    assert job.ended.wait(timeout=60)
    assert engine.platform.calibration is before


class TestRefused:
    @pytest.fixture
    def engine(self, engine_with: Callable[..., Engine]) -> Engine:
        return engine_with()

    def refused(self, engine: Engine, folder: Path, kind: str, name: str | None, said: str) -> None:
        before = engine.platform.calibration, engine.platform.transmit_calibration, engine.side
        with pytest.raises(InputError, match=said):
            adopt(engine, folder, kind, name)
        assert (engine.platform.calibration, engine.platform.transmit_calibration, engine.side) == before

    def test_a_calibration_that_does_not_exist(self, engine: Engine, tmp_path: Path) -> None:
        self.refused(engine, tmp_path, "receive", "lab@7_20260101", "lab@7_20260101")

    def test_the_platforms_own_file_if_it_names_none(self, engine: Engine, tmp_path: Path) -> None:
        self.refused(engine, tmp_path, "transmit", None, "names no file")

    def test_the_other_kind(self, engine: Engine, tmp_path: Path) -> None:
        name = made(engine, tmp_path, "receive")
        self.refused(engine, tmp_path, "transmit", name, "transmit side")

    def test_another_gain(self, engine: Engine, tmp_path: Path) -> None:
        name = made(engine, tmp_path, "receive")
        with h5py.File(tmp_path / f"{name}.h5", "r+") as file:
            file["calibration/lna_gain"][...] = 10.0
        self.refused(engine, tmp_path, "receive", name, "LNA gain of 10")

    def test_another_number_of_channels(self, engine: Engine, tmp_path: Path) -> None:
        name = made(engine, tmp_path, "receive")
        with h5py.File(tmp_path / f"{name}.h5", "r+") as file:
            group = file["calibration"]
            four = np.vstack([group["sensitivity"][()], group["sensitivity"][:1]])
            for each in ("sensitivity", "frequency_response", "frequency"):
                if each in group:
                    del group[each]
            group["sensitivity"] = four
        self.refused(engine, tmp_path, "receive", name, "4 channels")

    def test_other_coils(self, engine: Engine, tmp_path: Path) -> None:
        name = made(engine, tmp_path, "transmit")
        engine.platform.transmit = engine.platform.transmit[::-1]
        with pytest.raises(ConfigError, match="for the coils x, y, z"):
            adopt(engine, tmp_path, "transmit", name)

    def test_a_transmit_side_with_which_the_self_test_leaves_the_limits(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        name = made(engine_with(), tmp_path, "transmit")
        path = tmp_path / f"{name}.h5"
        with h5py.File(path, "r+") as file:
            inductance = next(d for d in _datasets(file) if d.name.endswith("/inductance"))
            inductance[...] = 1e-9
        engine = engine_with("self_test.enabled=true", "self_test.amplifier_v=8.0", "limits.max_coil_current_a=1.0")
        side = engine.side
        with pytest.raises(SequenceRejected):
            adopt(engine, tmp_path, "transmit", name)
        assert engine.side is side
        assert engine.platform.transmit_calibration is None


def _datasets(file: h5py.File) -> list[h5py.Dataset]:
    found: list[h5py.Dataset] = []
    file.visititems(lambda _, each: found.append(each) if isinstance(each, h5py.Dataset) else None)
    return found
