import json

import pytest

from tests.kit.command_line import assert_one_line_error, here, run
from tests.kit.diagnosis_json import diagnosis, effect
from tests.kit.example_copies import copies


@pytest.fixture
def path(tmp_path):
    return copies(tmp_path, 1)[0]


def written(tmp_path, said):
    file = tmp_path / "diagnosis.json"
    file.write_text(json.dumps(said))
    return file


def test_a_diagnosis_is_adopted_used_shown_and_retired(tmp_path, path):
    models = ("--models", tmp_path / "models")
    file = written(tmp_path, diagnosis(effect("bias_torque", 0.0), model="jewel"))
    done = run("adopt", file, "--name", "bent", "--recording", path, *models)
    assert done.returncode == 0, done.stderr
    assert "bent@1" in here("models", *models).stdout
    done = here("fit", path, "--window", "0.4", "--variant", "bent", *models, "--json", tmp_path / "f.json")
    assert done.returncode == 0, done.stderr
    report = json.loads((tmp_path / "f.json").read_text())
    assert report["variant"] == "bent@1"
    assert report["frames"][0]["parameters"]["bias_rad_per_s2"] == {"value": 0.0, "std": None}
    (tmp_path / "models" / "torn@1.json").write_text("{")
    listed = here("models", *models)
    assert (listed.returncode, "bent@1" in listed.stdout, "torn@1.json" in listed.stderr) == (0, True, True)
    kept = json.loads(here("models", *models, "show", "bent").stdout)["evidence"]["recordings"]
    assert kept[0]["file"] == path.name
    assert len(kept[0]["sha256"]) == 64
    assert here("models", *models, "retire", "bent@1", "--reason", "was straight").returncode == 0
    assert_one_line_error(here("fit", path, "--variant", "bent", *models), 2, "bent", "retired")
    again = here("fit", path, "--window", "0.4", "--variant", "bent@1", *models)
    assert again.returncode == 0, again.stderr


def test_what_cannot_be_adopted_ends_with_2_and_one_line(tmp_path, path):
    models = ("--models", tmp_path / "models", "--recording", path)
    mains = written(tmp_path, diagnosis(effect("mains_interference", 1e-3)))
    assert_one_line_error(here("adopt", mains, "--name", "hum", *models), 2, "mains_interference", "Remedy")
    file = written(tmp_path, diagnosis(effect("bias_torque", 1.0)))
    assert_one_line_error(here("adopt", file, "--name", "bent", *models[:2]), 2, "--recording")
    assert_one_line_error(here("adopt", path, "--name", "bent", *models), 2, "JSON")


@pytest.mark.parametrize("said", [[], {}, {"verdict": "explained"}, {**diagnosis(), "effects": "many"}])
def test_what_is_no_diagnosis_is_refused(tmp_path, said):
    done = here("adopt", written(tmp_path, said), "--name", "bent", "--models", tmp_path / "models")
    assert_one_line_error(done, 2, "diagnosis.json", "is no diagnosis", "diagnose --json")
    assert not (tmp_path / "models").exists()
