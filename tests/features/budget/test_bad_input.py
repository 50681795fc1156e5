"""What budgets refuse of what is declared, by the command line and by REST; and a note where a table has none."""

import json
import shutil

import h5py
import pytest

from platform_daemon.core.recordings.layout import CONFIGURATION
from platform_daemon.features.characterise.tables import characterisation_task, characterise
from platform_daemon.features.fit.batch.executors import in_this_process
from platform_daemon.features.fit.fit_request import FitSettings
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.rest import problem

CLOCK = 'sample_clock = { half_width = 2e-5, distribution = "rectangular", source = "data sheet of the crystal" }'
NAMES = [f"gain of channel {axis}" for axis in "xyz"]
IMPOSSIBLE = ", ".join(
    f'{{ between = ["{one}", "{other}"], r = {r} }}'
    for one, other, r in ((NAMES[0], NAMES[1], 0.9), (NAMES[1], NAMES[2], 0.9), (NAMES[0], NAMES[2], -0.9))
)
REFUSED = {
    "an uncertainty of 0": ("sample_clock = { u = 0.0 }", "sample_clock.u"),
    "a negative uncertainty": ("sample_clock = { u = -1e-5 }", "sample_clock.u"),
    "correlations that no joint distribution has": (f"correlation = [{IMPOSSIBLE}]", "contradict each other"),
    "a certificate that had expired": (
        'sample_clock = { u = 1e-6, certificate = { number = "7", date = 2020-01-01, valid_until = 2021-01-01 } }',
        "expired on 2021-01-01",
    ),
}


def declares(source, target, line):
    """A copy of a recording of which the platform's file declares something else of its sample clock."""
    shutil.copy(source, target)
    with h5py.File(target, "r+") as file:
        text = file[CONFIGURATION][()].decode()
        assert CLOCK in text
        del file[CONFIGURATION]
        file[CONFIGURATION] = text.replace(CLOCK, line)
    return target


@pytest.mark.parametrize(("line", "said"), REFUSED.values(), ids=REFUSED)
def test_the_command_refuses(measured, tmp_path, line, said):
    file = declares(measured / "j.h5", tmp_path / "other.h5", line)
    assert_one_line_error(here("budget", file, "--shot", 0), 2, said)


def _correlated(*pairs):
    return "correlation = [" + ", ".join(f'{{ between = ["{a}", "{b}"], r = {r} }}' for a, b, r in pairs) + "]"


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        ("gain = { u = nan }", "'gain.u' must be finite"),
        ("gain = { u = inf }", "'gain.u' must be finite"),
        ("gain = { u = 1e-3, dof = 0.5 }", "'gain.dof' must be at least 1"),
        ("gain = { u = 1e-3, dof = nan }", "'gain.dof' must be finite"),
        ('gain = { u = 1e-3, distribution = "uniform" }', "must be 'normal', 'rectangular'"),
        ('gain = { u = 1e-3, kind = "C" }', "must be 'A' or 'B'"),
        ("gain = { half_width = 1e-3 }", "a normal distribution has no half_width"),
        (_correlated((NAMES[0], NAMES[1], "nan")), "'correlation.0.r'"),
        (_correlated((NAMES[0], NAMES[1], 0.5), (NAMES[1], NAMES[0], 0.4)), "declared twice, as 0.5 and 0.4"),
        (_correlated((NAMES[0], NAMES[0], 0.5)), "with itself"),
        (_correlated((NAMES[0], "gain of channel w", 0.5)), "no input 'gain of channel w'"),
        ("temperature_coefficient_per_k = { f_nat = -0.23 }", "no fit has a parameter 'f_nat'. Remedy: name one of"),
        *(
            (
                f"{key} = {{ u = 1e-4, certificate = {{ number = '7', date = {date}, valid_until = {until} }} }}\n"
                "temperature_coefficient_per_k = { f_nat_hz = -0.2 }\ncoil_radius_m = [0.05, 0.05, 0.06]",
                f"[uncertainty] {key}: certificate 7: {said}",
            )
            for key, date, until, said in (
                ("reference_dipole", "2020-01-01", "2021-01-01", "expired on 2021-01-01"),
                ("calibration_drift_per_year", "2020-01-01", "2021-01-01", "expired on 2021-01-01"),
                ("thermometer_k", "2020-01-01", "2021-01-01", "expired on 2021-01-01"),
                ("position_m", "2020-01-01", "2021-01-01", "expired on 2021-01-01"),
                ("pose_rad", "2099-01-01", "2099-01-02", "issued on 2099-01-01, after it was measured"),
                ("static_field_t", "2020-01-01", "2021-01-01", "expired on 2021-01-01"),
            )
        ),
    ],
)
def test_a_file_of_declarations_is_refused(measured, tmp_path, lines, said):
    (tmp_path / "declared.toml").write_text(lines)
    done = here("budget", measured / "j.h5", "--shot", 0, "--uncertainty", tmp_path / "declared.toml")
    assert_one_line_error(done, 2, said)


@pytest.mark.parametrize("draws", ["inf", "nan", "-1", "1.5", "10", "1e12"])
def test_a_number_of_draws_that_is_none(measured, draws):
    done = here("budget", measured / "j.h5", "--shot", 0, "--monte-carlo", draws)
    assert_one_line_error(done, 2, " draws. Remedy: give ")


@pytest.mark.long
def test_rest_refuses(client, recording):
    folder = client.folder.recordings
    for line, said in REFUSED.values():
        path = declares(folder / f"{recording}.h5", folder / "other.h5", line)
        found = problem(client.get("/recordings/other/budget", params={"shot": 0}), 422)
        assert said in found["detail"], found
        path.unlink()


def test_means_without_a_budget_say_why(measured, tmp_path):
    file = declares(measured / "j.h5", tmp_path / "other.h5", REFUSED["a certificate that had expired"][0])
    with in_this_process() as workers:
        task = characterisation_task(file, FitSettings(), None, 0.001)
        report = characterise(task, workers, lambda what, share: None)
    assert report.mean_budgets is None
    (note,) = [each for each in report.notes if each.startswith("the means have no uncertainty budget: ")]
    assert "expired on 2021-01-01" in note
    assert "Remedy: name a certificate that was valid then" in note


def test_a_drift_of_the_temperature_without_a_coefficient_is_not_silent(measured, tmp_path):
    """The thermometer is declared, and nobody has said what a kelvin does to the resonator."""
    file = tmp_path / "other.h5"
    shutil.copy(measured / "j.h5", file)
    with h5py.File(file, "r+") as h5:
        text = h5[CONFIGURATION][()].decode()
        del h5[CONFIGURATION]
        h5[CONFIGURATION] = "\n".join(
            line for line in text.splitlines() if not line.startswith("temperature_coefficient_per_k")
        )
    done = here("budget", file, "--json", tmp_path / "b.json", "--html", tmp_path / "b.html")
    assert done.returncode == 0, done.stderr
    assert "not declared: temperature, per 1 K: adds 0.23" in done.stdout
    (line,) = [line for line in done.stdout.splitlines() if line.startswith("temperature: it changed by ")]
    assert "f_nat_hz perhaps by" in line
    assert "write temperature_coefficient_per_k into [uncertainty]" in line
    assert f"temperature: {json.loads((tmp_path / 'b.json').read_text())['temperature']}" == line
    assert "Temperature: it changed by " in (tmp_path / "b.html").read_text(encoding="utf-8")
    assert "temperature: it changed" not in here("budget", measured / "j.h5").stdout
