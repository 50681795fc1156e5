"""Calibrations of the simulated platform against what its world is made of."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2

from drivers.errors import ConfigError, InputError, SequenceRejected
from drivers.uncertainty import DeclaredUncertainty
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.recordings.calibrations import read_transmit_calibration
from platform_daemon.core.recordings.reader import open_recording, read_calibration
from platform_daemon.core.schemas.calibrations import ComplexTable
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.schemas.requests import CalibrationRequest
from platform_daemon.features.budget.influences import effects_of
from platform_daemon.features.budget.work import parts_of_shot
from platform_daemon.features.calibrate.work import plan_calibration
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement
from sim_backend.receive.response import frequency_response
from sim_backend.transmit.coils import sensitivity_t_per_a
from tests.kit.acquisitions import acquire

MADE_OTHERWISE = (
    "backends.simulated.coils.x.axis_error_rad=[0.0, 0.03, -0.02]",
    "backends.simulated.coils.z.offset_m=[0.003, 0.001, -0.002]",
    'backends.simulated.receive.chain="non_ideal"',
    "backends.simulated.noise.colour.enabled=true",
)
FEW = (212.0, 424.0, 848.0, 1696.0)


def calibrated(engine: Engine, folder: Path, **keys: Any) -> Job:
    job = engine.submit(plan_calibration(engine, CalibrationRequest(**{"frequencies_hz": FEW, **keys}), folder))
    assert job.ended.wait(timeout=120)
    return job


def true_p(engine: Engine, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    """(channel, 3, k), V/(A m^2/s), at the centre."""
    backend: Any = engine.platform.backends["simulated"]
    response = frequency_response(backend.options.receive.in_place(), frequency_hz)
    fields = sensitivity_t_per_a(backend.options.coils, np.zeros(3))
    return np.asarray(engine.platform.lna.gain() * fields[:, :, None] * response[:, None, :])


def true_field_per_volt(engine: Engine, frequency_hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    options: Any = engine.platform.backends["simulated"].options  # type: ignore[attr-defined]
    rows = []
    for coil, field in zip(options.coils.in_order(), sensitivity_t_per_a(options.coils, np.zeros(3)), strict=True):
        ohm = coil.resistance_ohm + options.amplifier.output_impedance_ohm
        current = options.amplifier.gain / (ohm + 2j * np.pi * frequency_hz * coil.inductance_h)
        rows.append(np.outer(field, current))
    return np.array(rows)


def assert_scatters_as_said(off: NDArray[np.complex128], std: NDArray[np.float64]) -> None:
    """Complex deviations that are neither larger nor smaller than their standard deviations say."""
    total = float(np.sum(np.abs(off) ** 2 / std**2))
    assert chi2.ppf(1e-4, 2 * off.size) < total < chi2.isf(1e-4, 2 * off.size) * 1.1


def undeclared_is_known_by_the_calibration(path: Path, told: dict[str, Any]) -> None:
    """Where nobody declares gains and angles, a budget has those that the calibration measured."""
    given = parts_of_shot(open_measurement(path), 0, FitRequest("jewel", "n50")).given
    found = {each.name: each for each in effects_of(replace(given, declared=DeclaredUncertainty()))}
    for name in ("gain of channel z", "phase of channel x", "orthogonality of coil x and y"):
        known = found[name].known
        assert known is not None
        assert (known.u, known.kind) == (told[name].u, told[name].type)
        assert known.source.startswith("calibration receive@1_")
    assert found["gain of channel x"].known.dof == 8.0  # type: ignore[union-attr]
    assert found["orthogonality of coil y and z"].known.dof == math.inf  # type: ignore[union-attr]
    assert found["sample clock"].known is None


def parts(found: ComplexTable) -> tuple[NDArray[np.complex128], NDArray[np.float64]]:
    return np.array(found.real) + 1j * np.array(found.imag), np.array(found.std)


class TestReceive:
    @pytest.mark.parametrize("seed", [3, 4])
    def test_finds_p_within_its_uncertainty(
        self, engine_with: Callable[..., Engine], tmp_path: Path, seed: int
    ) -> None:
        engine = engine_with(*MADE_OTHERWISE, f"backends.simulated.seed={seed}")
        job = calibrated(engine, tmp_path, kind="receive")
        assert job.error is None
        p, std = parts(job.result.root.p_t_per_a)
        assert_scatters_as_said(p - true_p(engine, np.array(job.result.root.frequency_hz)), std)
        assert job.result.root.chi2_per_dof == pytest.approx(1, abs=0.6)
        assert job.warnings == []

    def test_sensitivity_times_response_is_p_in_the_file(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(*MADE_OTHERWISE)
        job = calibrated(engine, tmp_path, kind="receive", name="lab")
        c = read_calibration(tmp_path / job.result.root.file)
        assert c.frequency_hz is not None
        assert c.frequency_response is not None
        assert c.sensitivity_std is not None
        truth = true_p(engine, c.frequency_hz)
        product = c.sensitivity[:, :, None] * c.frequency_response[:, None, :]
        assert np.max(np.abs(product - truth) / np.max(np.abs(truth), axis=(1, 2))[:, None, None]) < 5e-3
        assert np.all(c.sensitivity_std >= 1e-3 * np.abs(c.sensitivity))  # the dipole is not known better
        assert (c.valid_hz, c.lna_gain) == ((212.0, 1696.0), 40.0)
        assert c.temperature_c is not None
        assert c.valid_c is not None
        assert c.valid_c[0] < c.temperature_c < c.valid_c[1]
        assert c.identifier == job.result.root.calibration

    def test_every_run_makes_a_new_version_and_changes_no_old_one(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with()
        first = calibrated(engine, tmp_path, kind="receive").result.root.file
        before = (tmp_path / first).read_bytes()
        second = calibrated(engine, tmp_path, kind="receive").result.root.file
        assert first.startswith("receive@1_")
        assert second.startswith("receive@2_")
        assert (tmp_path / first).read_bytes() == before
        assert len(list(tmp_path.iterdir())) == 2

    def test_a_tilted_dipole_tilts_p_by_what_its_direction_is_known_to(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(
            "reference_dipole.tilt_rad=[0.004,0.0,0.0]", "reference_dipole.direction_std_rad=4e-3",
            "reference_dipole.standard={frequency_hz=1000.0, relative_std=1e-8, clock_error=2e-5}",
        )  # fmt: skip
        made = calibrated(engine, tmp_path, kind="receive", frequencies_hz=(848.0, 1696.0), repetitions=1).result.root
        angle = made.sensitivity_t_per_a[2][1] / made.sensitivity_t_per_a[2][2]
        assert angle == pytest.approx(0.004, abs=2e-3)
        told = {each.name: each.u for each in made.uncertainty}
        assert told["orthogonality of coil z and y"] == 4e-3
        assert told["sample clock"] == pytest.approx(2e-5, abs=4e-7)
        source = next(each.source for each in made.uncertainty if each.name == "sample clock")
        assert float(source.partition("fast by ")[2].split()[0]) == pytest.approx(2e-5, abs=4e-7)
        assert len(told) == 7  # one shot of each kind says nothing of how it repeats

    def test_exchanged_axes_are_told(self, engine_with: Callable[..., Engine], tmp_path: Path) -> None:
        engine = engine_with()
        declared = engine.platform.calibration
        object.__setattr__(declared, "sensitivity", declared.sensitivity[[0, 2, 1]])
        job = calibrated(engine, tmp_path, kind="receive")
        assert [w for w in job.warnings if "channel 1 hears axis y, not z" in w]

    def test_a_cancelled_calibration_leaves_no_file(self, engine_with: Callable[..., Engine], tmp_path: Path) -> None:
        engine = engine_with('backends.simulated.clock.mode="realtime"')
        job = engine.submit(plan_calibration(engine, CalibrationRequest(kind="receive"), tmp_path / "made"))
        job.request_cancel()
        assert job.ended.wait(timeout=30)
        assert job.state is JobState.CANCELLED
        assert not (tmp_path / "made").exists()

    def test_waits_for_an_operator_who_turns_the_dipole(
        self, engine_with: Callable[..., Engine], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        engine = engine_with()
        dipole = engine.platform.reference
        assert dipole is not None
        turn, asked = dipole.turn, []
        monkeypatch.setattr(dipole, "turn", lambda axis: asked.append(axis) or not turn(axis))
        job = engine.submit(
            plan_calibration(engine, CalibrationRequest(kind="receive", frequencies_hz=(212.0, 424.0)), tmp_path)
        )
        for axis in "xyz":
            while job.question is None or job.proceed.is_set() or f"along {axis}" not in job.question:
                assert not job.ended.wait(timeout=0.01), job.error
            assert asked[-1] == axis
            job.proceed.set()
        assert job.ended.wait(timeout=60)
        assert job.error is None


class TestFitsWithIt:
    def test_a_ring_down_gives_the_right_moment_and_stores_the_calibration(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        wide = (100.0, 212.0, 424.0, 636.0, 1272.0, 2544.0, 5000.0, 8000.0)
        bench = engine_with(*MADE_OTHERWISE, "reference_dipole.direction_std_rad=2e-3")
        made = calibrated(bench, tmp_path, kind="receive", frequencies_hz=wide).result.root
        files = (f'calibration={{file="{tmp_path / made.file}"}}',)
        engine = engine_with(*MADE_OTHERWISE, *files)
        job = acquire(engine, tmp_path / "jewel.h5")
        assert job.error is None
        frame = job.result.fit.frames[0]
        truth = engine.platform.ground_truth()["simulated"]["m_r_am2"]  # type: ignore[index]
        assert frame.warnings == ()
        worst = max(np.diag(made.sensitivity_std_t_per_a) / np.abs(np.diag(made.sensitivity_t_per_a)))
        off = frame.parameters["m_r_am2"].value / truth - 1
        assert abs(off) < 4 * np.hypot(worst, frame.parameters["m_r_am2"].std / truth)
        stored = open_recording(tmp_path / "jewel.h5").calibration
        assert stored is not None
        assert (stored.identifier, stored.valid_hz) == (made.calibration, tuple(made.valid_hz))
        np.testing.assert_array_equal(stored.sensitivity, np.array(made.sensitivity_t_per_a))
        np.testing.assert_array_equal(stored.p_std, np.array(made.p_t_per_a.std))
        assert stored.relative_std == made.relative_std > 0
        told_by = {each.name: each for each in made.uncertainty}
        assert {each.name: each.u for each in stored.influences} == {each.name: each.u for each in made.uncertainty}
        undeclared_is_known_by_the_calibration(tmp_path / "jewel.h5", told_by)
        told = frame.systematic_std["m_r_am2"] / truth
        assert made.relative_std <= told < 3 * worst
        assert job.result.fit.systematic_std["m_r_am2"] == pytest.approx(frame.systematic_std["m_r_am2"])

    def test_use_outside_its_frequencies_and_temperatures_is_a_typed_warning(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        made = calibrated(
            engine_with(), tmp_path, kind="receive", frequencies_hz=(100.0, 300.0), temperature_span_c=0.5
        ).result.root
        warm = ("backends.simulated.effects.temperature.mean_c=30.0",)
        job = acquire(engine_with(f'calibration={{file="{tmp_path / made.file}"}}', *warm), tmp_path / "jewel.h5")
        types = {w.partition(":")[0] for w in job.result.fit.frames[0].warnings}
        assert {"calibration_frequency", "calibration_temperature"} <= types

    def test_another_gain_is_a_typed_warning_of_a_later_fit(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        from platform_daemon.features.fit.fit import fit_measurement
        from platform_daemon.features.fit.measurement import VoltageMeasurement

        at_10 = engine_with("lna.gain=10.0", "calibration.lna_gain=10.0")
        made = calibrated(at_10, tmp_path, kind="receive").result.root
        acquire(engine_with(), tmp_path / "jewel.h5", window=None)
        recording = open_recording(tmp_path / "jewel.h5")
        other = recording.with_calibration(read_calibration(tmp_path / made.file))
        said = fit_measurement(VoltageMeasurement.of(other), FitRequest("jewel")).frames[0].warnings
        assert [w for w in said if w.startswith("calibration_gain:")]
        own = fit_measurement(VoltageMeasurement.of(recording), FitRequest("jewel")).frames[0].warnings
        assert not [w for w in own if w.startswith("calibration_")]


class TestTransmit:
    def test_finds_field_per_volt_within_its_uncertainty(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with(*MADE_OTHERWISE)
        job = calibrated(engine, tmp_path, kind="transmit")
        assert job.error is None
        value, std = parts(job.result.root.field_t_per_v)
        assert_scatters_as_said(value - true_field_per_volt(engine, np.array(job.result.root.frequency_hz)), std)
        henries = [engine.platform.transmit[k].inductance_h for k in range(3)]
        np.testing.assert_allclose(job.result.root.inductance_h, henries, rtol=5e-3)
        assert job.warnings == []

    def test_a_platform_that_names_it_drives_with_measured_fields(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        weak = "backends.simulated.wiring.factors=[0.8, 1.0, 1.0]"
        file = calibrated(engine_with(weak), tmp_path, kind="transmit", name="coils").result.root.file
        named = f'transmit_calibration={{file="{tmp_path / file}"}}'
        engine = engine_with(weak, named)
        plain = engine_with()
        ratio = engine.platform.transmit[0].field_per_ampere_t[0] / plain.platform.transmit[0].field_per_ampere_t[0]
        assert ratio == pytest.approx(0.8, rel=2e-3)
        acquire(engine, tmp_path / "jewel.h5", window=None)
        stored = read_transmit_calibration(tmp_path / "jewel.h5")
        assert stored.identifier == file.removesuffix(".h5")
        np.testing.assert_array_equal(stored.field_per_volt, read_transmit_calibration(tmp_path / file).field_per_volt)

    def test_a_tone_beyond_the_limits_is_refused_before_anything_moves(
        self, engine_with: Callable[..., Engine], tmp_path: Path
    ) -> None:
        engine = engine_with("limits.max_coil_current_a=0.01")
        with pytest.raises(SequenceRejected, match="current of coil x"):
            engine.submit(plan_calibration(engine, CalibrationRequest(kind="transmit", frequencies_hz=FEW), tmp_path))
        assert engine.job_ids("calibration") == ()


class TestBadInput:
    @pytest.mark.parametrize("kind", ["receive", "transmit"])
    def test_a_platform_without_the_instrument_says_so(
        self, engine_with: Callable[..., Engine], tmp_path: Path, kind: str
    ) -> None:
        engine = engine_with()
        engine.platform = type(engine.platform)(**{**vars(engine.platform), "reference": None, "probe": None})
        with pytest.raises(ConfigError, match=r"has no (reference dipole|field probe)"):
            engine.submit(plan_calibration(engine, CalibrationRequest(kind=kind), tmp_path))  # type: ignore[arg-type]

    @pytest.mark.parametrize(
        ("keys", "said"),
        [
            ({"name": "../x"}, "no name"),
            ({"frequencies_hz": (212.0, 212.0)}, "two different"),
            ({"frequencies_hz": (212.0, 15e3)}, "cannot be measured"),
            ({"frequencies_hz": (1.0, 212.0)}, "too short"),
        ],
    )
    def test_what_makes_no_sense_is_refused(
        self, engine_with: Callable[..., Engine], tmp_path: Path, keys: dict[str, Any], said: str
    ) -> None:
        with pytest.raises(InputError, match=said):
            plan_calibration(engine_with(), CalibrationRequest(kind="receive", **keys), tmp_path)
