"""What is predicted for an adopted manufacturing error: a rotor from rest through the planned drive."""

import json
import math

import numpy as np
import pytest

from drivers.errors import InputError
from platform_daemon.core.schemas.fits import Covariance
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.core.settings import load_specimen
from platform_daemon.features.fit.adopted_rotor import adopted_values, covariance_of_adopted
from platform_daemon.features.fit.precision import planned_precision
from platform_daemon.features.models.adopted_model import AdoptedModel
from platform_daemon.features.models.library import Library
from platform_daemon.features.models.schema import AdoptedRotorRecord
from tests.kit.command_line import assert_one_line_error, here, run
from tests.kit.estimated_rotors import true_rotor
from tests.kit.rest import problem

SPECIMEN, _ = load_specimen("thread_imperfect")
TRUE = true_rotor(SPECIMEN).values
HELD = ("distance_m", "side_damping_per_s", "friction_coefficient", "creep_m_per_s")
DRIVE = SequencePatch(field_t=240e-6, rx_s=0.4)


def tilted(*, name="tilted", covariance=None, base="thread"):
    """The model of the specimen as it is."""
    told = {n: {"value": getattr(TRUE, n), "std": 0.0} for n in ("f_nat_hz", "m_r_am2", "lambda_per_s")}
    error = AdoptedRotorRecord(
        id="stator_tilt",
        parameter="stator_tilt_rad",
        strength=TRUE.stator_tilt_rad,
        std=None,
        held={n: getattr(TRUE, n) for n in HELD},
        ratio={},
        covariance=covariance,
    )
    return AdoptedModel(name, 1, base, (), (), {"diagnosis": {"parameters_after": told}}, None, error)


def predicted(model=None, windows=(0.3,), drive=DRIVE, **more):
    return planned_precision(SPECIMEN, windows, model=model or tilted(), sequence=drive, **more)


def test_a_longer_window_and_a_stronger_drive_tell_more_and_noise_per_sample_counts_with_its_rate():
    report = predicted(windows=[0.1, "n50", 0.4])
    f_nat = [row.std["f_nat_hz"] for row in report.windows]
    assert [row.window_s for row in report.windows] == pytest.approx([0.1, 0.24, 0.4], abs=1e-4)
    assert f_nat[0] > 1.2 * f_nat[1] > 1.4 * f_nat[2]
    assert report.variant == "tilted@1"
    assert report.expected["stator_tilt_rad"] == TRUE.stator_tilt_rad
    weaker = predicted(drive=SequencePatch(field_t=120e-6, rx_s=0.4)).windows[0]
    whole = predicted().windows[0]
    assert weaker.std["rodrigues_z"] == pytest.approx(2.0 * whole.std["rodrigues_z"], rel=0.05)
    slower = predicted(sampling_rate_hz=125e6 / 8192).windows[0]
    assert slower.std["f_nat_hz"] == pytest.approx(2.0 * whole.std["f_nat_hz"], rel=0.05)
    assert whole.orientation_rad > whole.std["rodrigues_z"]


def test_errors_of_what_is_held_and_the_estimate_of_the_error_widen_the_bound():
    exact, free = predicted().windows[0], predicted(estimate_adopted=True).windows[0]
    extra = set(free.std) - set(exact.std)
    assert {"stator_tilt_rad", "distance_m", "side_damping_per_s", "lean_damping_per_s"} <= extra
    names = ("stator_tilt_rad", "distance_m", "side_damping_per_s")
    variances = np.diag([free.std[n] ** 2 for n in names])
    known = Covariance(parameters=names, matrix=tuple(map(tuple, variances.tolist())))
    report = predicted(tilted(covariance=known))
    assert "with those of what is held" in report.notes[1]
    for name, std in exact.std.items():
        assert report.windows[0].std[name] > (1.0 - 1e-9) * std
    assert report.windows[0].std["f_nat_hz"] > 1.005 * exact.std["f_nat_hz"]
    assert free.std["f_nat_hz"] > 1.02 * exact.std["f_nat_hz"]
    held = predicted(fixed=("lambda_per_s",)).windows[0]
    assert "lambda_per_s" not in held.std
    assert held.std["m_r_am2"] < exact.std["m_r_am2"]


def test_d30_is_where_the_rotors_own_signal_has_decayed():
    long = SequencePatch(field_t=240e-6, rx_s=0.8)
    (found,) = predicted(windows=["d30"], drive=long, expected={"lambda_per_s": 2.4}).windows
    assert found.window_s == pytest.approx(math.log(1 / 0.3) / 2.4, rel=0.05)


