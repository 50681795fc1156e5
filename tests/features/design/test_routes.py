"""Design and defects over REST: the same numbers as on the command line; what makes no sense is a problem in words."""

import json
import time
from concurrent.futures import ThreadPoolExecutor

import pytest

from platform_daemon.core.settings import load_specimen
from tests.kit.command_line import here
from tests.kit.rest import problem

TILT = {"bearing": "jewel", "defect": "stator_tilt", "eps_deg": [2.0]}


def test_the_design_point_of_the_paper_has_both_bearings(client):
    found = client.get("/design").json()
    assert found["f_nat_hz"] == pytest.approx(229.31, abs=0.005)
    assert found["friction"]["printed"]["follows_from_friction_coefficient"] == pytest.approx(0.12, abs=5e-5)
    assert [p["bearing"] for p in found["procedures"]] == ["jewel", "thread"]
    assert [p["f_perp_n"] for p in found["procedures"]] == pytest.approx([5.850e-3, 6.776e-3], rel=1e-4)


def test_a_resonator_that_was_added_has_its_design(client):
    shipped = load_specimen("thread")[0].model_dump(exclude_none=True)
    shipped["magnets"]["distance_m"] = 4.46e-3
    client.post("/resonators", params={"name": "close"}, json=shipped)
    found = client.get("/resonators/close@1/design").json()
    assert found["f_nat_hz"] == pytest.approx(229.308 * (4.7 / 4.46) ** 1.5, rel=1e-5)
    assert found["friction"] is None
    assert found["measured"]["tf_over_i_rad_per_s2"] is None
    body = {"bearing": "thread", "defect": "stator_tilt", "eps_deg": [2.0]}
    force = [
        client.post("/defects", json={**body, **r}).json()["cases"][0]["f_perp_n"] for r in ({"resonator": "close"}, {})
    ]
    assert force[0] > 1.1 * force[1]


def test_a_resonator_that_nobody_knows_is_a_problem(client):
    assert problem(client.get("/resonators/spring/design"), 404)["where"] == "spring"
    problem(client.post("/defects", json={**TILT, "resonator": "spring"}), 422)


def test_magnets_that_overlap_are_a_problem_and_so_is_a_rotor_that_does_not_fit_its_cup(client):
    shipped = load_specimen("jewel")[0].model_dump(exclude_none=True)
    for name, part, key, value, word in (
        ("overlapping", "magnets", "distance_m", 2e-3, "overlap"),
        ("stuck", "jewel", "cup_radius_m", 1e-3, "larger"),
        ("tiny", "magnets", "radius_m", 1e-200, "no numbers"),
    ):
        body = {**shipped, part: {**shipped[part], key: value}}
        assert client.post("/resonators", params={"name": name}, json=body).status_code == 201
        assert word in problem(client.get(f"/resonators/{name}/design"), 422)["detail"]
        problem(client.post("/defects", json={**TILT, "resonator": name}), 422)
        problem(client.post("/defects/picture", json={**TILT, "resonator": name}), 422)


def test_cases_are_those_of_the_command_line(client, tmp_path):
    body = {**TILT, "eps_deg": [0.0, 2.0], "phi_deg": [10.0, 30.0], "cup_radius_over_r": "inf"}
    done = here("defects", "--bearing", "jewel", "--defect", "stator_tilt", "--eps-deg", "0,2", "--phi-deg", "10,30",
                "--cup-radius-over-r", "inf", "--json", tmp_path / "d.json")  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert client.post("/defects", json=body).json() == json.loads((tmp_path / "d.json").read_text())


def test_the_largest_sweep_is_answered_in_seconds(client):
    body = {
        **TILT,
        "bearing": "thread",
        "eps_deg": [k / 20 for k in range(200)],
        "phi_deg": [k * 0.9 for k in range(100)],
    }
    began = time.monotonic()
    assert len(client.post("/defects", json=body).json()["cases"]) == 20_000
    assert time.monotonic() - began < 10


@pytest.mark.long
def test_pictures_are_drawn_at_the_same_time(client):
    bodies = [{**TILT, "phi_deg": [10.0 * k]} for k in range(1, 5)]
    with ThreadPoolExecutor(4) as clients:
        answers = list(clients.map(lambda body: client.post("/defects/picture", json=body), bodies))
    assert [a.headers["content-type"] for a in answers] == ["image/png"] * 4
    assert all(a.content.startswith(b"\x89PNG") for a in answers)
    assert len({a.content for a in answers}) == 4


@pytest.mark.parametrize(
    ("body", "where", "word"),
    [
        ({"bearing": "thread", "defect": "jewel_tilt", "eps_deg": [1.0]}, "defect", "rotor_tilt"),
        ({"bearing": "jewel", "defect": "lateral", "eps_deg": [1.0]}, "eps_deg", "dy_mm"),
        ({"bearing": "jewel", "defect": "stator_tilt"}, "eps_deg", "missing"),
        ({**TILT, "eps_deg": []}, "eps_deg", "at least 1"),
        ({**TILT, "eps_deg": [91.0]}, "eps_deg", "90"),
        ({**TILT, "eps_deg": ["2"]}, "eps_deg", "number"),
        ({**TILT, "eps_deg": [0.1] * 1000, "phi_deg": [1.0] * 21}, "body", "21000 cases"),
        ({**TILT, "cup_radius_over_r": -2.0}, "cup_radius_over_r", "convex"),
        ({**TILT, "cup_radius_over_r": 1.000000001}, "cup_radius_over_r", "play"),
        ({**TILT, "cup_radius_over_r": "flat"}, "cup_radius_over_r", "inf"),
        ({**TILT, "thread_length_over_r": 8.0}, "thread_length_over_r", "no thread"),
        ({**TILT, "pivot": "contact"}, "pivot", "jewel"),
        ({**TILT, "defect": "jewel_tilt", "eps_deg": [1.0, 80.0], "cup_radius_over_r": "inf"}, "eps_deg", "80 deg"),
        ({**TILT, "bearing": "spring"}, "bearing", "jewel"),
        ({**TILT, "size_deg": [1.0]}, "size_deg", "unknown"),
    ],
)
@pytest.mark.parametrize("path", ["/defects", "/defects/picture"])
def test_what_makes_no_sense_is_a_problem_that_says_where(client, path, body, where, word):
    found = problem(client.post(path, json=body), 422)
    assert where in found["where"]
    assert word in found["detail"]
