"""A client that a generator makes from the live schema walks the tour of the interface, typed throughout."""

from __future__ import annotations

import importlib
import io
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from tests.kit.daemon_process import daemon
from tests.kit.rest import client_at

pytestmark = pytest.mark.long

CONFIG = Path(__file__).with_name("client_generator.yaml")
HIDDEN = 'backends.simulated.undeclared=[{id="coulomb_friction", strength=60.0}]'
CALM = [f"backends.simulated.effects.{effect}.enabled=false" for effect in ("temperature", "wear")]
FINAL = ("done", "failed", "cancelled")


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    options = [part for override in (HIDDEN, *CALM) for part in ("--set", override)]
    with daemon(tmp_path_factory.mktemp("tour") / "data", *options) as address:
        yield address


@pytest.fixture(scope="module")
def api(server: str, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Any]:
    """The generated package: `models`, and the operations of every tag by name, called with the client."""
    folder = tmp_path_factory.mktemp("generated")
    schema = folder / "openapi.json"  # fetched here: the generator waits five seconds for it, and not longer
    with client_at(server) as asking:
        schema.write_bytes(asking.get("/openapi.json").content)
    command = [Path(sys.executable).with_name("openapi-python-client"), "generate", "--path", schema]
    command += ["--meta", "none", "--output-path", folder / "mmr_client", "--config", CONFIG, "--fail-on-warning"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=dict(os.environ))
    assert done.returncode == 0, done.stdout + done.stderr
    assert "WARNING" not in done.stdout + done.stderr
    sys.path.insert(0, str(folder))
    client = importlib.import_module("mmr_client.client").Client(base_url=server, timeout=60.0)
    found = SimpleNamespace(models=importlib.import_module("mmr_client.models"), client=client)
    for path in (folder / "mmr_client/api").glob("*/*.py"):
        if path.stem != "__init__":
            module = importlib.import_module(f"mmr_client.api.{path.parent.name}.{path.stem}")
            setattr(found, path.stem, module)
    yield found
    sys.path.remove(str(folder))


def asked(api: Any, operation: str, *arguments: Any, **keys: Any) -> Any:
    return getattr(api, operation).sync(*arguments, client=api.client, **keys)


def ended(api: Any, operation: str, identifier: str) -> Any:
    """The job once it has ended."""
    begun = time.monotonic()
    while time.monotonic() < begun + 300:
        job = asked(api, operation, identifier)
        if job.state.value in FINAL:
            return job
        time.sleep(min(0.3, max(0.02, 0.1 * (time.monotonic() - begun))))
    raise AssertionError(f"{identifier} did not end")


@pytest.fixture(scope="module")
def series(api: Any) -> Any:
    """A short series, acquired."""
    m = api.models
    body = m.AcquisitionRequest(resonator="thread", shots=2, blank_shots=1, sequence=m.SequencePatch(rx_s=1.0))
    queued = asked(api, "start_acquisition", body=body)
    assert isinstance(queued, m.AcquisitionJob)
    job = ended(api, "get_acquisition", queued.id)
    assert job.state is m.JobState.DONE, job.error
    assert job.request.sequence.rx_s == 1.0
    return job


@pytest.fixture(scope="module")
def recording(series: Any) -> str:
    return str(series.result.recording)


def test_a_series_is_acquired_and_has_its_on_line_fits(api: Any, series: Any) -> None:
    frames = series.result.fit.frames
    assert [frame.verdict for frame in frames] == [api.models.FitVerdict.BLANK] + 2 * [api.models.FitVerdict.GOOD]
    assert 200 < frames[1].parameters["f_nat_hz"].value < 230
    listed = asked(api, "list_recordings").items
    assert [r.id for r in listed] == [series.result.recording]
    assert isinstance(asked(api, "get_recording", series.result.recording), api.models.RecordingInfo)


def test_dmdt_comes_as_points_as_numpy_file_and_as_hdf5(api: Any, recording: str) -> None:
    points = asked(api, "get_dmdt", recording, 1, points=200)
    assert points.unit is api.models.QuantityUnit.A_M2S
    whole = np.load(io.BytesIO(asked(api, "get_dmdt_npy", recording, 1).payload.read()))
    assert whole.shape == (3, points.samples)
    assert points.maximum[0][0] == whole[0, : points.samples_per_point].max()
    with h5py.File(asked(api, "get_dmdt_h5", recording, 1).payload) as h5:
        np.testing.assert_array_equal(h5["dmdt"], whole)
    with h5py.File(asked(api, "download_recording", recording).payload) as h5:
        assert h5.attrs["default"]


