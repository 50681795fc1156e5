"""Adopted models in fits of new shots, on a simulated platform with effects that nobody declared."""

from dataclasses import replace

import numpy as np
import pytest

from drivers.calibration import ReceiverEffect
from drivers.errors import InputError
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.estimation.calibration.receiver_correction import correct_receiver_effects
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.features.acquire.series_plan import plan_series
from platform_daemon.features.diagnose.adoption import model_from_diagnosis
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import VoltageMeasurement
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.resolve import resolve
from tests.kit.acquisitions import acquire
from tests.kit.data import DATA
from tests.kit.diagnosis_json import diagnosed, effect
from tests.kit.fit_tables import read_fits

SHOT = {"resonator": "thread", "sequence": {"rx_s": 1.0}}
QUIET = ("backends.simulated.effects.temperature.enabled=false", "backends.simulated.effects.wear.enabled=false")


def world(*effects):
    """Overrides of a platform with undeclared effects."""
    texts = (
        "{" + ", ".join(f"{k}={v if isinstance(v, float) else repr(v)}" for k, v in e.items()) + "}" for e in effects
    )
    return (*QUIET, f"backends.simulated.undeclared=[{', '.join(texts)}]")


def chi2(report):
    assert all(f.good for f in report.frames), report.frames
    return np.mean([f.chi2_per_dof for f in report.frames])


def fitted(recording, variant=None):
    used, chosen = VoltageMeasurement.of(recording).under(variant)
    return fit_measurement(used, FitRequest(chosen, "d30"))


EFFECTS = [
    ({"id": "coulomb_friction", "strength": 60.0}, effect("coulomb_friction", 60.0)),
    ({"id": "bias_torque", "strength": 5e4}, effect("bias_torque", 5e4)),
    ({"id": "channel_gain", "strength": 0.05, "axis": "x"}, effect("channel_gain", 0.05, axis="x")),
    ({"id": "channel_delay", "strength": 2e-5, "axis": "y"}, effect("channel_delay", 2e-5, axis="y")),
    ({"id": "receive_lowpass", "strength": 2e-5, "axis": "y"}, effect("receive_lowpass", 2e-5, axis="y")),
    ({"id": "receiver_compression", "strength": 0.06}, effect("receiver_compression", 0.06)),
    ({"id": "crosstalk", "strength": 0.05, "from": "y", "to": "x"}, effect("crosstalk", 0.05, start="y", end="x")),
]


@pytest.mark.long
@pytest.mark.parametrize(("hidden", "found"), EFFECTS, ids=[e[0]["id"] for e in EFFECTS])
def test_a_fit_with_the_adopted_model_explains_new_shots(tmp_path, engine_with, hidden, found):
    library = Library(tmp_path / "models")
    made = library.add(model_from_diagnosis(diagnosed(found), "better", "me", library, recordings=[]))
    job = acquire(engine_with(*world(hidden)), tmp_path / "a.h5", **SHOT, shots=2)
    assert job.error is None
    recording = open_recording(tmp_path / "a.h5")
    before, after = fitted(recording), fitted(recording, made)
    assert chi2(after) < 1.02 < chi2(before) - 0.02
    assert after.variant == "better@1"
    assert made.digest[:12] in after.notes[0]


def test_on_line_fits_use_the_adopted_model_and_the_recording_says_so(tmp_path, engine_with):
    library = Library(tmp_path / "models")
    hidden, found = EFFECTS[2]
    library.add(model_from_diagnosis(diagnosed(found), "better", "me", library, recordings=[]))
    engine = engine_with(*world(hidden), models=library.folder)
    job = acquire(engine, tmp_path / "a.h5", **SHOT, variant="better")
    assert job.result.fit.variant == "better@1"
    assert chi2(job.result.fit) < 1.02
    assert read_fits(tmp_path / "a.h5")[0].variant == "better@1"
    # The recording keeps the platform's own calibration: with the declared model the effect is there.
    assert chi2(fitted(open_recording(tmp_path / "a.h5"))) > 1.1


def test_an_unknown_model_is_refused_before_anything_moves(engine_with, tmp_path):
    engine = engine_with(models=tmp_path)
    with pytest.raises(InputError, match="spring"):
        plan_series(engine, AcquisitionRequest(resonator="thread", variant="spring"))


def test_a_model_with_receiver_effects_needs_a_sensitivity(tmp_path):
    library = Library(tmp_path)
    made = library.add(model_from_diagnosis(diagnosed(EFFECTS[2][1]), "better", "me", library, recordings=[]))
    recording = replace(open_recording(DATA / "example_thread.mmr.h5"), calibration=None)
    with pytest.raises(InputError, match="sensitivity"):
        VoltageMeasurement.of(recording).under(made)
    with pytest.raises(InputError, match="no further terms"):
        VoltageMeasurement.of(recording).under(resolve("better@1", library), ["bias_torque"])


@pytest.mark.parametrize("even", [True, False])
def test_a_gain_of_even_or_odd_harmonics_is_undone_without_touching_the_others(even):
    rate_hz, f_hz, gain = 61_000.0, 213.7, 0.1
    t = np.arange(20_000) / rate_hz
    parts = [np.exp(-t) * np.sin(2 * np.pi * n * f_hz * t + n) for n in (1, 2, 3, 4)]
    clean = np.stack([sum(parts)] * 3)
    read = np.stack([sum(p * (1 + gain * ((n % 2 == 0) == even)) for n, p in enumerate(parts, 1))] * 3)
    record = RingDownRecord(read, rate_hz, "dmdt")
    found = correct_receiver_effects(
        record, np.eye(3), [ReceiverEffect("channel_gain", gain, even=even, fundamental_hz=f_hz)]
    )
    left = found.valid - clean[:, found.valid_from : found.end]
    assert 0 < found.valid_from < rate_hz / f_hz
    assert np.abs(left).max() < 1e-2 * gain
