"""Do ledger, jobs, recordings, events, alarms and the world tell the same of a night?  Each check is a sentence for
every contradiction."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator
from datetime import datetime
from itertools import chain
from typing import Any

from tests.campaigns.night.night import EVERY_S, FAILURES, SHOTS, Night

ENDS = {"run", "late", "skipped", "missed", "failed"}
AFTER_S = 10.0
"""So long after a fault is over its consequences may be told: a daemon that has to find its devices again."""
BUSY = "the host was too late"
"""A computer that was itself late says so; here it does other work, too."""


def contradictions(night: Night) -> list[str]:
    """All of them."""
    checks = (_instants, _analyses, _jobs, _recordings, _shot_events, _row_events, _alarms, _calls, _causes, _world)
    return list(chain.from_iterable(check(night) for check in checks))


def _analyses(night: Night) -> Iterator[str]:
    """Fits by the calendar have come to an end, too; the first is due before anything was measured."""
    for k, row in enumerate(night.analyses):
        if row["state"] not in ENDS or (row["state"] != "run" and not row["reason"]):
            yield f"{_named(row)} of the fits: {row['reason']}"
        if k == 0 and "no recording is of" not in str(row["reason"]):
            yield f"the first fit was due before there was anything, and is {row['state']}: {row['reason']}"
    if len(night.analyses) > 3 and not any(row["state"] == "run" for row in night.analyses):
        yield "no fit by the calendar was made"


def _instants(night: Night) -> Iterator[str]:
    """Every due instant is in the ledger once, and has come to an end."""
    due = [_s(row["due"]) for row in night.rows]
    for k, at in enumerate(due):
        if abs(at - night.first_due - k * EVERY_S) > 1e-3:
            yield f"row {k + 1} is due {at - night.first_due:.3f} s after the first"
            return
    if len(due) < (night.ended - night.began) // EVERY_S - 20:
        yield f"only {len(due)} rows"
    for row in night.rows:
        if row["state"] not in ENDS:
            yield f"{_named(row)} has not ended"
        if row["state"] not in ("run",) and not row["reason"]:
            yield f"{_named(row)} has no reason"
        if (row["state"] in ("run", "late")) != (row["recording"] is not None) and row["state"] != "failed":
            yield f"{_named(row)}: recording {row['recording']}"


def _jobs(night: Night) -> Iterator[str]:
    """Every row that was started has one job, with the same end for the same reason; no job has no row."""
    told = Counter(row["job"] for row in night.rows if row["job"] is not None)
    yield from (f"{job} is in {n} rows" for job, n in told.items() if n > 1)
    yield from (f"{job} is in no row" for job in night.jobs.keys() - told.keys())
    for row in night.rows:
        job = night.jobs.get(row["job"])
        if row["state"] in ("run", "late") and (job is None or job["state"] != "done"):
            yield f"{_named(row)}: its job is {job and job['state']}"
        if row["state"] == "failed" and job is not None:
            detail = (job["error"] or {}).get("detail")
            if job["state"] != "failed" or str(detail) not in str(row["reason"]):
                yield f"{_named(row)}: its job is {job['state']}, {detail}; the ledger says {row['reason']}"


def _recordings(night: Night) -> Iterator[str]:
    """What a job says that it has recorded is there, and nothing else."""
    said = {job["result"]["recording"]: job for job in night.jobs.values() if job["result"].get("recording")}
    yield from (f"recording {name} belongs to no job" for name in night.recordings.keys() - said.keys())
    yield from (f"recording {name} is not there" for name in said.keys() - night.recordings.keys())
    for name in said.keys() & night.recordings.keys():
        job, found = said[name]["result"], night.recordings[name]
        refused = sum(info.verdict != "good" for info in found.frame_info)
        if (job["shots"], job.get("refused") or 0) != (found.frames, refused):
            yield f"{name}: {found.frames} shots, {refused} refused; its job says {job['shots']}, {job.get('refused')}"
        whole = found.provenance is not None and found.provenance.incomplete is None
        if whole != (found.frames == SHOTS):
            yield f"{name}: {found.frames} shots, and told to be {'whole' if whole else 'incomplete'}"
        if said[name]["state"] == "done" and not whole:
            yield f"{name} is incomplete, and its job done"
        if any(info.verdict != "good" and not info.reason for info in found.frame_info):
            yield f"{name}: a shot was refused for no reason"


def _shot_events(night: Night) -> Iterator[str]:
    """Each shot on disk was told once, with the verdict that it has."""
    told = [each["what"] for each in night.events if each["what"]["kind"] == "shot"]
    seen = Counter((each["recording"], each["frame"], each["verdict"]) for each in told)
    there = Counter(
        (name, k, info.verdict) for name, found in night.recordings.items() for k, info in enumerate(found.frame_info)
    )
    yield from (f"shot {shot} is in its recording, and was told {seen[shot]} times" for shot in there - seen)
    yield from (f"shot {shot} was told, and is not in its recording" for shot in seen - there)


def _row_events(night: Night) -> Iterator[str]:
    """The last event of a row is the state that it has."""
    last: dict[str, str] = {}
    for each in _of("schedule", night):
        last[each["due"]] = each["state"]
    for row in night.rows:
        if last.get(row["due"]) != row["state"]:
            yield f"{_named(row)}: its last event says {last.get(row['due'])}"


def _alarms(night: Night) -> Iterator[str]:
    """Those of the schedule and of its jobs follow from what became of them, in order; what is wrong in the end
    stands."""
    rows = [(e["state"] in ("missed", "failed"), e["state"] in ("run", "late")) for e in _of("schedule", night)]
    jobs = [
        (e["state"] == "failed", e["state"] == "done")
        for e in _of("job", night)
        if e["job_kind"] == "acquisition" and e["within"] is None
    ]
    schedule = next(e["schedule"] for e in _of("schedule", night))
    for name, course in ((f"schedule:{schedule}", rows), ("failed:acquisition", jobs)):
        expected, stands = [], False
        for bad, good in course:
            if (bad and not stands) or (good and stands):
                stands = bad
                expected.append("raised" if bad else "cleared")
        found = [e["state"] for e in _of("alarm", night) if e["alarm"] == name]
        if found != expected:
            yield f"alarm {name} was {' '.join(found) or 'never raised'}, not {' '.join(expected) or 'never'}"
        if stands != (name in night.standing):
            yield f"alarm {name} {'does not stand' if stands else 'stands'} in the morning"


def _calls(night: Night) -> Iterator[str]:
    """Somebody was called for each alarm that was raised, once."""
    raised = Counter(e["alarm"] for e in _of("alarm", night) if e["state"] == "raised")
    called = Counter(each["name"] for each in night.called)
    if raised != called:
        yield f"raised were {dict(raised)}, called {dict(called)}"


def _causes(night: Night) -> Iterator[str]:
    """Nothing fails, is late or is refused but when something was done to it."""
    for row in night.rows:
        if row["state"] == "run":
            continue
        switched_off = row["state"] == "skipped" and f"{FAILURES} failures in a row" in str(row["reason"])
        if not switched_off and not _struck(night, _s(row["due"]), _s(row["ended"] or row["deadline"])):
            yield f"{_named(row)}: {row['reason']}, and nothing was done to it"
    for name, found in night.recordings.items():
        for info in found.frame_info:
            at = _s(info.time_stamp or "")
            if info.verdict != "good" and BUSY not in info.reason and not _struck(night, at, at + 1.0):
                yield f"{name}: a shot was refused, {info.reason}, and nothing was done to it"


def _world(night: Night) -> Iterator[str]:
    """Power never met a connected receiver, and the lab has played what was recorded."""
    if night.met:
        yield f"power met a connected receiver {night.met} times"
    if night.played < (stored := sum(found.frames for found in night.recordings.values())):
        yield f"{stored} shots were recorded, {night.played} were played"


def _of(kind: str, night: Night) -> list[dict[str, Any]]:
    """What has happened, of that kind; of the schedule of the series only."""
    first = {row["due"] for row in night.rows}
    found = [each["what"] for each in night.events if each["what"]["kind"] == kind]
    return [each for each in found if kind != "schedule" or each["due"] in first]


def _struck(night: Night, began: float, ended: float) -> bool:
    return any(blow.began < ended + 1.0 and began < blow.mended + AFTER_S for blow in night.blows)


def _named(row: dict[str, Any]) -> str:
    return f"row {row['number']} ({row['state']}, due {row['due']})"


def _s(instant: str) -> float:
    return datetime.fromisoformat(instant).timestamp()
