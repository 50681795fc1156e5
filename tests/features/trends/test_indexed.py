"""From files to a trend, by the index; and what happens to an index."""

import math
import os
import re
import shutil
import sqlite3
from collections import Counter
from contextlib import closing
from datetime import UTC, datetime
from functools import partial
from pathlib import Path

import h5py
import numpy as np
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.index import list_recordings
from platform_daemon.core.recordings.layout import CONFIGURATION
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.recording_index import INDEX, IndexUpdate, Wanted, open_index
from platform_daemon.core.recordings.retention import RetentionRules, old_recordings
from platform_daemon.core.state.errors import IndexUnfinished, StorageError
from platform_daemon.features.trends.baseline import accept
from platform_daemon.features.trends.indexed import (
    UnknownSpecimen,
    find_recordings,
    indexed_specimens,
    indexed_trend,
    known_entries,
    summaries_of,
    update_index,
)
from platform_daemon.features.trends.look import noise_beside
from platform_daemon.features.trends.schema import BaselineRequest
from tests.kit.fit_tables import read_fits
from tests.kit.recording_files import write_minimal, write_series
from tests.kit.specimen_months import DROP_AT, months


@pytest.fixture(scope="module")
def kept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("months")
    months(folder)
    months(folder, 3, specimen="other")
    write_minimal(folder / "foreign.h5")
    (folder / "broken.h5").write_text("no")
    return folder


@pytest.fixture(scope="module")
def indexed(kept, tmp_path_factory):
    """The same with its index, for tests that change nothing: to look at 75 files takes longer than what they ask."""
    folder = shutil.copytree(kept, tmp_path_factory.mktemp("indexed") / "recordings")
    update_index(folder)
    return folder


@pytest.fixture
def folder(indexed, tmp_path):
    """A copy of it, which a test may change; files keep their times, so the index is of these files."""
    return shutil.copytree(indexed, tmp_path / "recordings")


def content(folder):
    """All rows of an index; what it says of a broken file without the folder, which may be a copy."""
    with sqlite3.connect(folder / INDEX) as sql:
        rows = [
            sql.execute(f"SELECT * FROM {table} ORDER BY 1, 2").fetchall()
            for table in ("recordings", "shots", "points")
        ]
    sql.close()
    return [[[re.sub(r"\S+/recordings/", "", str(value)) for value in row] for row in table] for table in rows]


@pytest.mark.long
def test_a_list_opens_only_files_that_the_index_does_not_know_as_they_are(folder, monkeypatch):
    plain = list_recordings(folder).recordings
    opened = []

    def noted(path):
        opened.append(path.name)
        return open_recording(path)

    monkeypatch.setattr("platform_daemon.core.recordings.index.open_recording", noted)
    assert list_recordings(folder, known=partial(known_entries, folder)).recordings == plain
    assert opened == ["broken.h5", "foreign.h5"]
    changed = plain[-1].path
    os.utime(changed)
    opened.clear()
    assert list_recordings(folder, known=partial(known_entries, folder)).recordings == plain
    assert opened == ["broken.h5", "foreign.h5", changed.name]


@pytest.mark.long
def test_lost_magnetisation_is_found_in_files_and_said_by_name(kept, tmp_path):
    folder = shutil.copytree(kept, tmp_path / "recordings")
    found, broken = update_index(folder)
    assert found == IndexUpdate(75, frozenset({"T 1", "other"}))
    assert set(broken) == {"broken"}
    assert indexed_specimens(folder) == ("T 1", "other")
    report = indexed_trend(folder, "T 1")
    assert len(report.points) == 70
    (change,) = report.changes
    assert (change.name, set(change.quantities)) == ("lost_magnetisation", {"f_nat_hz", "m_r_am2"})
    assert change.stands
    at = [point.recording for point in report.points]
    assert abs(at.index(change.since_recording) - DROP_AT) <= 1
    f_nat = next(chart for chart in report.charts if chart.quantity == "f_nat_hz")
    assert f_nat.relative_per_k == pytest.approx(-5e-4, abs=4 * f_nat.relative_per_k_std)
    assert f_nat.relative_per_k_std < 3e-5
    before = np.array(f_nat.corrected[20:DROP_AT])
    assert np.std(before) < 0.3 * np.std(f_nat.value[20:DROP_AT])
    shift = dict(zip(change.quantities, (change.relative,), strict=False))
    expected = {"f_nat_hz": -0.0025, "m_r_am2": -0.005}
    for name, relative in shift.items():
        assert relative == pytest.approx(expected[name], rel=0.05)


