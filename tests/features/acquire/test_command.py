"""`platform-daemon measure`: what an option changes is what is played; what cannot be meant is refused."""

import json

import h5py
import pytest

from platform_daemon.core.command_line.parsing import parse_axis
from tests.kit.command_line import assert_one_line_error, here

QUICK = ("--resonator", "jewel", "--rx-s", "0.3", "--window", "n50")


def test_options_change_single_keys_of_the_preset(tmp_path):
    options = ("--f-tx-hz", 211, "--tx-periods", 8, "--field-ut", 300, "--axis", "1,0.2,0", "--pause-s", 0.01)
    done = here("measure", *QUICK, *options, "--out", tmp_path / "a.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.h5") as file:
        excitation = file["excitation"]
        assert excitation["field"][0] == pytest.approx(300e-6)
        assert excitation["axis"][0] == pytest.approx([0.98058, 0.19612, 0.0], abs=1e-5)
        assert excitation["periods"][0] == 8


def test_a_sequence_file_may_hold_only_what_differs(tmp_path):
    (tmp_path / "s.toml").write_text("field_t = 310e-6\n")
    done = here("measure", *QUICK, "--sequence", tmp_path / "s.toml", "--out", tmp_path / "a.h5")
    assert done.returncode == 0, done.stderr
    with h5py.File(tmp_path / "a.h5") as file:
        assert file["excitation/field"][0] == pytest.approx(310e-6)


def test_an_unknown_key_of_a_sequence_file_is_named_with_its_file(tmp_path):
    (tmp_path / "s.toml").write_text("rx_ss = 0.4\n")
    done = here("measure", *QUICK, "--sequence", tmp_path / "s.toml", "--out", tmp_path / "a.h5")
    assert_one_line_error(done, 2, "s.toml", "rx_ss")
    assert not (tmp_path / "a.h5").exists()


def test_the_preset_of_the_other_bearing_is_refused_unless_forced(tmp_path):
    done = here("measure", *QUICK, "--sequence", "thread", "--out", tmp_path / "a.h5")
    assert_one_line_error(done, 2, "--sequence thread", "another resonator", "--force")
    forced = here("measure", *QUICK, "--sequence", "thread", "--force", "--out", tmp_path / "a.h5")
    assert forced.returncode == 0, forced.stderr


def test_a_series_without_a_usable_shot_ends_with_code_3_and_keeps_its_recording(tmp_path):
    done = here("measure", *QUICK, "--field-ut", 0.02, "--out", tmp_path / "a.h5")
    assert done.returncode == 3
    assert "no shot can be used" in done.stderr
    assert (tmp_path / "a.h5").exists()


@pytest.mark.parametrize("text", ["w", "", "1,2", "1,2,3,4", "0,0,0", "1,nan,0", "x,y,z"])
def test_what_is_no_axis_is_refused(text, tmp_path):
    done = here("measure", *QUICK, "--axis", text, "--out", tmp_path / "a.h5")
    assert_one_line_error(done, 2, "--axis")


def test_an_axis_is_a_name_or_a_direction():
    assert parse_axis("y") == "y"
    assert parse_axis("1,0,-0.5") == (1.0, 0.0, -0.5)


def test_a_dry_run_tells_peaks_energy_and_disk_and_makes_no_file(tmp_path):
    keys = ("--drive", "phase_plan=model", "--drive", "plan_parameters.f_nat_hz=215.5", "--json", tmp_path / "p.json")
    done = here("measure", "--resonator", "thread", "--shots", 4, "--field-ut", 60, "--dry-run", *keys)
    assert done.returncode == 0, done.stderr
    plan = json.loads((tmp_path / "p.json").read_text())
    assert plan["shot"]["peak_field_t"] == pytest.approx(60e-6, rel=1e-2)
    assert plan["shot"]["energy_j"] > 0.9 * plan["shot"]["heat_per_shot_j"] > 0
    assert plan["shot"]["planned_phi_max_rad"] == pytest.approx(0.117, rel=0.05)
    assert "4 shots" in done.stdout
    assert "µT" in done.stdout
    assert list(tmp_path.iterdir()) == [tmp_path / "p.json"]


def test_shots_change_in_lockstep(tmp_path):
    lists = ("--per-shot", "field_ut=100:300:100", "--per-shot", "axis=x,x,x", "--json", tmp_path / "p.json")
    done = here("measure", "--resonator", "jewel", "--shots", 3, "--dry-run", *lists)
    assert done.returncode == 0, done.stderr
    shots = json.loads((tmp_path / "p.json").read_text())["shots_in_turn"]
    assert [shot["field_t"] for shot in shots] == pytest.approx([1e-4, 2e-4, 3e-4])


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--drive", "wave=sine"), ("wave",)),
        (("--drive", "waveform"), ("--drive", "KEY=VALUE")),
        (("--drive", "waveform=square"), ("waveform",)),
        (("--drive", "duty=0.5"), ("a sine has no duty",)),
        (("--drive", "phase_plan=model", "--axis", "z"), ("phase_plan", "hardly along v")),
        (("--drive", "f_nat_tolerance=0.01"), ("belong to a phase_plan",)),
        (("--per-shot", "field_ut=1,2", "--per-shot", "tx_periods=3"), ("--per-shot", "equally long")),
        (("--per-shot", "rx_s=1,2"), ("shot_changes", "rx_s")),
        (("--plan-from", "nowhere.json"), ("--plan-from", "holds no fits")),
        (("--field-ut", "2000"), ("field_t", "limits.max_field_t")),
    ],
)
def test_a_drive_that_cannot_be_is_one_line(options, words):
    assert_one_line_error(here("measure", *QUICK, "--dry-run", *options), 2, *words)


def test_fits_that_are_no_json_are_one_line(tmp_path):
    (tmp_path / "deep.json").write_text("[" * 100_000)
    done = here("measure", *QUICK, "--dry-run", "--plan-from", tmp_path / "deep.json")
    assert_one_line_error(done, 2, "--plan-from", "holds no fits")


def test_without_a_name_for_the_recording_nothing_moves():
    assert_one_line_error(here("measure", *QUICK), 2, "--out", "--dry-run")


def test_a_dry_run_says_that_the_disk_is_too_small_and_writes_nothing(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    done = here("measure", "--resonator", "jewel", "--shots", 100_000, "--rx-s", 60, "--dry-run")
    assert "100000 shots" in done.stdout
    assert_one_line_error(done, 2, "MiB are free", "record fewer or shorter shots")
    assert list(tmp_path.iterdir()) == []