@pytest.mark.parametrize(
    ("more", "said"),
    [
        ({"windows": [0.5]}, r"no window of 0.5 s.*ends after 0.4 s"),
        ({"windows": [0.01]}, "too_short"),
        ({"phi_max_rad": 0.3}, "the drive decides"),
        ({"fixed": ("distance_m",)}, "has no 'distance_m' here"),
        ({"expected": {"psi_start_rad": 1.0}}, "has no 'psi_start_rad' here"),
        ({"expected": {"tf_over_i_rad_per_s2": 1.0}}, "has no 'tf_over_i_rad_per_s2' here"),
        ({"expected": {"m_r_am2": -0.01}}, "makes no sense"),
        ({"drive": SequencePatch(chirp_hz=1.0)}, "a sine of one frequency"),
        ({"drive": SequencePatch(phase_plan="model")}, "a sine of one frequency"),
        ({"drive": SequencePatch(rx_s=60.0)}, "too long"),
        ({"drive": SequencePatch(field_t=1.0, rx_s=0.4)}, "nothing can be predicted"),
        ({"sampling_rate_hz": 600.0}, "sampling_too_slow"),
    ],
)
def test_a_plan_that_makes_no_sense_is_refused_with_what_to_do(more, said):
    with pytest.raises(InputError, match=said) as refused:
        predicted(**more)
    assert refused.value.remedy


def test_a_model_whose_diagnosis_tells_no_moment_says_so():
    model = tilted()
    model.evidence["diagnosis"]["parameters_after"].pop("m_r_am2")
    with pytest.raises(InputError, match="does not tell m_r_am2"):
        predicted(model)


def test_the_command_and_the_request_know_it(tmp_path, client):
    Library(tmp_path).add(tilted())
    asked = ("predict", "--resonator", "thread_imperfect", "--variant", "tilted", "--models", tmp_path, "--rx-s", "0.3")
    done = here(*asked, "--window", "n50", "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    assert "tilted@1" in done.stdout
    said = json.loads((tmp_path / "p.json").read_text())
    assert_one_line_error(here(*asked, "--window", "4"), 2, "ends after 0.3 s", "--rx-s")
    assert_one_line_error(here(*asked, "--deflection-deg", "20"), 2, "the drive decides", "--field-ut")

    Library(client.folder.models).add(tilted(name="leaning"))
    body = {"resonator": "thread_imperfect", "variant": "leaning", "windows": ["n50"], "sequence": {"rx_s": 0.3}}
    answer = client.post("/predict", json=body)
    assert answer.status_code == 200, answer.text
    assert answer.json()["windows"] == said["windows"]
    assert "leaning@1" in problem(client.post("/predict", json={**body, "resonator": "jewel"}), 422)["detail"]
    assert "'leaning@3'" in problem(client.post("/predict", json={**body, "variant": "leaning@3"}), 422)["detail"]


@pytest.mark.long
@pytest.mark.parametrize("shot", [1, 2])
def test_it_is_what_a_fit_of_a_measured_shot_states(tmp_path, shot):
    Library(tmp_path).add(tilted())
    drive = ("--field-ut", "240", "--rx-s", "1.2")
    made = run(
        "measure", "--resonator", "thread_imperfect", *drive, "--shots", "1", "--out", tmp_path / "t.h5",
        "--set", f"backends.simulated.seed={shot}", timeout=300,
    )  # fmt: skip
    assert made.returncode == 0, made.stderr
    model = ("--variant", "tilted", "--models", tmp_path, "--window", "1.0")
    done = run("fit", tmp_path / "t.h5", *model, "--json", tmp_path / "f.json", timeout=300)
    assert done.returncode == 0, done.stderr
    plan = ("predict", "--resonator", "thread_imperfect", *drive, *model)
    done = here(*plan, "--json", tmp_path / "p.json")
    assert done.returncode == 0, done.stderr
    fit = json.loads((tmp_path / "f.json").read_text())["frames"][0]["parameters"]
    for name, std in json.loads((tmp_path / "p.json").read_text())["windows"][0]["std"].items():
        assert fit[name]["std"] == pytest.approx(std, rel=0.05), name


def test_how_far_another_drawing_was_off_is_nothing_where_the_resonator_has_its_own():
    """A model that was adopted from a recording which declares no resonator."""
    names = ("stator_tilt_rad", "distance_m", "link_off_m")
    known = Covariance(parameters=names, matrix=tuple(map(tuple, np.diag([1e-8, 1e-14, 1e-10]).tolist())))
    alone = Covariance(parameters=names[:2], matrix=tuple(map(tuple, np.diag([1e-8, 1e-14]).tolist())))
    from_elsewhere, own = tilted(covariance=known), tilted(covariance=alone)
    from_elsewhere.rotor.held["link_off_m"] = 3e-4
    found, wanted = (predicted(model).windows[0].std for model in (from_elsewhere, own))
    assert found == pytest.approx(wanted)
    at = {"f_nat_hz": 215.0, "m_r_am2": 0.011, "lambda_per_s": 0.2}
    used = [adopted_values(from_elsewhere.rotor, at, np.eye(3), drawn=drawn).link_off_m for drawn in (True, False)]
    assert used == [0.0, 3e-4]
    assert covariance_of_adopted(known, drawn=False)[0] == names
