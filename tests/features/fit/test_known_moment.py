"""A fit that disagrees with what is known of the resonator's moment."""

import pytest

from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import RESONATOR
from platform_daemon.core.settings import locate
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitSettings
from platform_daemon.features.fit.known_moment import implausible_moment, known_moment_am2
from platform_daemon.features.fit.measurement import open_for_fit, open_voltages
from tests.kit.data import DATA
from tests.kit.recording_files import write_series

JEWEL = locate("resonators", "jewel").read_text()


def fit_of(value, std=1e-6):
    return FitResult("good", parameters={"m_r_am2": Estimate(value, std)})


@pytest.mark.parametrize(("found", "warned"), [(0.81, True), (0.84, False), (1.0, False), (1.19, False), (1.21, True)])
def test_a_fifth_off_is_warned_of(found, warned):
    said = implausible_moment(fit_of(0.012 * found), 0.012)
    assert [w.partition(":")[0] for w in said] == ["moment_implausible"] * warned


def test_the_warning_says_both_numbers_and_what_to_check():
    (said,) = implausible_moment(fit_of(0.0003), 0.012)
    for words in ("0.3 mAm²", "12 mAm²", "0.025 times", "calibration", "LNA"):
        assert words in said


def test_what_was_held_or_is_not_known_or_was_not_fitted_is_not_judged():
    assert implausible_moment(fit_of(1.0, None), 0.012) == ()
    assert implausible_moment(fit_of(1.0), None) == ()
    assert implausible_moment(FitResult("good", parameters={}), 0.012) == ()


def test_the_moment_is_that_of_the_resonator_whose_declaration_the_recording_carries(tmp_path):
    path = write_series(tmp_path / "a.h5", configuration_toml=f"seed = 7\n{RESONATOR}{JEWEL}")
    recording = open_recording(path)
    assert "seed" not in recording.resonator_toml()
    assert known_moment_am2(recording) == 0.012028  # [measured] m_r_am2


@pytest.mark.parametrize("text", ["a = 1\n", f"a = 1\n{RESONATOR}b = 2\n", f"a = 1\n{RESONATOR}b = = 2\n", ""])
def test_a_recording_that_declares_none_has_none(tmp_path, text):
    assert known_moment_am2(open_recording(write_series(tmp_path / "a.h5", configuration_toml=text))) is None


def test_a_recording_from_elsewhere_has_none():
    path = DATA / "example_jewel.mmr.h5"
    assert open_voltages(path).moment_am2() is None
    measurement, ask = open_for_fit(path, FitSettings(window=0.1))
    assert ask.moment_am2 is None
    assert not any("moment" in w for f in fit_measurement(measurement, ask).frames for w in f.warnings)
