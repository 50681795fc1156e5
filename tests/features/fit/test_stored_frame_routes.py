import io
import math

import h5py
import numpy as np
import pytest

from tests.kit.rest import finished, problem
from tests.kit.specimen_files import pendulum, swing


@pytest.fixture(scope="module")
def fit(client, recording):
    answer = client.post("/fits", json={"recording": recording, "window": 0.5})
    return finished(client, answer.headers["location"])


def value(job, name, frame=0):
    return job["result"]["frames"][frame]["parameters"][name]["value"]


def test_a_fit_gives_quality_factors_and_orientation_errors(client, fit):
    found = client.get(f"/fits/{fit['id']}/derived").json()
    first = found["frames"][0]
    assert first["quality_factor"] == pytest.approx(math.pi * value(fit, "f_nat_hz") / value(fit, "lambda_per_s"))
    assert first["equivalent_quality_factor_to_infinity"] < first["equivalent_quality_factor"]
    against = found["orientation_error"]["against_best"]
    assert min(against["angle_rad"]) == pytest.approx(0, abs=1e-9)
    assert found["allan_deviation"] is None
    assert any("allan" in note for note in found["notes"])


def test_envelopes_begin_at_the_fitted_amplitude_and_the_frequency_rises_to_f_nat(client, fit):
    found = client.get(f"/fits/{fit['id']}/frames/0/envelopes", params={"points": 50}).json()
    assert len(found["t_s"]) == 50
    assert found["amplitude_rad"][0] == pytest.approx(value(fit, "phi_max_rad"), rel=0.02)
    shift = np.array(found["frequency_minus_f_nat_hz"])
    assert np.all(np.diff(shift) > 0)
    assert np.all(shift < 0)


def test_an_angle_in_the_folder_of_recordings_is_fitted_with_its_quality_factor(client):
    path = pendulum(client.folder.recordings, *swing(), name="pendulum.h5")
    try:
        answer = client.post("/fits", json={"recording": "pendulum", "window": 10.0})
        job = finished(client, answer.headers["location"])
        assert value(job, "f_nat_hz") == pytest.approx(2.0, abs=0.05)
        assert "m_r_am2" not in job["result"]["frames"][0]["parameters"]
        found = client.get(f"/fits/{job['id']}/derived").json()
        assert found["frames"][0]["quality_factor"] == pytest.approx(2 * math.pi / 0.15, rel=0.1)
        problem(client.post("/fits", json={"recording": "pendulum", "fixed": {"m_r_am2": 0.01}}), 422)
    finally:
        path.unlink()


def test_harmonics_of_a_frame_and_of_the_last_shot_agree_with_the_fit(client, recording, fit):
    found = client.get(f"/recordings/{recording}/frames/1/harmonics").json()
    assert found["f_nat_hz"] == pytest.approx(value(fit, "f_nat_hz", 1), abs=0.02)
    assert found["m_r_am2"] == pytest.approx(value(fit, "m_r_am2", 1), rel=2e-3)
    live = client.get("/live/harmonics").json()
    assert live["shot"] == 2
    assert live["f_nat_hz"] == pytest.approx(found["f_nat_hz"], abs=1e-3)


def test_sliding_windows_come_with_their_flatness(client, recording):
    query = {"window_s": 0.12, "lambda": "fixed"}
    found = client.get(f"/recordings/{recording}/frames/0/sliding", params=query).json()
    assert [w["verdict"] for w in found["windows"]] == ["good"] * len(found["windows"])
    assert all(w["lambda_fixed"] for w in found["windows"])
    assert found["flatness"]["m_r_am2"]["windows"] == len(found["windows"]) == 5


def test_the_precision_of_a_plan_is_predicted(client):
    body = {"resonator": "thread", "windows": ["n50", 4.9]}
    short, long = client.post("/predict", json=body).json()["windows"]
    assert short["std"]["f_nat_hz"] == pytest.approx(0.0008, rel=0.15)
    assert long["std"]["f_nat_hz"] == pytest.approx(1.7e-5, rel=0.1)


