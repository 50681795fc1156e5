"""Which recordings calibrate a sensor: those of a schedule by its ledger, of one resonator and one sample."""

import os
import re
import shutil
from datetime import datetime, timedelta
from pathlib import Path

import h5py
import pytest

from drivers.errors import InputError, RecordingError
from platform_daemon.core.recordings.layout import CONFIGURATION
from platform_daemon.core.settings import load_specimen
from platform_daemon.features.measurand.library import Measurands
from platform_daemon.features.measurand.online import NewestCalibrations
from platform_daemon.features.schedules.ledger import Ledger, ScheduleRecord
from platform_daemon.features.schedules.schedules import Schedules, UnknownSchedule
from platform_daemon.features.schedules.schema import ScheduleRequest
from platform_daemon.features.sensor_calibration.series import Series, series_of
from platform_daemon.features.sensor_calibration.stored import calibration_by

NOON_S = 1_790_000_000.0  # 2026-09-21T14:13:20+00:00
HOUR_S = 3600.0
SAMPLE, NAME = "/entry/sample/name", "paper jewel specimen"
TEXT = (
    '{"name": "%s", "trigger": {"every_s": 3600}, "work": {"kind": "acquisition", "request": {"resonator": "jewel"}}}'
)


@pytest.fixture
def schedules(tmp_path):
    """`nightly` has recorded a, b and c, an hour apart, and failed once; `new` has recorded nothing."""
    ledger = Ledger(tmp_path / "schedules.db")
    for name in ("nightly", "new"):
        request = ScheduleRequest.model_validate_json(TEXT % name)
        ledger.add(ScheduleRecord(id=f"schedule-{name}", request=request, created=NOON_S, reached=NOON_S))
    for k, recording in enumerate(("a", "b", None, "c")):
        due = NOON_S + k * HOUR_S
        ledger.reach("schedule-nightly", [(due, due, due + HOUR_S)], due)
        (row,) = ledger.open_rows()
        assert ledger.claim(row, due, f"job-{k}")
        ledger.end(row, "failed" if recording is None else "run", due, reason=None, recording=recording, off=None)
    ledger.close()
    made = Schedules(tmp_path / "schedules.db", launcher=None)
    made.open()
    yield made
    made.close()


@pytest.fixture
def recordings(tmp_path):
    folder = tmp_path / "recordings"
    folder.mkdir()
    for name in "abc":
        (folder / f"{name}.h5").write_bytes(b"")
    return folder


def names_in(found):
    return "".join(path.stem for path in found.files)


def test_a_schedule_has_its_recordings_by_name_and_by_id(schedules, recordings):
    assert names_in(series_of(schedules, "nightly", recordings)) == "abc"
    assert names_in(series_of(schedules, "schedule-nightly", recordings)) == "abc"


@pytest.mark.parametrize(
    ("since", "until", "names"),
    [
        ("2026-09-21T15:00:00", None, "bc"),
        (None, "2026-09-21T17:13:19+01:00", "ab"),
        ("2026-09-21T15:13:20", "2026-09-21T15:13:20+00:00", "b"),
        ("2026-09-21", "2026-09-21", "abc"),
    ],
)
def test_times_choose_by_the_start(schedules, recordings, since, until, names):
    assert names_in(series_of(schedules, "nightly", recordings, since, until)) == names


def test_what_was_deleted_is_counted(schedules, recordings):
    (recordings / "b.h5").unlink()
    found = series_of(schedules, "nightly", recordings)
    assert (names_in(found), found.missing) == ("ac", 1)
    for name in "ac":
        (recordings / f"{name}.h5").unlink()
    with pytest.raises(InputError, match=r"nightly: none of the recordings of the schedule is there. 3 are not in"):
        series_of(schedules, "nightly", recordings)


def test_what_a_schedule_cannot_give(schedules, recordings):
    with pytest.raises(UnknownSchedule, match=r"no schedule 'weekly'. there are: nightly, new"):
        series_of(schedules, "weekly", recordings)
    with pytest.raises(InputError, match=r"new: the schedule has recorded nothing\. Remedy: .*schedule ledger"):
        series_of(schedules, "new", recordings)
    with pytest.raises(InputError, match="recorded nothing between 2030-01-01 and now"):
        series_of(schedules, "nightly", recordings, "2030-01-01")
    with pytest.raises(InputError, match="'yesterday' is no time"):
        series_of(schedules, "nightly", recordings, "yesterday")