def test_a_recording_is_fitted_and_quantities_are_derived(api: Any, recording: str) -> None:
    m = api.models
    body = m.RecordingFitRequest(recording=recording, window=m.NamedWindow.N50, frames=[1, 2])
    job = ended(api, "get_fit", asked(api, "start_fit", body=body).id)
    assert isinstance(job.result, m.FitReport)
    assert job.result.window is m.NamedWindow.N50
    derived = asked(api, "get_derived", job.id)
    assert [frame.frame for frame in derived.frames] == [1, 2]
    assert asked(api, "get_envelopes", job.id, 1).amplitude_rad[0] > 0.1


def test_a_diagnosis_has_a_page_and_what_it_names_is_adopted_and_used(api: Any, recording: str) -> None:
    m = api.models
    job = ended(api, "get_diagnosis", asked(api, "start_diagnosis", body=m.DiagnosisRequest(recordings=[recording])).id)
    assert job.result.verdict is m.DiagnosisVerdict.EXPLAINED
    assert asked(api, "get_report", job.id).startswith("<!doctype html>")
    adopted = asked(api, "adopt_model", job.id, body=m.AdoptionRequest(name="dry", by="DC"))
    assert adopted.label == "dry@1"
    assert [model.label for model in asked(api, "list_models").items] == ["dry@1"]
    again = asked(api, "start_fit", body=m.RecordingFitRequest(recording=recording, variant="dry"))
    assert ended(api, "get_fit", again.id).result.variant == "dry@1"


def test_a_running_series_is_cancelled(api: Any) -> None:
    body = api.models.AcquisitionRequest(resonator="thread", shots=100)
    job = asked(api, "start_acquisition", body=body)
    asked(api, "cancel_acquisition", job.id)
    assert ended(api, "get_acquisition", job.id).state is api.models.JobState.CANCELLED
    assert not asked(api, "get_platform").power_amplifier.enabled


def test_a_sweep_is_watched_step_by_step_and_its_frames_know_their_steps(api: Any) -> None:
    m = api.models
    fields = m.SweepAxis(key="field_ut", start=200, stop=300, step=100)
    rule = m.StopRule(result="phi_max_deg", comparison=m.Comparison.VALUE_0, value=80)
    common = m.AcquisitionRequest(resonator="jewel", window="n50", sequence=m.SequencePatch(rx_s=0.3))
    body = m.SweepRequest(kind="sweep", acquisition=common, over=[fields], stop_when=rule)
    assert asked(api, "dry_run_procedure", body=body).shots == 2
    job = ended(api, "get_procedure", asked(api, "start_procedure", body=body).id)
    assert [step.values[0].value for step in job.result.steps] == [200, 300]
    assert job.result.steps[1].results["phi_max_rad"].median > 0.4
    assert [frame.step for frame in asked(api, "get_recording", job.result.recording).shots] == [1, 2]
    assert asked(api, "pause_procedure", job.id, body=m.Confirmation()).status == 409


def test_design_and_defects_are_typed_down_to_the_vectors_of_a_step(api: Any) -> None:
    m = api.models
    steps = asked(api, "get_design", "jewel").procedures[0].steps
    assert steps[1].values["centre_m"][1] == steps[1].values["dy_c_m"] > 0
    flat = m.DefectsRequest(
        bearing=m.Bearing.JEWEL, defect=m.Defect.LATERAL, dy_mm=[0.5], cup_radius_over_r=m.Infinite.INF
    )
    found = asked(api, "compute_defects", body=flat)
    assert found.cup_radius_over_r is m.Infinite.INF
    assert found.cases[0].dy_c_m > 4.9e-4
    assert asked(api, "draw_defects", body=flat).payload.read().startswith(b"\x89PNG")
    wrong = m.DefectsRequest(bearing=m.Bearing.THREAD, defect=m.Defect.JEWEL_TILT, eps_deg=[1.0])
    assert asked(api, "compute_defects", body=wrong).where == "defect"


def test_what_cannot_be_done_is_a_typed_problem(api: Any) -> None:
    found = asked(api, "get_recording", "nothing")
    assert isinstance(found, api.models.Problem)
    assert (found.status, found.type_) == (404, "/problems/unknown-recording")
    body = api.models.AcquisitionRequest(resonator="thread", sequence=api.models.SequencePatch(field_t=490.0))
    found = asked(api, "dry_run", body=body)
    assert "at most 1 T" in found.detail
    assert "0.00049" in found.detail