@pytest.mark.parametrize(
    "body",
    [
        {"resonator": "spring"},
        {"resonator": "thread", "windows": []},
        {"resonator": "thread", "windows": ["d40"]},
        {"resonator": "thread", "phi_max_rad": 2.0},
        {"resonator": "thread", "noise_am2_per_s": [0.1, 0.1]},
        {"resonator": "thread", "noise_am2_per_s": [0.1, 0.1, 0.0]},
        {"resonator": "thread", "fixed": ["psi_start_rad"]},
    ],
)
def test_a_plan_that_makes_no_sense_is_a_problem(client, body):
    problem(client.post("/predict", json=body), 422)


@pytest.mark.parametrize(
    ("path", "status"),
    [
        ("/fits/nothing/derived", 404),
        ("/fits/{fit}/frames/9/envelopes", 422),
        ("/fits/{fit}/frames/0/envelopes?points=1", 422),
        ("/recordings/nothing/frames/0/sliding", 404),
        ("/recordings/{recording}/frames/9/sliding", 422),
        ("/recordings/{recording}/frames/0/sliding?window_s=9", 422),
        ("/recordings/{recording}/frames/0/sliding?lambda=loose", 422),
        ("/recordings/{recording}/frames/9/harmonics", 422),
    ],
)
def test_what_is_not_there_is_a_problem(client, recording, fit, path, status):
    problem(client.get(path.format(fit=fit["id"], recording=recording)), status)


def test_a_plan_that_a_fit_would_refuse_is_a_problem_with_the_fits_name(client):
    found = problem(client.post("/predict", json={"resonator": "thread", "windows": [0.009]}), 422)
    assert "too_short: 1.9 periods" in found["detail"]
    slow = {"resonator": "thread", "windows": ["n50"], "sampling_rate_hz": 500.0}
    assert "sampling_too_slow" in problem(client.post("/predict", json=slow), 422)["detail"]


def test_a_fit_of_some_frames_leaves_the_others_alone(client, recording):
    asked = {"recording": recording, "window": 0.1, "frames": [1]}
    job = finished(client, client.post("/fits", json=asked).headers["location"])
    assert [f["frame"] for f in job["result"]["frames"]] == [1]
    assert job["progress"]["total"] == 1
    problem(client.post("/fits", json={**asked, "frames": [7]}), 422)
    problem(client.post("/fits", json={**asked, "frames": []}), 422)


def test_a_frame_that_is_not_finite_is_called_so_with_its_place(client, recording):
    source = client.folder.recordings / f"{recording}.h5"
    (path := source.with_name("with-nan.h5")).write_bytes(source.read_bytes())
    with h5py.File(path, "r+") as file:
        file["data"][1, 2, -50] = np.nan
    found = problem(client.get("/recordings/with-nan/frames/1/harmonics"), 422)
    assert found["type"] == "/problems/not-finite"
    assert "not_finite" in found["detail"]
    assert "frame 1, channel 2" in found["detail"]
    asked = {"recording": "with-nan", "window": 0.1}
    job = finished(client, client.post("/fits", json=asked).headers["location"])
    assert [f["verdict"] for f in job["result"]["frames"]] == ["good", "refused"]
    assert job["result"]["frames"][1]["reason"].startswith("not_finite: value is nan at ")
    path.unlink()


def test_a_refused_fit_says_so_and_why_wherever_it_is_asked(client, recording):
    asked = {"recording": recording, "window": 0.5, "variant": "undamped"}
    job = finished(client, client.post("/fits", json=asked).headers["location"])
    assert any("model_does_not_explain" in warning for warning in job["warnings"])
    for path in (f"/fits/{job['id']}/derived", f"/fits/{job['id']}/frames/0/envelopes"):
        found = problem(client.get(path), 422)
        assert found["type"] == "/problems/fit-refused"
        assert "model_does_not_explain" in found["detail"]
        assert "wait" not in found["detail"]


