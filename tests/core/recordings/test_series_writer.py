"""A series: what goes in comes out, nothing half appears, and errors come before hardware would move."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import SequenceInfo
from platform_daemon.core.recordings.recovery import recover
from platform_daemon.core.recordings.series_writer import SeriesWriter
from platform_daemon.core.recordings.truth import read_truth
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.state import durable as durable_module
from platform_daemon.core.state.errors import StorageError, StorageUnusable
from tests.kit.fit_tables import read_fits
from tests.kit.recording_files import (
    EXCITATION,
    SEQUENCE,
    P,
    calibration,
    fit_table,
    header,
    shot,
    volts,
    write_series,
)


def files(folder: Path) -> list[str]:
    return sorted(p.name for p in folder.iterdir())


def test_everything_given_comes_back(tmp_path: Path) -> None:
    r = open_recording(write_series(tmp_path / "a.h5"))
    assert (r.frames, r.channels, r.sequence, r.variant) == (3, 3, SEQUENCE, "thread")
    for k in range(3):
        assert np.array_equal(r.frame_volts(k), volts(k + 1))
    c, expected = r.calibration, calibration()
    assert (c.identifier, c.date, c.lna_gain) == ("cal-7", "2026-02-28", 100.0)
    assert np.array_equal(c.sensitivity, P)
    assert np.array_equal(c.frequency_hz, expected.frequency_hz)
    assert np.array_equal(c.frequency_response, expected.frequency_response)
    p, h = r.provenance, header()
    for name in ("title", "sample_name", "operator", "comment", "platform", "channel_names"):
        assert getattr(p, name) == getattr(h, name)
    assert r.configuration_toml() == h.configuration_toml
    assert (p.devices, p.planned_shots, p.incomplete) == (h.devices, 3, None)
    info = r.frame_info[1]
    assert (info.shot, info.verdict, info.time_stamp, info.monotonic_s) == (2, "good", shot(2).time_stamp, 1002.0)
    assert (info.temperature_c, info.flags, info.blank, info.valid_samples) == (21.5, (), False, 124)
    assert info.excitation.realised_hz == EXCITATION.realised_hz
    assert np.array_equal(info.excitation.current_a, EXCITATION.current_a)
    assert read_truth(r.path)[2] == {"f_nat_hz": 216.0, "effects": {"hum": True}, "note": "ok"}
    to_json(describe(r))


def test_plain_h5py_by_the_documented_layout_gives_the_exact_volts(tmp_path: Path) -> None:
    write_series(tmp_path / "a.mmr")
    with h5py.File(tmp_path / "a.mmr") as h5:
        tx, switch, rx = (int(h5[f"/sequence/num{w}Samples"][()]) for w in ("Tx", "Switch", "Rx"))
        assert h5["/sequence/baseFrequency"][()] / h5["/sequence/decimation"][()] == 125e6 / 2048
        assert h5["/sequence/numFrames"][()] == 3
        assert h5["/data"].dtype == np.float32
        assert h5["/data"].chunks == (1, 1, 124)
        assert np.array_equal(h5["/data"][()], np.stack([volts(k) for k in (1, 2, 3)]))
        assert np.array_equal(h5["/data"][2, 0, tx + switch : tx + switch + rx], volts(3)[0, 24:])
        assert np.array_equal(h5["/calibration/sensitivity"][()], P)
        assert h5["/resonator/variant"].asstr()[()] == "thread"


def test_acknowledged_shots_are_recordings_of_their_own_and_the_target_appears_last(tmp_path: Path) -> None:
    target = tmp_path / "a.h5"
    with SeriesWriter.create(target, header()) as writer:
        for k in (1, 2):
            assert writer.add_shot(shot(k)) == k
            one = open_recording(tmp_path / ".a.h5.shots" / f"shot_00000{k}.h5")
            assert (one.frames, one.frame_info[0].shot) == (1, k)
            assert np.array_equal(one.frame_volts(0), volts(k))
        assert not target.exists()
        assert writer.finish() == target
        assert files(tmp_path) == ["a.h5"]
    assert open_recording(target).provenance.incomplete == "stopped after 2 of 3 shots"


def test_each_shot_is_synced_then_renamed_then_its_folder_synced(tmp_path: Path, monkeypatch) -> None:
    calls: list[tuple[str, str]] = []
    sync, rename = os.fsync, os.replace

    def noting_sync(fd: int) -> None:
        name = Path(os.readlink(f"/proc/self/fd/{fd}")).name
        calls.append(("sync", re.sub(r"\.[0-9]+-[0-9a-f]{8}\.part$", ".*.part", name)))
        sync(fd)

    def noting_rename(a: Path, b: Path) -> None:
        calls.append(("rename", Path(b).name))
        rename(a, b)

    monkeypatch.setattr(durable_module.os, "fsync", noting_sync)
    monkeypatch.setattr(durable_module.os, "replace", noting_rename)
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        calls.clear()  # what was tried before the first shot
        writer.add_shot(shot(1))
        writer.finish()
    assert calls == [
        ("sync", ".shot_000001.h5.*.part"),
        ("rename", "shot_000001.h5"),
        ("sync", ".a.h5.shots"),
        ("sync", "series.part"),
        ("rename", "a.h5"),
        ("sync", tmp_path.name),
    ]


def test_flags_blank_shots_and_missing_sensors_survive(tmp_path: Path) -> None:
    set_flags = {"overwritten": True, "lost_steps": True, "lna_overload": True, "temperature_c": None}
    own = replace(EXCITATION, field_t=1e-6)
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1, verdict="refused", reason="overwritten at 7", **set_flags))
        writer.add_shot(shot(2, blank=True, truth=None))
        writer.add_shot(shot(3, excitation=own))
        writer.finish()
    first, blank, third = open_recording(tmp_path / "a.h5").frame_info
    assert first.flags == ("overwritten", "lost_steps", "lna_overload")
    assert (first.verdict, first.reason, first.temperature_c) == ("refused", "overwritten at 7", None)
    assert blank.blank
    assert (blank.excitation.field_t, list(blank.excitation.current_a)) == (0.0, [0, 0, 0])
    assert third.excitation.field_t == 1e-6
    assert read_truth(tmp_path / "a.h5")[1] == {}


def test_a_bare_header_is_enough(tmp_path: Path) -> None:
    bare = {"variant": None, "calibration": None, "excitation": None, "planned_shots": None, "devices": {}}
    path = write_series(tmp_path / "a.h5", 1, channel_names=(), **bare)
    r = open_recording(path)
    assert (r.variant, r.calibration, r.provenance.incomplete, r.provenance.channel_names) == (None, None, None, ())
    assert r.frame_info[0].excitation is None


def test_a_known_excitation_beside_an_unknown_one(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header(excitation=None)) as writer:
        writer.add_shot(shot(1))
        writer.add_shot(shot(2, excitation=EXCITATION))
        writer.finish()
    unknown, known = open_recording(tmp_path / "a.h5").frame_info
    assert unknown.excitation is None
    assert known.excitation.field_t == EXCITATION.field_t


@pytest.mark.parametrize("given", [volts(1)[:, :50], np.zeros((3, 0)), np.zeros((0, 0))])
def test_a_short_refused_shot_is_padded_and_says_so(tmp_path: Path, given: np.ndarray) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1, volts=given, verdict="refused", reason="card stopped"))
        writer.finish()
    r = open_recording(tmp_path / "a.h5")
    n = given.shape[1]
    assert r.frame_info[0].valid_samples == n
    assert np.array_equal(r.frame_volts(0)[:, :n], given.reshape(-1, n) if n else np.zeros((3, 0)))
    assert not r.frame_volts(0)[:, n:].any()


def test_a_refused_shot_keeps_what_comes_before_a_sample_that_is_not_finite(tmp_path: Path) -> None:
    bad = volts(1)
    bad[1, 60] = np.nan
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1, volts=bad, verdict="refused", reason="not finite"))
        writer.finish()
    r = open_recording(tmp_path / "a.h5")
    assert r.frame_info[0].valid_samples == 60
    assert np.array_equal(r.frame_volts(0)[:, :60], volts(1)[:, :60])


@pytest.mark.parametrize(
    "changes",
    [
        {"volts": volts(1)[:, :50]},
        {"volts": volts(1)[:2]},
        {"volts": np.zeros((3, 125)), "verdict": "refused"},
        {"volts": np.full((3, 124), np.nan)},
        {"volts": np.full((3, 124), 1e300)},
        {"verdict": "perhaps"},
        {"time_stamp": "yesterday"},
        {"excitation": replace(EXCITATION, field_t=np.nan)},
        {"excitation": replace(EXCITATION, current_a=np.zeros(2))},
    ],
)
def test_a_shot_that_does_not_fit_is_refused_and_the_series_goes_on(tmp_path: Path, changes: dict) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        with pytest.raises(InputError):
            writer.add_shot(shot(1, **changes))
        assert writer.shots == 0
        writer.add_shot(shot(1))
        writer.finish()
    assert open_recording(tmp_path / "a.h5").frames == 1


@pytest.mark.parametrize(
    "changes",
    [
        {"variant": "watch"},
        {"channels": 0},
        {"channels": 2},
        {"calibration": calibration(sensitivity=np.zeros((3, 3)))},
        {"calibration": calibration(frequency_hz=None)},
        {"sequence": SequenceInfo(0.0, 2048, 1, 1, 1)},
        {"sequence": SequenceInfo(125e6, 0, 1, 1, 1)},
        {"sequence": SequenceInfo(125e6, 2048, 1, 1, 0)},
        {"planned_shots": 0},
        {"channel_names": ("x",)},
        {"start_time": "noon"},
        {"excitation": replace(EXCITATION, axis=np.ones(2))},
    ],
)
def test_a_wrong_header_is_refused_before_anything_is_written(tmp_path: Path, changes: dict) -> None:
    with pytest.raises(InputError):
        SeriesWriter.create(tmp_path / "a.h5", header(**changes))
    assert files(tmp_path) == []


def test_more_than_the_disk_can_take_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(StorageUnusable):
        SeriesWriter.create(tmp_path / "a.h5", header(planned_shots=10**12))
    assert files(tmp_path) == []


def test_an_existing_file_is_only_replaced_on_purpose_and_at_the_end(tmp_path: Path) -> None:
    target = write_series(tmp_path / "a.h5", 1)
    old = target.read_bytes()
    with pytest.raises(InputError, match="--force"):
        SeriesWriter.create(target, header())
    with SeriesWriter.create(target, header(), overwrite=True) as writer:
        writer.add_shot(shot(2))
        assert target.read_bytes() == old
        writer.finish()
    assert np.array_equal(open_recording(target).frame_volts(0), volts(2))
    assert files(tmp_path) == ["a.h5"]


def test_places_where_no_file_can_be_made_are_named(tmp_path: Path) -> None:
    (tmp_path / "file").touch()
    (tmp_path / "folder").mkdir()
    for target in ("missing/a.h5", "file/a.h5", "folder", "x" * 300, "a\0b"):
        with pytest.raises(InputError) as caught:
            SeriesWriter.create(tmp_path / target, header())
        assert caught.value.where
        assert caught.value.remedy
    assert files(tmp_path) == ["file", "folder"]


def test_a_folder_without_write_permission_is_named(tmp_path: Path) -> None:
    tmp_path.chmod(0o555)
    program = (
        "import os, sys\n"
        "from drivers.errors import InputError\n"
        "from platform_daemon.core.recordings.series_writer import SeriesWriter\n"
        "from tests.kit.recording_files import header\n"
        "os.getuid() or os.setuid(65534)\n"
        "try: SeriesWriter.create(sys.argv[1], header())\n"
        "except InputError as error: print(error)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(tmp_path / "a.h5")], capture_output=True, text=True, check=True
    )
    tmp_path.chmod(0o755)
    assert "Permission denied" in done.stdout


def test_a_series_without_a_shot_leaves_nothing(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        assert writer.finish() is None
    with SeriesWriter.create(tmp_path / "b.h5", header()):
        pass
    assert files(tmp_path) == []


def test_a_second_writer_to_the_same_file_is_refused(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1))
        with pytest.raises(InputError, match="in use"):
            SeriesWriter.create(tmp_path / "a.h5", header(), overwrite=True)
        assert recover(tmp_path) == []
        assert writer.finish().exists()


def test_a_target_that_appears_meanwhile_is_not_replaced_and_no_shot_is_lost(tmp_path: Path) -> None:
    target = tmp_path / "a.h5"
    with SeriesWriter.create(target, header()) as writer:
        writer.add_shot(shot(1))
        target.write_text("someone else's")
        with pytest.raises(InputError, match="exists already"):
            writer.finish()
        target.unlink()
        writer.finish()
    assert open_recording(target).frames == 1


def test_a_full_disk_while_a_shot_is_written_costs_that_shot_only(tmp_path: Path, monkeypatch) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1))
        with monkeypatch.context() as patch:
            patch.setattr(durable_module.os, "fsync", _no_space)
            with pytest.raises(StorageError, match="No space left"):
                writer.add_shot(shot(2))
        assert files(tmp_path / ".a.h5.shots") == ["lock", "shot_000001.h5"]
        writer.add_shot(shot(2))
        writer.finish()
    assert open_recording(tmp_path / "a.h5").frames == 2


def _no_space(fd: int) -> None:
    raise OSError(28, "No space left on device")


@pytest.mark.long
def test_a_disk_too_full_for_the_series_file_is_a_storage_error_and_the_shots_stay(tmp_path: Path) -> None:
    program = (
        "import resource, signal, sys\n"
        "from platform_daemon.core.recordings.series_writer import SeriesWriter\n"
        "from platform_daemon.core.state.errors import StorageError\n"
        "from tests.kit.recording_files import header, shot\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "w = SeriesWriter.create(sys.argv[1], header())\n"
        "for k in range(9): w.add_shot(shot(k))\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]),) * 2)\n"
        "try: w.finish()\n"
        "except StorageError as error: print('refused:', error)\n"
    )
    # HDF5 itself would take the process down here: the file must never get to it.
    for limit in (100, 200_000):
        target = tmp_path / f"{limit}.h5"
        done = subprocess.run(
            [sys.executable, "-c", program, str(target), str(limit)], capture_output=True, text=True, check=False
        )
        assert done.stdout.startswith("refused:"), done.stderr
        assert (done.returncode, done.stderr) == (0, "")
        assert not target.exists()
    assert len(recover(tmp_path)) == 2
    assert open_recording(target).frames == 9


def test_fit_tables_come_back(tmp_path: Path) -> None:
    table = fit_table(3)
    path = write_series(tmp_path / "a.h5", fits=(table, fit_table(3, "1.5")))
    assert open_recording(path).fits == ("1.5", "d30")
    _, found = read_fits(path)
    assert (found.name, found.parameters, found.verdict, found.reason) == (
        "d30",
        table.parameters,
        table.verdict,
        table.reason,
    )
    for name in ("values", "std", "covariance", "r2", "nrmse", "chi2_per_dof", "window_s"):
        assert np.array_equal(getattr(found, name), getattr(table, name), equal_nan=True)
    assert read_fits(write_series(tmp_path / "b.h5", 1)) == ()


@pytest.mark.parametrize("table", [fit_table(2), replace(fit_table(3), std=np.zeros(3)), fit_table(3, "a/b")])
def test_a_fit_table_of_another_shape_is_refused_and_nothing_lost(tmp_path: Path, table) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        for k in range(3):
            writer.add_shot(shot(k))
        with pytest.raises(InputError, match="fit"):
            writer.finish([table])
        assert writer.finish() == tmp_path / "a.h5"


def test_text_that_hdf5_cannot_hold_does_not_cost_a_shot(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5", 1, comment="a\0b\udc80", title="")
    assert open_recording(path).provenance.comment == "a\ufffdb?"


def test_truth_may_hold_numpy_and_values_that_are_not_finite(tmp_path: Path) -> None:
    truth = {"a": np.float64(1), "b": np.arange(2), "c": np.nan, "d": {"e/f": 1, "g": 10**400}, "h": {1}}
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1, truth=truth))
        writer.finish()
    found = read_truth(tmp_path / "a.h5")[0]
    assert found == {"a": 1.0, "b": [0, 1], "c": None, "d": {"e/f": 1, "g": 10**400}, "h": "{1}"}
    with h5py.File(tmp_path / "a.h5") as h5:
        assert list(h5["/simulation/values"]) == ["a"]


def test_no_truth_means_no_group(tmp_path: Path) -> None:
    with SeriesWriter.create(tmp_path / "a.h5", header()) as writer:
        writer.add_shot(shot(1, truth=None))
        writer.finish()
    assert read_truth(tmp_path / "a.h5") is None
    with h5py.File(tmp_path / "a.h5", "a") as h5:
        h5["/simulation/json"] = ["[1]"]
    with pytest.raises(RecordingError, match="not a JSON object"):
        read_truth(tmp_path / "a.h5")


@pytest.mark.long
@pytest.mark.parametrize(
    ("name", "value"),
    [
        ("/frames/verdict", None),
        ("/frames/verdict", ["good", "bad", "good"]),
        ("/frames/blank", [0, 0]),
        ("/frames/valid_samples", [124, 124, 125]),
        ("/frames/shot", [1, np.nan, 3]),
        ("/excitation/field", [np.nan] * 3),
        ("/excitation/axis", np.ones((3, 2))),
        ("/entry/title", None),
    ],
)
def test_damage_to_our_own_part_is_an_error_with_its_place(tmp_path: Path, name: str, value) -> None:
    path = write_series(tmp_path / "a.h5")
    with h5py.File(path, "a") as h5:
        del h5[name]
        if value is not None:
            h5[name] = value
    with pytest.raises(RecordingError) as caught:
        open_recording(path)
    assert caught.value.where.split(":")[1] in (name, name.rpartition("/")[0])


def test_a_later_layout_is_read_as_a_minimal_one(tmp_path: Path) -> None:
    path = write_series(tmp_path / "a.h5")
    with h5py.File(path, "a") as h5:
        h5.attrs["recording_layout"] = "platform-daemon/2"
        del h5["frames"]
    assert open_recording(path).provenance is None
