"""Fits of a specimen as CSV and Parquet: the same columns and content, whatever became of the shots."""

import csv
import io
from datetime import UTC, datetime

import pytest

from platform_daemon.features.trends.fit_exports import columns_of, fits_csv, fits_parquet

SHOT = {"recording": "a", "frame": 0, "at": "2026-03-01T10:00:01.25+00:00", "shot_verdict": "good", "fit": "d30"}
GOOD = {**SHOT, "verdict": "good", "f_nat_hz": 213.1, "f_nat_hz_std": 1e-3, "noise_x_v": 2e-6}
REFUSED = {**SHOT, "frame": 1, "verdict": "refused", "reason": "no signal"}


def read(rows):
    parquet = pytest.importorskip("pyarrow.parquet")
    return parquet.read_table(io.BytesIO(fits_parquet(rows)))


def test_both_files_hold_the_same():
    rows = [GOOD, REFUSED]
    table = read(rows)
    of_csv = list(csv.DictReader(io.StringIO(fits_csv(rows).decode())))
    assert list(of_csv[0]) == table.column_names
    for written, kept in zip(of_csv, table.to_pylist(), strict=True):
        assert datetime.fromisoformat(written.pop("at")) == kept.pop("at")
        assert written == {name: "" if value is None else str(value) for name, value in kept.items()}


def test_time_is_a_time_and_nothing_is_null():
    good, refused = read([GOOD, REFUSED]).to_pylist()
    assert good["at"] == datetime(2026, 3, 1, 10, 0, 1, 250_000, tzinfo=UTC)
    assert (good["reason"], refused["reason"], refused["f_nat_hz"], refused["frame"]) == (None, "no signal", None, 1)


def test_the_columns_do_not_depend_on_what_was_refused():
    good, refused = read([GOOD]), read([REFUSED])
    assert good.schema.equals(refused.schema, check_metadata=True)
    assert read([]).schema.equals(good.schema)
    assert fits_csv([GOOD]).splitlines()[0] == fits_csv([]).splitlines()[0]


def test_what_adopted_models_add_stands_behind():
    further = columns_of([{**GOOD, "wobble_hz": 1.0, "wobble_hz_std": 0.1}])[-2:]
    assert [(each.name, each.unit) for each in further] == [("wobble_hz", "Hz"), ("wobble_hz_std", "Hz")]


def test_each_field_has_its_unit_and_says_what_it_is():
    schema = read([GOOD]).schema
    assert schema.field("f_nat_hz").metadata[b"unit"] == b"Hz"
    assert b"natural frequency" in schema.field("f_nat_hz").metadata[b"description"]
    assert schema.field("noise_x_v").metadata[b"unit"] == b"V"
    assert b"unit" not in schema.field("at").metadata
    assert all(b"description" in schema.field(name).metadata for name in schema.names)
