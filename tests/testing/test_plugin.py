"""The plugin of pytest in a project of somebody else."""

import subprocess
import sys
import venv
from pathlib import Path

import pytest

from platform_daemon.testing import assert_within
from platform_daemon.testing.plugin import recording  # noqa: F401 the kit has another fixture of that name
from tests.kit.pages import ROOT

EXAMPLE = ROOT / "examples/ci"


class Estimate:
    def __init__(self, value, std):
        self.value, self.std = value, std


def test_a_fit_that_is_off_is_named_with_its_distance():
    fit = {"f_nat_hz": Estimate(213.0, 0.1), "m_r_am2": Estimate(0.012, None), "psi_start_rad": Estimate(6.28, 0.01)}
    assert_within(fit, {"f_nat_hz": 213.2, "m_r_am2": 1.0, "psi_start_rad": 0.0}, sigmas=3)
    with pytest.raises(AssertionError, match=r"f_nat_hz = 213, true 212: 10\.0 sigma"):
        assert_within(fit, {"f_nat_hz": 212.0})
    with pytest.raises(AssertionError, match="nothing to compare"):
        assert_within(fit, {"f": 1.0})
    with pytest.raises(AssertionError, match="beyond"):
        assert_within({"f_nat_hz": Estimate(float("nan"), 0.1)}, {"f_nat_hz": 213.0})


def test_a_recording_has_its_truth_and_is_made_once(recording):  # noqa: F811
    made = recording("jewel", rx_s=0.6, seed=3)
    assert made.truth["f_nat_hz"] == pytest.approx(213.1, abs=0.2)
    assert recording("jewel", rx_s=0.6, seed=3).name == made.name
    assert recording("jewel", rx_s=0.6, seed=4).name != made.name
    with pytest.raises(ValueError, match="--shotss"):
        recording("jewel", shotss=1)


@pytest.mark.long
def test_the_example_project_passes_in_an_environment_of_its_own(tmp_path):
    """Installed without its dependencies, which are those of the environment below."""
    home = tmp_path / "venv"
    venv.create(home, symlinks=True)
    packages = next((home / "lib").glob("python3*/site-packages"))
    below = Path(pytest.__file__).parents[1]
    (packages / "below.pth").write_text(f"import site; site.addsitedir({str(below)!r})\n")
    project = tmp_path / "project"
    for path in EXAMPLE.rglob("*"):
        if path.is_file() and path.suffix in (".py", ".toml"):
            copy = project / path.relative_to(EXAMPLE)
            copy.parent.mkdir(parents=True, exist_ok=True)
            copy.write_bytes(path.read_bytes())
    pip = [sys.executable, "-m", "pip", "--python", home, "install", "--quiet", "--no-deps", "--no-index"]
    subprocess.run([*pip, "--no-build-isolation", project], check=True, timeout=300)
    words = [home / "bin/python", "-m", "pytest", "-q", "-p", "no:xdist", "tests"]
    out = subprocess.run(words, cwd=project, capture_output=True, text=True, timeout=540, check=False)
    assert out.returncode == 0, out.stdout + out.stderr
    assert "4 passed" in out.stdout