@pytest.fixture
def specimen():
    measurand = {"name": "temperature", "unit": "degC"}
    found, _ = load_specimen("jewel")
    return type(found).model_validate({**found.model_dump(), "measurand": measurand})


def copy_of(measured, folder, name, *, sample=None, resonator=None):
    """A recording an hour after the one before it, at other temperatures; of another sample, or another resonator."""
    target = folder / f"{name}.h5"
    shutil.copy(measured / "j.h5", target)
    k = len(list(folder.glob("*.h5")))
    with h5py.File(target, "r+") as file:
        stamps, celsius = file["frames/time_stamp"], file["frames/temperature"]
        stamps[...] = [(datetime.fromisoformat(each.decode()) + k * timedelta(hours=1)).isoformat() for each in stamps]
        celsius[...] = [22.0 + 0.3 * k, 22.1 - 0.2 * k]
        texts = {SAMPLE: sample}
        if resonator is not None:
            texts[CONFIGURATION] = file[CONFIGURATION][()].decode().replace(NAME, resonator)
        for place, text in texts.items():
            if text is not None:
                del file[place]
                file[place] = text
    return target


def test_recordings_of_another_resonator_are_refused_by_name_and_left_out_of_a_rotation(measured, specimen, tmp_path):
    mine = [copy_of(measured, tmp_path, k) for k in range(3)]
    other = copy_of(measured, tmp_path, "other", resonator="another one")
    with pytest.raises(InputError, match=r"other.h5: the recording is of another.*of 'another one', not of 'paper"):
        calibration_by(specimen, [*mine, other], None)
    made = calibration_by(specimen, Series("nightly", (*mine, other), 3), None)
    assert [each.file for each in made.files] == ["0.h5", "1.h5", "2.h5"]
    assert "recordings of the schedule 'nightly': 3" in made.notes
    assert "of other resonators, and left out: another one (1)" in made.notes
    assert "not there any more: 3" in made.notes
    with pytest.raises(
        InputError, match=r"nightly: the schedule has no recording of 'paper jewel.*of another one \(1\)"
    ):
        calibration_by(specimen, Series("nightly", (other,), 0), None)


def test_several_samples_are_refused(measured, specimen, tmp_path):
    names = ("T1", "T2", " T2", "T2")
    files = [copy_of(measured, tmp_path, k, sample=name) for k, name in enumerate(names)]
    for given in (files, Series("nightly", tuple(files), 0)):
        with pytest.raises(InputError, match=r"of several samples.*they are of T2 \(3\), T1 \(1\)"):
            calibration_by(specimen, given, None)
    assert calibration_by(specimen, [*files[1:], files[1]], None).pairs == 6  # none counts twice


def test_a_damaged_recording_of_a_schedule_is_left_out_and_told(measured, specimen, tmp_path):
    mine = [copy_of(measured, tmp_path, k) for k in range(3)]
    cut, other, gone = tmp_path / "cut.h5", tmp_path / "other.h5", tmp_path / "gone.h5"
    cut.write_bytes(mine[0].read_bytes()[:20_000])
    other.write_bytes(b"no recording")
    for each in (cut, other):
        os.utime(each, (NOON_S, NOON_S))  # what has just changed may still be written
    made = calibration_by(specimen, Series("nightly", (mine[0], cut, *mine[1:], other, gone), 0), None)
    assert [each.file for each in made.files] == ["0.h5", "1.h5", "2.h5"]
    assert "recordings of the schedule 'nightly': 3" in made.notes
    (told,) = [note for note in made.notes if note.startswith("not readable, and left out: ")]
    assert re.search(r"cut\.h5: .*; other\.h5: not an HDF5 file .*; gone\.h5: no such file", told)
    with pytest.raises(InputError, match=r"^nightly: no recording of the schedule can be read\. cut\.h5: .*Remedy: "):
        calibration_by(specimen, Series("nightly", (cut, other), 0), None)
    with pytest.raises(RecordingError, match=r"cut\.h5"):
        calibration_by(specimen, [*mine, cut], None)
    another = copy_of(measured, tmp_path, "another", resonator="another one")
    with pytest.raises(InputError, match=r"no recording of 'paper.*another one \(1\); not readable: cut\.h5: "):
        calibration_by(specimen, Series("nightly", (another, cut), 0), None)


