"""`platform-daemon self-test`."""

import json

from tests.kit.command_line import assert_one_line_error, here


def test_says_by_coil_what_it_heard(tmp_path):
    made = here("self-test", "--json", tmp_path / "heard.json")
    assert made.returncode == 0, made.stderr
    heard = json.loads((tmp_path / "heard.json").read_text())
    assert {*heard["gain"]} == {"x", "y", "z"}
    assert f"{heard['isolation_db']['z']:.1f}" in made.stdout


def test_a_wrong_chain_ends_in_one_line():
    wrong = here("self-test", "--set", "backends.simulated.wiring.outputs=[1, 0, 2]")
    assert_one_line_error(wrong, 1, "coil x is connected to output 1")
