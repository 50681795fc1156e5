"""The plugin of pytest in a project of somebody else."""

import math
import subprocess
import sys
import venv
from pathlib import Path

import numpy as np
import pytest

import platform_daemon as pd_
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
        assert_within(fit, {"lambda_per_s": 1.0})
    for value, std in ((math.nan, 0.1), (213.0, math.nan), (213.0, math.inf), (213.0, 0.0)):
        with pytest.raises(AssertionError, match="beyond"):
            assert_within({"f_nat_hz": Estimate(value, std)}, {"f_nat_hz": 213.0})


FIT = {"f_nat_hz": Estimate(213.0, 0.1), "m_r_am2": Estimate(0.012, 1e-5)}
TRUTH = {"f_nat_hz": 213.0, "m_r_am2": 0.012, "lambda_per_s": 0.25}


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ((TRUTH, FIT), "fit: it has no standard deviations.*give the fit first"),
        ((TRUTH, TRUTH), "fit: it has no standard deviations"),
        ((213.0, TRUTH), "fit: it has no standard deviations"),
        ((FIT, FIT), "truth: f_nat_hz is no finite number"),
        ((FIT, 213.0), "truth: it is no table"),
        ((FIT, TRUTH | {"m_r_am2": math.nan}), "truth: m_r_am2 is no finite number"),
        ((FIT, TRUTH | {"m_r_am2": None}), "truth: m_r_am2 is no finite number"),
        ((FIT, TRUTH | {"f_nat": 99.0}), "no parameter is called 'f_nat'.*did you mean f_nat_hz"),
        ((FIT, TRUTH, 0.0), "sigmas: 0.0 is no distance"),
        ((FIT, TRUTH, -5), "sigmas: -5 is no distance"),
        ((FIT, TRUTH, math.nan), "sigmas: nan is no distance"),
        ((FIT, TRUTH, math.inf), "sigmas: inf is no distance"),
    ],
)
def test_a_comparison_that_would_say_nothing_is_refused(arguments, says):
    assert_within(FIT, TRUTH, 5)
    with pytest.raises(pd_.InputError, match=says):
        assert_within(*arguments)


def test_a_refused_fit_is_not_within_anything():
    time_s = np.arange(6000) / 10_000.0
    noise = np.random.default_rng(1).standard_normal((3, time_s.size))
    with pytest.raises(AssertionError, match="the fit was refused: no_signal"):
        assert_within(pd_.fit(pd_.from_arrays(time_s, noise), model="jewel"), TRUTH)


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
