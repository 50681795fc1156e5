"""What may be asked of a fit, and what is said of its frames."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from drivers.errors import InputError
from platform_daemon.analysis import fit
from platform_daemon.analysis.derived import series_quantities
from platform_daemon.analysis.fit_request import FitRequest, check_fixed, checked_variant, why_refused
from platform_daemon.analysis.series.summary import summary
from platform_daemon.cli.parsing import parse_values
from platform_daemon.estimation.physics.models import MODELS
from platform_daemon.estimation.physics.torques import TERMS
from platform_daemon.store.reader import open_recording
from tests.cli.test_main import DATA


@pytest.mark.parametrize("name", MODELS)
def test_every_declared_model_can_be_asked_for(name):
    assert checked_variant(name) == name


def test_further_terms_become_part_of_the_name():
    assert checked_variant("thread", ["quadratic_drag", "bias_torque"]) == "thread+quadratic_drag+bias_torque"


@pytest.mark.parametrize(
    ("name", "terms", "word"), [("spring", [], "spring"), ("thread", ["wind"], "wind"), ("thread+thread", [], "thread")]
)
def test_an_unknown_name_is_answered_with_those_there_are(name, terms, word):
    with pytest.raises(InputError) as error:
        checked_variant(name, terms)
    for known in (*MODELS, *TERMS, word):
        assert known in str(error.value)


def test_a_term_cannot_be_had_twice():
    with pytest.raises(InputError, match="twice"):
        checked_variant("thread", ["viscous_damping"])


@pytest.mark.parametrize(
    ("variant", "fixed", "possible"),
    [
        ("thread+quadratic_drag", {"quadratic_drag_per_rad": 0.0}, True),
        ("thread+restoring_anharmonicity", {"anharmonicity": -0.01}, True),
        ("thread+quadratic_drag", {"quadratic_drag_per_rad": -1.0}, False),
        ("undamped", {"lambda_per_s": 0.2}, False),
        ("jewel", {"tf_over_i_rad_per_s2": 1000.0}, True),
        ("thread", {"f_nat_hz": 0.0}, False),
    ],
)
def test_what_can_be_held_follows_from_the_model(variant, fixed, possible):
    ask = FitRequest(variant, fixed=fixed)
    if possible:
        check_fixed(ask, calibrated=True)
    else:
        with pytest.raises(InputError):
            check_fixed(ask, calibrated=True)


def test_coefficients_of_further_terms_can_be_given_by_name():
    assert parse_values(["anharmonicity=-0.01"], "--fix") == {"anharmonicity": -0.01}


def frame(k, rotation, r2=0.99):
    vector = rotation.as_rotvec()
    names = {f"rodrigues_{axis}": {"value": float(v), "std": 1e-4} for axis, v in zip("xyz", vector, strict=True)}
    return {"frame": k, "verdict": "good", "parameters": names | {"f_nat_hz": {"value": 200.0, "std": 0.1}}, "r2": r2}


def test_orientations_near_half_a_turn_are_averaged_as_rotations():
    axis = np.array([0.6, 0.0, 0.8])
    truth = Rotation.from_rotvec(math.pi * axis)
    rng = np.random.default_rng(1)
    turned = [truth * Rotation.from_rotvec(0.02 * rng.standard_normal(3)) for _ in range(40)]
    frames = [frame(k, r) for k, r in enumerate(turned)]
    lengths = [r.as_rotvec() @ axis for r in turned]
    assert min(lengths) < 0 < max(lengths)  # both names occur
    found = summary(frames)
    mean = Rotation.from_rotvec([found[f"rodrigues_{a}"]["mean"] for a in "xyz"])
    assert (mean.inv() * Rotation.concatenate(turned).mean()).magnitude() < 1e-9
    assert all(found[f"rodrigues_{a}"]["std"] < 0.1 for a in "xyz")


def test_the_mean_of_psi_belongs_to_the_mean_orientation_of_a_resonator_on_the_border_of_the_convention():
    rng = np.random.default_rng(2)
    frames = []
    for k in range(12):  # e_v along y: noise decides on which side of x = 0 it is found, and psi with it
        turned = Rotation.from_rotvec(1e-3 * rng.standard_normal(3))
        other = turned.as_matrix()[0, 1] < 0
        turned = turned * Rotation.from_rotvec([math.pi, 0, 0]) if other else turned
        psi = 1.0 + (math.pi if other else 0.0) + 1e-3 * rng.standard_normal()
        frames.append(frame(k, turned))
        frames[-1]["parameters"]["psi_start_rad"] = {"value": psi, "std": 1e-3}
    flipped = {f["parameters"]["psi_start_rad"]["value"] > 2 for f in frames}
    assert flipped == {True, False}
    found = summary(frames)
    mean = Rotation.from_rotvec([found[f"rodrigues_{a}"]["mean"] for a in "xyz"])
    turned = mean.magnitude() > 1
    assert found["psi_start_rad"]["mean"] == pytest.approx(1.0 + (math.pi if turned else 0.0), abs=2e-3)
    assert found["psi_start_rad"]["std"] < 3e-3
    assert max(found[f"rodrigues_{a}"]["std"] for a in "xyz") < 3e-3


def test_one_frame_has_no_orientation_error():
    rotation = Rotation.from_rotvec([0.1, 0.2, 0.3])
    one = series_quantities({"frames": [frame(0, rotation)]}, [0.0])
    assert one["orientation_error"] is None
    assert any(note.startswith("orientation: 1 good frame") for note in one["notes"])
    two = series_quantities({"frames": [frame(0, rotation), frame(1, rotation)]}, [0.0, 1.0])
    assert two["orientation_error"]["against_mean"]["angle_rad"] == pytest.approx([0.0, 0.0], abs=1e-7)


def test_reasons_are_told_once_with_their_frames_and_only_if_none_is_good():
    bad = [{"frame": k, "verdict": "refused", "reason": "no_signal: x"} for k in (0, 2)]
    assert why_refused(bad) == "frame 0, 2: no_signal: x"
    assert why_refused([*bad, {"frame": 1, "verdict": "good", "reason": None}]) is None


def test_a_picture_is_calibrated_once(monkeypatch):
    calls = []
    real = fit.ring_down
    monkeypatch.setattr(fit, "ring_down", lambda *args: calls.append(1) or real(*args))
    shown = fit.ring_down_plot_data(open_recording(DATA / "example_thread.mmr.h5"), 0, "undamped", 0.1)
    assert len(calls) == 1
    assert shown.model is not None or "refused" in shown.caption
