"""`platform-daemon reset-amplifier` and `config check`; `devices` is tested on the emulated lab, which has wires."""

import pytest

from platform_daemon.core.settings import locate
from tests.kit.command_line import assert_one_line_error, here, run


def test_reset_amplifier_says_what_it_found():
    done = run("reset-amplifier")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "no fault was latched; the amplifier is disabled and muted\n"


@pytest.mark.parametrize(
    ("kind", "name", "said"),
    [
        ("platforms", "simulated", "platform 'simulated platform' is valid"),
        ("resonators", "jewel", "resonator 'paper jewel specimen' is valid"),
        ("sequences", "jewel", "sequence is valid"),
    ],
)
def test_config_check_recognises_each_kind(kind, name, said):
    done = here("config", "check", locate(kind, name))
    assert done.returncode == 0, done.stderr
    assert said in done.stdout


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("[limits]", "[limit]", "limits"),
        ("max_field_t =", "max_field_ut =", "max_field_t"),
        ("max_field_t =", 'max_field_t = "1 mT" #', "max_field_t"),
        ("max_field_t =", "max_field_t = nan #", "max_field_t"),
        ("max_tx_duty =", "max_tx_duty = 2.0 #", "max_tx_duty"),
        ('backend = "simulated"', 'backend = "simulate"', "simulate"),
        ("seed =", 'seed = "x" #', "seed"),
        ("decimation =", "decimation = -1 #", "decimation"),
        ("[lna]", "[lnaa]", "lna"),
    ],
)
def test_a_broken_platform_file_is_refused_naming_file_and_key(tmp_path, old, new, key):
    text = locate("platforms", "simulated").read_text()
    assert old in text
    path = tmp_path / "broken.toml"
    path.write_text(text.replace(old, new, 1))
    assert_one_line_error(here("config", "check", path), 2, key, "Remedy: ")


@pytest.mark.parametrize(("text", "said"), [("a = [", "not TOML"), ("a = 1", "neither a platform")])
def test_a_file_of_no_known_kind_is_said(tmp_path, text, said):
    path = tmp_path / "x.toml"
    path.write_text(text)
    assert_one_line_error(here("config", "check", path), 2, "x.toml", said)