def test_a_recording_whose_shots_have_no_times_is_left_out_of_a_schedule(measured, specimen, tmp_path):
    mine = [copy_of(measured, tmp_path, k) for k in range(4)]
    with h5py.File(mine[3], "r+") as file:
        file["frames/time_stamp"][...] = ["yesterday", "yesterday"]
    made = calibration_by(specimen, Series("nightly", tuple(mine), 0), None)
    assert (made.pairs, len(made.files)) == (6, 3)
    assert any("3.h5: 'yesterday' is no time of a shot" in note for note in made.notes)


def test_a_file_counts_once_by_whatever_name(measured, specimen, tmp_path, monkeypatch):
    mine = [copy_of(measured, tmp_path, k) for k in range(3)]
    monkeypatch.chdir(tmp_path)
    (tmp_path / "link.h5").symlink_to(mine[0])
    shutil.copy(mine[1], tmp_path / "copy.h5")
    again = [Path("0.h5"), Path("./0.h5"), Path("..") / tmp_path.name / "1.h5", Path("link.h5"), Path("copy.h5")]
    made = calibration_by(specimen, [*mine, *again], None)
    assert (made.pairs, len(made.files)) == (6, 3)
    assert (
        "named twice, and counted once: 0.h5 is 0.h5, 0.h5 is 0.h5, 1.h5 is 1.h5, link.h5 is 0.h5, copy.h5 is 1.h5"
        in (made.notes)
    )


def test_a_copy_that_was_written_anew_is_refused(measured, specimen, tmp_path):
    mine = [copy_of(measured, tmp_path, k) for k in range(3)]
    again = tmp_path / "again.h5"
    shutil.copy(mine[2], again)
    with h5py.File(again, "r+") as file:
        file.attrs["by"] = "another program"
    with pytest.raises(InputError, match=r"two shots were made at the same time.*2 times in all.*leave out"):
        calibration_by(specimen, [*mine, again], None)


def test_names_of_resonators_are_alike_in_both_forms_of_a_letter(measured, specimen, tmp_path):
    composed, apart = "L\u00fcbeck", "Lu\u0308beck"
    mine = [copy_of(measured, tmp_path, k, resonator=apart) for k in range(3)]
    folder = Measurands(tmp_path / "measurands")
    made = folder.add(calibration_by(specimen.model_copy(update={"name": composed}), mine, None))
    assert (made.pairs, folder.of_specimen(apart), NewestCalibrations(tmp_path / "measurands").of(apart)) == (
        6,
        made,
        made,
    )
    assert folder.add(made.model_copy(update={"specimen": apart})).version == 2


@pytest.mark.parametrize(
    ("measurand", "said"),
    [
        ({"reference": {"u": 0.05, "source": "the bridge"}}, r"the readings .* are missing.*'the bridge'.*--reference"),
        ({"longest_lag_s": 60.0}, "the platform tells no lag.*leave longest_lag_s out"),
    ],
)
def test_what_the_platforms_thermometer_is_no_reference_of(measured, specimen, tmp_path, measurand, said):
    mine = [copy_of(measured, tmp_path, k) for k in range(3)]
    declared = specimen.measurand.model_validate({**specimen.measurand.model_dump(), **measurand})
    with pytest.raises(InputError, match=said):
        calibration_by(specimen.model_copy(update={"measurand": declared}), mine, None)


def test_recordings_without_a_good_fit_calibrate_nothing(measured, specimen, tmp_path):
    mine = [copy_of(measured, tmp_path, k) for k in range(2)]
    for each in mine:
        with h5py.File(each, "r+") as file:
            file["fit/d30/verdict"][...] = ["refused", "refused"]
    with pytest.raises(InputError, match=r"no shot has a good fit\. 4 shots were refused\. Remedy: .*fit FILE"):
        calibration_by(specimen, mine, None)