def test_a_temperature_that_changed_is_told_while_no_coefficient_is_declared(folder):
    (note,) = [each for each in indexed_trend(folder, "T 1").notes if "temperature_coefficient_per_k" in each]
    assert "is not declared for f_nat_hz: the temperature changed by" in note
    assert "Hz/K: declare it" in note
    newest = folder / "T-1-069.h5"
    with h5py.File(newest, "r+") as h5:
        text = h5[CONFIGURATION][()].decode() + "[uncertainty.temperature_coefficient_per_k]\nf_nat_hz = -0.1\n"
        h5[CONFIGURATION][()] = text
    update_index(folder)
    assert not any("temperature_coefficient_per_k" in each for each in indexed_trend(folder, "T 1").notes)


@pytest.mark.long
def test_only_what_is_new_or_has_changed_is_looked_at_and_the_rest_is_as_if_made_anew(folder):
    assert update_index(folder)[0] == IndexUpdate(0, frozenset())
    (folder / "T-1-000.h5").unlink()
    shutil.copy(folder / "other-000.h5", folder / "other-009.h5")
    os.utime(folder / "other-001.h5", ns=(0, 0))
    assert update_index(folder)[0] == IndexUpdate(2, frozenset({"T 1", "other"}))
    grown = content(folder)
    assert update_index(folder, rebuild=True)[0].looked == 75
    assert content(folder) == grown
    assert len(indexed_trend(folder, "T 1").points) == 69


@pytest.mark.long
@pytest.mark.parametrize("damage", ["text", "version", "empty"])
def test_an_index_that_is_damaged_or_of_another_version_is_made_anew(folder, damage):
    good = content(folder)
    if damage == "version":
        with sqlite3.connect(folder / INDEX) as sql:
            sql.execute("PRAGMA user_version = 99")
        sql.close()
    else:
        (folder / INDEX).write_text("no index\n" * 200 if damage == "text" else "")
        for end in ("-wal", "-shm"):
            (folder / (INDEX + end)).unlink(missing_ok=True)
    with pytest.raises(IndexUnfinished, match="is being made"):  # not the half of it
        indexed_specimens(folder)
    with pytest.raises(IndexUnfinished, match="repeat the request"):
        old_recordings(folder, RetentionRules(0.0), datetime.now(UTC))
    assert update_index(folder)[0].looked == 75
    assert content(folder) == good


def test_of_a_folder_without_recordings_all_is_known_at_once(tmp_path):
    assert indexed_specimens(tmp_path) == ()


