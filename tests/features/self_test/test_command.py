"""`platform-daemon self-test`."""

import json
import math

import pytest

from drivers.errors import InputError
from platform_daemon.features.budget.declared import declared_by
from platform_daemon.features.self_test.declared import gain_declaration
from platform_daemon.features.self_test.schema import SelfTestReport
from tests.kit.command_line import assert_one_line_error, here


def test_says_by_coil_what_it_heard_and_what_has_changed_since(tmp_path):
    first, change = tmp_path / "heard.json", tmp_path / "gain.toml"
    made = here("self-test", "--json", first)
    assert made.returncode == 0, made.stderr
    heard = json.loads(first.read_text())
    assert {*heard["gain"]} == {"x", "y", "z"}
    assert f"{heard['isolation_db']['z']:.1f}" in made.stdout
    changed = ("--set", "backends.simulated.wiring.factors=[1.2, 0.8, 1.0]", "--set", "backends.simulated.seed=6")
    again = here("self-test", "--since", first, "--declare", change, *changed)
    assert again.returncode == 0, again.stderr
    gain = declared_by(change).gain
    assert gain.u == pytest.approx(math.sqrt(2 * 0.2**2 / 3), abs=0.05)  # a tone is heard with some per cent of noise
    assert (gain.kind, gain.dof) == ("A", 3)
    assert gain.source in again.stdout
    assert_one_line_error(here("self-test", "--since", change, "--declare", tmp_path / "b"), 2, "no result of a self-")
    assert_one_line_error(here("self-test", "--since", first), 2, "give both: --since FIRST.json --declare gain.toml")


def _heard(date="2026-01-01", frequency_hz=4000.0, **isolation_db):
    return SelfTestReport(frequency_hz=frequency_hz, gain={}, isolation_db=isolation_db, date=date)


def test_a_change_of_gains_counts_as_a_whole(tmp_path):
    file = tmp_path / "gain.toml"
    louder = 80.0 - 20.0 * math.log10(1.003)
    file.write_text(gain_declaration(_heard(x=louder, y=80.0), _heard(x=80.0, y=80.0), "first"))
    assert declared_by(file).gain.u == pytest.approx(0.003 / math.sqrt(2.0), rel=2e-3)


@pytest.mark.parametrize(
    ("before", "said"),
    [
        (_heard(x=80.0, y=80.0), r"first: both tests have heard the same.*give an earlier one"),
        (_heard(x=80.0), r"first: it is of the coils x, not of x, y.*of this platform"),
        (
            _heard(x=80.1, y=80.0, frequency_hz=1000.0),
            r"first: its tones were of 1000 Hz, those of this one.*frequency_hz",
        ),
    ],
)
def test_self_tests_that_cannot_be_compared(before, said):
    with pytest.raises(InputError, match=said):
        gain_declaration(_heard(x=80.0, y=80.0), before, "first")


def test_a_wrong_chain_ends_in_one_line():
    wrong = here("self-test", "--set", "backends.simulated.wiring.outputs=[1, 0, 2]")
    assert_one_line_error(wrong, 1, "coil x is connected to output 1")


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        ({"isolation_db": {"x": 80.0}}, "it is of the coils x, not of x, y, z"),
        ({"frequency_hz": 1000.0}, "its tones were of 1000 Hz"),
    ],
)
def test_what_cannot_be_compared_is_refused_before_a_tone_is_played(changed, said, tmp_path):
    heard = _heard(x=80.0, y=80.0, z=80.0).model_dump()
    first, change = tmp_path / "first.json", tmp_path / "gain.toml"
    first.write_text(json.dumps({**heard, **changed}))
    # Of wrong cables the tones would tell first: `test_a_wrong_chain_ends_in_one_line`.
    wrong = ("--set", "backends.simulated.wiring.outputs=[1, 0, 2]")
    assert_one_line_error(here("self-test", "--since", first, "--declare", change, *wrong), 2, said)
    assert not change.exists()
