"""Why a shot shows no swing: the drive and the declared resonator name the cause, with numbers."""

import numpy as np
import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import RESONATOR, Excitation
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.settings import locate
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.fit.drive_hint import with_drive_hint
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.measurement import open_for_fit
from tests.kit.acquisitions import acquire
from tests.kit.recording_files import header, shot, write_series

NO_SIGNAL = FitResult.refused(RefusedError(Refusal.NO_SIGNAL, "noise"))


@pytest.mark.parametrize(
    ("sequence", "words"),
    [
        (
            {"field_t": 490e-12},
            ("too weak: 0.00049 uT, 1e-06 times the 490 uT of the preset jewel", "raise sequence.field_t"),
        ),
        (
            {"f_tx_hz": 363.0},
            ("off resonance: 363.0", "150 Hz above the expected f_nat of 213.25 Hz", "36 Hz to either side", "tune"),
        ),
        ({"axis": "y"}, ("hardly any torque: its field along y is parallel to the moment", "(--axis) to x")),
        ({"axis": "z"}, ("hardly any torque: its field along z is parallel to the axis of rotation",)),
    ],
)
def test_a_drive_that_cannot_move_the_resonator_is_named_on_line_and_again(engine_with, tmp_path, sequence, words):
    job = acquire(engine_with(), tmp_path / "a.h5", sequence={"rx_s": 0.6, **sequence})
    (frame,) = job.result.fit.frames
    assert frame.verdict == "refused"
    for word in words:
        assert word in frame.reason
    (again,) = fit_measurement(*open_for_fit(tmp_path / "a.h5", FitSettings())).frames
    assert again.reason == frame.reason


@pytest.mark.parametrize(
    ("field_t", "degrees_to_moment", "cause"),
    [(24e-6, 90.0, "too weak"), (25e-6, 90.0, None), (490e-6, 5.7, "hardly any torque"), (490e-6, 5.8, None)],
)
def test_a_cause_is_named_below_its_threshold_only(tmp_path, field_t, degrees_to_moment, cause):
    angle = np.radians(degrees_to_moment)
    axis = np.array([np.sin(angle), np.cos(angle), 0.0])  # the moment of the shipped jewel is along y
    drive = Excitation("sine", 213.0, 213.0, field_t, axis, 10.0, 0.0, np.ones(3))
    about = {"configuration_toml": f"{RESONATOR}{locate('resonators', 'jewel').read_text()}", "variant": "jewel"}
    with SeriesWriter.create(tmp_path / "a.h5", header(excitation=drive, planned_shots=1, **about)) as writer:
        writer.add_shot(shot(1))
        path = writer.finish()
    reason = with_drive_hint(NO_SIGNAL, open_recording(path), 0).reason
    assert [each for each in ("too weak", "hardly any torque") if each in reason] == ([cause] if cause else [])


def test_without_a_cause_in_the_drive_the_reason_says_what_it_was(engine_with, tmp_path):
    acquire(engine_with(), tmp_path / "a.h5", window=None)
    reason = with_drive_hint(NO_SIGNAL, open_recording(tmp_path / "a.h5"), 0).reason
    for word in ("no_signal: noise; the drive suits the declared resonator (490 uT along x, 212", "self-test", "tune"):
        assert word in reason


def test_a_good_fit_and_another_refusal_and_a_recording_from_elsewhere_stay_as_they_are(engine_with, tmp_path):
    acquire(engine_with(), tmp_path / "a.h5", window=None, sequence={"rx_s": 0.6, "axis": "y"})
    recording = open_recording(tmp_path / "a.h5")
    short = FitResult.refused(RefusedError(Refusal.TOO_SHORT, "x"))
    for fit in (FitResult("good"), short):
        assert with_drive_hint(fit, recording, 0) is fit
    elsewhere = open_recording(write_series(tmp_path / "b.h5"))
    assert with_drive_hint(NO_SIGNAL, elsewhere, 0) is NO_SIGNAL


def test_a_resonator_off_centre_is_said_to_look_like_other_gains_not_like_a_spike(engine_with, tmp_path):
    shipped = locate("resonators", "jewel").read_text()
    assert "position_m = [0.0, 0.0, 0.0]" in shipped
    off = tmp_path / "off.toml"
    off.write_text(shipped.replace("position_m = [0.0, 0.0, 0.0]", "position_m = [0.012, 0.012, 0.012]"))
    job = acquire(engine_with(), tmp_path / "a.h5", resonator=str(off))
    (frame,) = job.result.fit.frames
    assert frame.good
    said = [warning for warning in frame.warnings if warning.startswith("channel_gains: ")]
    assert len(said) == 1
    assert "off centre" in said[0]
    assert not any(warning.startswith("residual_not_steady") for warning in frame.warnings)
    # The truth of what is said: m_r is off by more than a percent and by many of its errors.
    m_r = frame.parameters["m_r_am2"]
    assert abs(m_r.value / 12.028e-3 - 1) > 0.01 > 10 * m_r.std / m_r.value
    assert np.isclose(frame.parameters["f_nat_hz"].value, 213.25, atol=0.3)


def test_a_torque_that_the_model_lacks_is_not_called_other_gains(engine_with, tmp_path):
    engine = engine_with('backends.simulated.undeclared=[{id="quadratic_drag", strength=0.02}]')
    (frame,) = acquire(engine, tmp_path / "a.h5").result.fit.frames
    said = {warning.partition(":")[0] for warning in frame.warnings}
    assert frame.good
    assert "residual_not_white" in said
    assert "channel_gains" not in said