def test_models_and_terms_of_the_catalogue_can_be_asked_for(client, recording):
    asked = {"recording": recording, "window": 0.5, "terms": ["quadratic_drag"]}
    job = finished(client, client.post("/fits", json=asked).headers["location"])
    assert "quadratic_drag_per_rad" in job["result"]["frames"][0]["parameters"]
    assert client.get(f"/fits/{job['id']}/derived").status_code == 200
    found = problem(client.post("/fits", json={"recording": recording, "variant": "spring"}), 422)
    assert "jewel_constant_friction" in found["detail"]
    query = {"window_s": 0.2, "variant": "jewel", "term": "quadratic_drag"}
    slid = client.get(f"/recordings/{recording}/frames/0/sliding", params=query).json()
    assert "quadratic_drag_per_rad" in slid["windows"][0]["parameters"]
    body = {"resonator": "thread", "terms": ["quadratic_drag"], "expected": {"quadratic_drag_per_rad": 1e-3}}
    assert "quadratic_drag_per_rad" in client.post("/predict", json=body).json()["windows"][0]["std"]


def test_the_numbers_of_a_picture_hold_the_fit_and_a_residual_of_noise(client, recording):
    found = client.get(f"/recordings/{recording}/frames/0/plot", params={"points": 100}).json()
    assert found["channels"] == ["x", "y", "z"]
    assert found["fit"]["verdict"] == "good"
    assert len(found["t_s"]) == len(found["minimum"][2]) == len(found["residual_maximum"][2]) <= 100
    assert found["model"] == []
    fitted = np.array(found["t_s"]) < 0.9 * found["fit"]["window_s"]
    highest = np.array(found["residual_maximum"])[:, fitted]
    assert 1 < highest.mean() < 6
    top = int(np.argmax(found["spectrum"][0]))
    low_hz, high_hz = found["frequency_hz"][top : top + 2]
    assert low_hz <= found["fit"]["parameters"]["f_nat_hz"]["value"] < high_hz


def test_a_short_stretch_holds_every_sample_and_the_model(client, recording):
    keys = {"points": 1000, "start_s": 0.01, "stop_s": 0.02}
    found = client.get(f"/recordings/{recording}/frames/0/plot", params=keys).json()
    assert found["samples_per_point"] == 1
    assert found["minimum"] == found["maximum"]
    residual = (np.array(found["maximum"]) - found["model"]) / np.array(found["sigma"])[:, None]
    assert residual == pytest.approx(np.array(found["residual_maximum"]), abs=1e-2)
    assert found["t_s"][0] == pytest.approx(0.01, abs=2e-5)
    refused = client.get(f"/recordings/{recording}/frames/0/plot", params={"start_s": 100})
    assert "0 to" in problem(refused, 422)["remedy"]


def test_smallest_and_largest_values_are_those_of_the_samples(client, recording):
    base = f"/recordings/{recording}/frames/0"
    answer = client.get(f"{base}/dmdt.f32", params={"points": 50, "start_s": 0.1, "stop_s": 0.2})
    pairs = np.frombuffer(answer.content, "<f4").reshape(3, -1, 2)
    size = int(answer.headers["samples-per-point"])
    samples = np.load(io.BytesIO(client.get(f"{base}/dmdt.npy", params={"start_s": 0.1, "stop_s": 0.2}).content))
    assert pairs[:, 0, 0] == pytest.approx(samples[:, :size].min(axis=1), rel=1e-6)
    assert pairs[:, :, 1].max() == pytest.approx(samples.max(), rel=1e-6)
    assert float(answer.headers["start-s"]) == pytest.approx(0.1, abs=2e-5)
    assert answer.headers["channels"] == "x,y,z"
    assert answer.headers["unit"] == "A m^2/s"
