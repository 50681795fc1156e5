"""`platform-daemon reset-amplifier`; `devices` is tested on the emulated lab, which has wires."""

from tests.kit.command_line import run


def test_reset_amplifier_says_what_it_found():
    done = run("reset-amplifier")
    assert done.returncode == 0, done.stderr
    assert done.stdout == "no fault was latched; the amplifier is disabled and muted\n"
