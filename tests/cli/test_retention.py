"""Old recordings go when a person says so, and only those that may."""

import json
import shutil
from datetime import UTC, datetime, timedelta

import pytest

from platform_daemon.core.recordings.assembly import header_of
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.retention import RetentionRules, old_recordings
from platform_daemon.core.recordings.series_writer import SeriesWriter
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.specimen_months import months


@pytest.fixture(scope="module")
def originals(tmp_path_factory):
    folder = tmp_path_factory.mktemp("originals")
    months(folder, 4)
    months(folder, 2, "kept", comment="first light #keep")
    (folder / "broken.h5").write_text("no recording")
    return folder


@pytest.fixture
def recordings(originals, tmp_path):
    return shutil.copytree(originals, tmp_path / "data" / "recordings")


def names(folder):
    return sorted(path.name for path in folder.glob("*.h5"))


def asked(recordings, *words):
    return here("retention", "--older-than-days", "1", "--keep-newest", "1", "--recordings", recordings, *words)


def test_a_dry_run_says_what_would_go_and_touches_nothing(recordings):
    before = names(recordings)
    told = asked(recordings)
    assert told.returncode == 0, told.stderr
    assert [line.split()[-1] for line in told.stdout.splitlines()[:-1]] == [f"T-1-00{k}.h5" for k in range(3)]
    assert "3 recordings" in told.stdout
    assert "nothing was touched" in told.stdout
    assert names(recordings) == before


def test_what_was_made_from_recordings_keeps_them(recordings):
    models = recordings.parent / "models"
    models.mkdir()
    (models / "quiet@1.json").write_text(json.dumps({"recordings": [{"file": "T-1-001.h5"}]}))
    told = asked(recordings)
    assert "2 recordings" in told.stdout
    assert "1 stay because a model, a preset or a resonator was made from them" in told.stdout
    (recordings / "T-1-000.h5").rename(recordings / "T-1-000.mmr")
    (recordings.parent / "resonators").mkdir()
    (recordings.parent / "resonators" / "jewel@1.toml").write_text('evidence = "ramp T-1-000: no side modes"')
    assert "1 recordings" in asked(recordings).stdout


def test_a_series_that_is_gone_on_with_stays_though_it_is_old(recordings):
    target = recordings / "T-1-001.h5"
    with SeriesWriter.go_on(target, header_of(open_recording(target))[0]) as series:
        told = asked(recordings, "--delete")
        series.drop()
    assert "2 recordings" in told.stdout
    assert target.exists()


@pytest.mark.parametrize("tag", ["", "#", " "])
def test_a_tag_without_a_name_is_refused_where_it_would_let_all_go(recordings, tag):
    before = names(recordings)
    assert_one_line_error(asked(recordings, "--keep-tag", tag, "--delete"), 2, "--keep-tag")
    assert names(recordings) == before


@pytest.mark.parametrize("days", ["nan", "inf", "1e9", "0"])
def test_an_age_that_is_none_is_refused(recordings, days):
    told = here("retention", "--older-than-days", days, "--recordings", recordings)
    assert_one_line_error(told, 2, "--older-than-days")


def test_they_are_moved_whole_and_never_over_another(recordings, tmp_path):
    archive = tmp_path / "archive"
    assert asked(recordings, "--archive", archive).returncode == 2  # there is none
    archive.mkdir()
    content = (recordings / "T-1-000.h5").read_bytes()
    assert asked(recordings, "--archive", archive).returncode == 0
    assert names(archive) == [f"T-1-00{k}.h5" for k in range(3)]
    assert (archive / "T-1-000.h5").read_bytes() == content
    assert names(recordings) == ["T-1-003.h5", "broken.h5", "kept-000.h5", "kept-001.h5"]
    assert [path.name for path in archive.iterdir() if path.name.startswith(".")] == []
    (archive / "T-1-003.h5").write_text("another")
    again = here(
        "retention", "--older-than-days", "1", "--keep-newest", "0", "--recordings", recordings, "--archive", archive
    )
    assert again.returncode == 2
    assert "is in the archive" in again.stderr
    assert (archive / "T-1-003.h5").read_text() == "another"
    assert "T-1-003.h5" in names(recordings)


def test_they_are_deleted_only_when_that_is_said(recordings):
    assert asked(recordings, "--delete", "--archive", recordings.parent).returncode == 2
    assert asked(recordings, "--delete").returncode == 0
    assert names(recordings) == ["T-1-003.h5", "broken.h5", "kept-000.h5", "kept-001.h5"]


def test_age_counts_from_the_begin(recordings):
    asked(recordings)
    begun = datetime(2026, 3, 1, tzinfo=UTC)
    rules = RetentionRules(older_than_days=1, keep_tags=frozenset())
    assert old_recordings(recordings, rules, begun + timedelta(days=1)) == []
    assert len(old_recordings(recordings, rules, begun + timedelta(days=1, hours=7))) == 4