@pytest.mark.long
def test_two_programs_may_bring_it_up_to_date_at_once(kept, tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in ("T-1-000.h5", "other-000.h5"):
        shutil.copy(kept / name, folder)
    first, second = open_index(folder), open_index(folder)
    update_index(folder)
    assert first.specimens() == second.specimens() == ["T 1", "other"]
    first.close()
    second.close()


def test_since_and_until_are_times_in_any_zone(indexed):
    folder = indexed
    whole = indexed_trend(folder, "T 1").points
    later = indexed_trend(folder, "T 1", since="2026-03-05T01:00:00+01:00").points
    assert later == whole[16:]
    assert indexed_trend(folder, "T 1", until="2026-03-01T00:00").points == whole[:1]
    assert indexed_trend(folder, "T 1", until="2026-03-01").points == whole[:4]  # all of that day
    with pytest.raises(InputError, match="no time of ISO 8601"):
        indexed_trend(folder, "T 1", since="yesterday")


def test_what_is_known_of_a_specimen_is_what_its_recordings_hold(indexed):
    with closing(open_index(indexed)) as index:
        for name in index.specimens():
            found, each = index.specimen(name), index.recordings(name)
            assert list(found.identifiers) == [one.identifier for one in each]
            assert (found.first, found.last) == (each[0].begun, each[-1].begun)
            assert found.shots == sum(point.shots for one in each for point in one.points) > 0
            assert found.resonators == Counter(one.resonator for one in each)
            assert next(iter(found.resonators)) == each[-1].resonator
            assert found.calibrations == Counter(one.calibration for one in each if one.calibration is not None)
            assert found.tags == sorted({tag for one in each for tag in one.tags})
        assert index.specimen("never") is None


def test_who_was_never_measured_is_named_with_those_who_were(indexed):
    with pytest.raises(UnknownSpecimen, match="T 1, other"):
        indexed_trend(indexed, "nobody")
    with pytest.raises(InputError, match="ask for 100 to 1e\\+06"):
        indexed_trend(indexed, "T 1", points_to_false_alarm=5.0)


def test_a_table_of_fits_is_read_as_it_was_written_and_a_damaged_one_is_named(folder):
    path = folder / "T-1-000.h5"
    (written,) = read_fits(path)
    found = read_fit(open_recording(path), "d30")
    assert found.parameters == written.parameters
    assert np.array_equal(found.values, written.values)
    assert found.verdict == written.verdict
    with pytest.raises(RecordingError, match="/fit/n50/parameters"):
        read_fit(open_recording(path), "n50")


def test_the_noise_beside_a_ring_down_is_that_of_the_channel():
    rate, n = 15_000.0, 15_000
    rng = np.random.default_rng(9)
    t = np.arange(n) / rate
    ring = np.exp(-2.0 * t) * sum(np.sin(2 * np.pi * 213.0 * k * t) / k for k in (1, 2, 3))
    volts = np.stack([ring + rng.normal(0, 1e-3, n), 0.1 * ring + rng.normal(0, 5e-3, n), rng.normal(0, 2e-3, n)])
    found = noise_beside(volts, rate, 213.0)
    assert found == pytest.approx([1e-3, 5e-3, 2e-3], rel=0.08)  # of which the harmonics take some
    humming = volts + 4e-3 * math.sqrt(2) * np.sin(2 * np.pi * 50.0 * t)
    assert noise_beside(humming, rate, 213.0)[0] == pytest.approx(math.hypot(1e-3, 4e-3), rel=0.05)


def test_a_large_swing_which_is_slower_than_f_nat_is_no_noise():
    rate, n, largest = 61_035.0, 36_621, 0.96
    t = np.arange(n) / rate
    swing = largest * np.exp(-1.5 * t)
    phase = np.cumsum(2 * np.pi * 213.0 / (1.0 + swing**2 / 16.0 + 11.0 * swing**4 / 3072.0)) / rate
    ring = 0.6 * swing * np.sin(phase) + 0.03 * swing**3 * np.sin(3 * phase)
    volts = ring + np.random.default_rng(10).normal(0, 7e-4, (3, n))
    assert noise_beside(volts, rate, 213.0, largest) == pytest.approx([7e-4] * 3, rel=0.08)
    assert noise_beside(volts, rate, 213.0).min() > 5e-3  # as if nobody knew how far it swings


def test_a_recording_that_is_refused_or_blank_is_no_point(tmp_path):
    write_series(tmp_path / "plain.h5", 2)
    update_index(tmp_path)
    assert indexed_specimens(tmp_path) == ()


@pytest.mark.parametrize(("wanted", "found"), [
    (Wanted(), 73), (Wanted(specimen="other"), 3), (Wanted(specimen="nobody"), 0), (Wanted(operator="łovelace"), 73),
    (Wanted(operator="lovelace"), 0), (Wanted(operator="ada"), 73), (Wanted(operator="ADA Ł"), 73),
    (Wanted(specimen="T 1", until="2026-03-02T00:00"), 5), (Wanted(since="2026-03-02T02:00:00+02:00"), 66),
    (Wanted(refused=True), 0), (Wanted(refused=False, specimen="T 1"), 70),
])  # fmt: skip
def test_recordings_are_found_by_what_they_say(indexed, wanted, found):
    assert len(find_recordings(indexed, wanted)) == found


def test_a_specimen_that_is_accepted_begins_anew_and_a_damaged_file_of_that_is_named(folder):
    assert indexed_trend(folder, "T 1").changes
    made = accept(folder, "T 1", BaselineRequest(since="2026-03-13T13:00+01:00", by="DC", reason="new magnet"))
    assert made.since == "2026-03-13T12:00:00.000+00:00"
    report = indexed_trend(folder, "T 1")
    assert (len(report.points), report.changes) == (20, ())
    assert report.notes[0] == "restarted at 2026-03-13T12:00:00.000+00:00 by DC: new magnet"
    assert len(indexed_trend(folder, "T 1", since="2026-03-01").changes) == 1
    accept(folder, "other", BaselineRequest(by="DC", reason="also"))
    assert len(indexed_trend(folder, "other").points) == 0
    (later,) = months(folder.parent, 1, specimen="other", begun=datetime(2026, 3, 1, 12, 0, 1, tzinfo=UTC))
    later.rename(folder / "later.h5")  # after the newest one, and long before now
    update_index(folder)
    assert [point.recording for point in indexed_trend(folder, "other").points] == ["later"]
    assert len(indexed_trend(folder, "T 1").points) == 20
    with pytest.raises(InputError, match="still to come"):
        accept(folder, "T 1", BaselineRequest(since="2999-01-01", by="DC", reason="x"))
    (folder / ".baselines.json").write_text("no")
    for ask in (
        lambda: indexed_trend(folder, "T 1"),
        lambda: accept(folder, "T 1", BaselineRequest(by="a", reason="b")),
    ):
        with pytest.raises(StorageError, match="correct the file"):
            ask()


@pytest.mark.long
def test_an_index_that_breaks_in_its_middle_is_named_by_who_reads_it_and_made_anew_by_who_updates_it(folder):
    good = content(folder)
    with sqlite3.connect(folder / INDEX) as sql:
        sql.execute("PRAGMA wal_checkpoint(TRUNCATE)")
    sql.close()
    raw = bytearray((folder / INDEX).read_bytes())
    raw[4096:] = b"\xff" * (len(raw) - 4096)
    (folder / INDEX).write_bytes(raw)
    with pytest.raises(StorageError, match="index rebuild"):
        indexed_trend(folder, "T 1")
    assert update_index(folder)[0].looked == 75  # as whoever brings it up to date does by itself
    assert content(folder) == good


def test_a_list_has_the_means_of_the_fits_of_each_recording(indexed):
    found = summaries_of(indexed, ["T-1-000", "T-1-001", "missing"])
    assert list(found) == ["T-1-000", "T-1-001"]
    for name, summary in found.items():
        recording = open_recording(indexed / f"{name}.h5")
        table = read_fit(recording, "d30")
        for key, value in (("f_nat_hz", summary.f_nat_hz), ("m_r_am2", summary.m_r_am2)):
            assert value == pytest.approx(np.nanmean(table.values[:, table.parameters.index(key)]), rel=1e-12)
        assert summary.sample == "T 1"
        assert (summary.good, summary.refused) == (recording.frames, 0)
    assert summaries_of(indexed, []) == {}


@pytest.mark.parametrize("asked", ["Jürgen 1", "Ju\u0308rgen 1", " Jürgen  1 "])
def test_a_name_that_looks_the_same_is_of_the_same_specimen(tmp_path, asked):
    """In Unicode's composed and decomposed forms, and with blanks that nobody sees."""
    for k, name in enumerate(("Jürgen 1", "Ju\u0308rgen 1", "Jürgen 1 ")):
        (made,) = months(tmp_path, 1, specimen=name, comment="#naïf")
        made.rename(tmp_path / f"{k}.h5")
    update_index(tmp_path)
    assert indexed_specimens(tmp_path) == ("Jürgen 1",)
    assert len(indexed_trend(tmp_path, asked).points) == 3
    assert len(find_recordings(tmp_path, Wanted(specimen=asked, tag="nai\u0308f"))) == 3
    accept(tmp_path, asked, BaselineRequest(by="A", reason="new"))
    assert indexed_trend(tmp_path, "Jürgen 1").points == ()


def test_who_looks_at_a_folder_that_is_read_only_sees_its_trends(folder, monkeypatch):
    (folder / INDEX).unlink()
    before = {path.name for path in folder.iterdir()}
    access = os.access
    monkeypatch.setattr(os, "access", lambda path, how: how != os.W_OK and access(path, how))  # root may write anywhere
    update_index(folder)
    assert len(indexed_trend(folder, "T 1").points) == 70
    assert {path.name for path in folder.iterdir()} == before


def test_a_file_that_could_not_be_read_for_a_moment_is_read_later(tmp_path, monkeypatch):
    """Nothing of the file changes in between."""
    months(tmp_path, 1)
    refused = Path.open

    def no_permission(path, *rest, **more):
        if path.suffix == ".h5":
            raise PermissionError(13, "Permission denied")
        return refused(path, *rest, **more)

    monkeypatch.setattr(Path, "open", no_permission)
    assert "no permission" in str(update_index(tmp_path)[1])
    monkeypatch.undo()
    assert update_index(tmp_path)[1] == {}
    assert indexed_specimens(tmp_path) == ("T 1",)
