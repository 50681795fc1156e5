"""The TOML that a catalogue writes."""

import tomllib
from datetime import date

from platform_daemon.core.hardware.catalogue import to_toml


def test_tables_inside_of_tables_lists_and_dates_are_read_as_they_were():
    tables = {
        "name": "T 7",
        "uncertainty": {
            "temperature_coefficient_per_k": {"f_nat_hz": -0.23, "of both": 1},
            "sample_clock": {"u": 1e-06, "certificate": {"number": 'A "1"', "date": date(2026, 1, 1)}},
            "correlation": [{"between": ["gain of channel x", "gain of channel y"], "r": 0.5}],
        },
        "pose": {"tilted": True, "axis": [0.0, -1.0, 0.0]},
    }
    assert tomllib.loads(to_toml(tables)) == tables
