"""What a recording holds, in words."""

from platform_daemon.reports.tables import info_text
from platform_daemon.store.describe import describe
from platform_daemon.store.reader import open_recording
from platform_daemon.store.series_writer import SeriesWriter
from tests.kit.data import DATA
from tests.kit.recording_files import header, shot


def test_shots_are_a_table_and_nobody_reads_what_nobody_knows(tmp_path, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    with SeriesWriter.create(tmp_path / "a.h5", header(comment="")) as writer:
        for taken in (shot(1, blank=True), shot(2, verdict="refused", reason="too loud"), shot(3, lna_overload=True)):
            writer.add_shot(taken)
        writer.finish(())
    text = info_text(describe(open_recording(tmp_path / "a.h5")))
    lines = text.splitlines()
    assert "sample: T 1" in lines
    assert not any(word in text for word in ("None", "null", "comment", "False", "{"))
    heading = next(line for line in lines if line.startswith("┃ frame"))
    assert [word for word in ("verdict", "reason", "flags", "blank", "field_t") if word in heading] == [
        "verdict", "reason", "flags", "blank", "field_t",
    ]  # fmt: skip
    rows = [line for line in lines if line.startswith("│")]
    assert ["yes" in row for row in rows] == [True, False, False]
    assert "too loud" in rows[1]
    assert "lna_overload" in rows[2]


def test_a_minimal_recording_has_no_table_of_shots():
    text = info_text(describe(open_recording(DATA / "example_jewel.mmr.h5")))
    assert "variant: jewel" in text
    assert "shots" not in text
    assert "devices" not in text
