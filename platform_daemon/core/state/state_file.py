"""The state of a daemon: one SQLite file of a data folder, with its jobs and its alarms."""

from __future__ import annotations

from .database import Schema, WhenDamaged, tables

STATE = "state.sqlite"
"""Name of the file in the data folder."""
STATE_SCHEMA = Schema(
    title="the state of the daemon",
    application_id=0x4D4D5253,  # "MMRS"
    version=1,
    create=tables("""
CREATE TABLE jobs (id TEXT PRIMARY KEY, state TEXT NOT NULL, record TEXT NOT NULL) STRICT;
CREATE INDEX states_of_jobs ON jobs (id, state);
CREATE TABLE alarms (name TEXT PRIMARY KEY, alarm TEXT NOT NULL) STRICT
"""),
    when_damaged=WhenDamaged.REFUSE,
    journal="TRUNCATE",
)
"""jobs: record: JSON of a JobRecord, state: its state; alarms: alarm: JSON of an Alarm."""
UPSERT_JOB = (
    "INSERT INTO jobs (id, state, record) VALUES (?, ?, ?)"
    " ON CONFLICT (id) DO UPDATE SET state = excluded.state, record = excluded.record"
)
