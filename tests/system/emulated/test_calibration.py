"""P measured over emulated wires: the dipole on the slave's second output, an operator who turns it."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from platform_daemon.core.recordings.reader import read_calibration
from platform_daemon.core.schemas.requests import CalibrationRequest
from platform_daemon.features.calibrate.work import plan_calibration
from platform_daemon.processes.assembly import start_engine
from tests.kit.emulated_lab import Lab

DIPOLE = "output=3, turns_area_m2=0.05, resistance_ohm=100.0, inductance_h=2e-3, relative_std=1e-3"
BOARDS = """io_cards.boards=[{inputs=["x", "y"], outputs=["x", "y"]}, {inputs=["z", ""], outputs=["z", "dipole"]}]"""
CARDS = "io_card.boards=[{}]".format(
    ", ".join(
        f'{{host="${{io_cards.{k}.host}}", command_port="${{io_cards.{k}.command_port}}", '
        f'data_port="${{io_cards.{k}.data_port}}", inputs={inputs}, outputs=[0, 1]}}'
        for k, inputs in enumerate(("[0, 1]", "[0]"))
    )
)


def test_p_is_found_with_the_delay_of_the_cards_filters(tmp_path: Path) -> None:
    lab = Lab(tmp_path, BOARDS, f"reference_dipole={{{DIPOLE}}}")
    engine = start_engine(lab.file(CARDS, f'reference_dipole={{backend="declared", {DIPOLE}}}'))
    request = CalibrationRequest(kind="receive", frequencies_hz=(424.0, 2120.0), repetitions=1, listen_s=0.2)
    try:
        job = engine.submit(plan_calibration(engine, request, tmp_path))
        for axis in "xyz":
            while job.question is None or job.proceed.is_set() or f"along {axis}" not in job.question:
                assert not job.ended.wait(timeout=0.01), job.error
            lab.control("turn_dipole", axis=axis)
            job.proceed.set()
        assert job.ended.wait(timeout=60)
        assert job.error is None
        made, declared = read_calibration(tmp_path / job.result.root.file), engine.platform.calibration
    finally:
        engine.close()
        violations = lab.violations()
        lab.emulator.close()
    assert violations == ()
    late = "the host was too late"  # on a computer with other work; such a shot is made again
    assert [warning for warning in job.warnings if late not in warning] == []
    assert made.frequency_hz is not None
    assert made.frequency_response is not None
    np.testing.assert_allclose(made.sensitivity, declared.sensitivity, atol=5e-3 * np.max(declared.sensitivity))
    delay = np.exp(-2j * np.pi * made.frequency_hz * 4.096e-6)  # as config/platforms/emulated.toml declares it
    np.testing.assert_allclose(made.frequency_response, np.tile(delay, (3, 1)), atol=1e-2)
    assert abs(np.angle(made.frequency_response[0, 1] / delay[1])) < 5e-3
