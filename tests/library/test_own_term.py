"""A torque term of another package: one file, found by entry point, in fit, predict, diagnose and simulate."""

import os
import subprocess
import sys

import pytest

from tests.kit.entry_point_package import entry_point_package

GROUP = "platform_daemon.torque_terms"
TERM = """
from platform_daemon import Coefficient, TorqueTerm


def cubic_drag(phi, sin_phi, cos_phi, v, sigma, c, j, grad):
    grad[j] = -v * v * v
    return c[j] * grad[j], 0.0, -3.0 * c[j] * v * v


CUBIC_DRAG = TorqueTerm("cubic_drag", (Coefficient("cubic_drag_s", "s", -1, 1e-3),), cubic_drag, loses_energy=True)
"""
SCRIPT = """
import platform_daemon as pd_
sim = pd_.simulate("thread", phi_max_deg=40, seconds=2, seed=3, sampling_rate_hz=10e3,
                   terms=["cubic_drag"], parameters={"cubic_drag_s": 2e-6})
fit = pd_.fit(sim, model="thread", terms=["cubic_drag"], window=2.0)
found = fit["cubic_drag_s"]
assert abs(found.value - 2e-6) < 5 * found.std, found
assert found.std < 2e-7, found
report = pd_.diagnose(sim, model="thread")
assert "cubic_drag" in report.effects, report
assert "cubic_drag_s" in fit.to_dataframe()
print("found", found)
"""


def python(folder, *words):
    environment = {**os.environ, "PYTHONPATH": str(folder)}
    words = [sys.executable, *map(str, words)]
    return subprocess.run(words, env=environment, capture_output=True, text=True, timeout=300, cwd=folder, check=False)


@pytest.fixture
def own(tmp_path):
    return entry_point_package(
        tmp_path / "own", "cubic_drag_term", TERM, GROUP, cubic_drag="cubic_drag_term:CUBIC_DRAG"
    )


@pytest.mark.long
def test_an_own_term_is_simulated_fitted_found_and_predicted(own):
    out = python(own, "-c", SCRIPT)
    assert out.returncode == 0, out.stderr
    assert "found" in out.stdout
    words = ["predict", "--resonator", "thread", "--with-term", "cubic_drag", "--expect", "cubic_drag_s=2e-6"]
    predicted = python(own, "-m", "platform_daemon", *words)
    assert predicted.returncode == 0, predicted.stderr
    assert "cubic_drag_s" in predicted.stdout


def test_an_own_term_may_be_imported_before_this_package(own):
    code = "import cubic_drag_term, platform_daemon.estimation.physics.torques as t; print(sorted(t.TERMS), t.BROKEN)"
    out = python(own, "-c", code)
    assert "'cubic_drag'" in out.stdout, out.stderr
    assert "{}" in out.stdout


@pytest.mark.long
@pytest.mark.parametrize(
    ("text", "target", "says"),
    [
        ("raise OSError('no licence')", "CUBIC_DRAG", "no licence"),
        ("CUBIC_DRAG = 3", "CUBIC_DRAG", "no TorqueTerm"),
        (TERM.replace('"cubic_drag"', '"other"'), "CUBIC_DRAG", "must be that of the entry point"),
        (TERM.replace("cubic_drag_s", "lambda_per_s"), "CUBIC_DRAG", "'lambda_per_s' is taken"),
        (TERM, "NOTHING", "cannot be imported"),
    ],
    ids=["raises", "no term", "another name", "taken", "not there"],
)
def test_a_term_that_cannot_be_used_leaves_all_others_and_is_refused_with_the_reason(tmp_path, text, target, says):
    folder = entry_point_package(tmp_path / "own", "broken_term", text, GROUP, cubic_drag=f"broken_term:{target}")
    code = (
        "import platform_daemon as pd_\n"
        "sim = pd_.simulate('thread', phi_max_deg=20, seconds=1, sampling_rate_hz=5e3)\n"
        "print(pd_.fit(sim).good)\n"
        "try: pd_.fit(sim, model='thread', terms=['cubic_drag'])\n"
        "except pd_.InputError as error: print(error)"
    )
    out = python(folder, "-c", code)
    assert out.returncode == 0, out.stderr
    assert out.stdout.startswith("True")
    assert says in out.stdout
    assert "Remedy" in out.stdout
