"""`schedule add | list | ledger | preview | pause | resume | run | remove | mounted` call the daemon."""

from __future__ import annotations

import json
import sys
import tomllib
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from drivers.errors import InputError
from drivers.text_files import read_text_file
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, write_json

if TYPE_CHECKING:
    from platform_daemon.core.service.proxy import PlatformServiceProxy

    from .contract import ScheduleService
    from .schema import LedgerRow, Schedule, ScheduleRequest

schedule_app = typer.Typer(help="Schedules of a running daemon: work by the calendar, and the ledger of its starts.")
DataOption = Annotated[Path, typer.Option("--data", help="Data folder of the daemon.")]
NameArgument = Annotated[str, typer.Argument(help="Name of the schedule.")]
IdArgument = Annotated[str, typer.Argument(help="Name of the schedule, or its id as `schedule list` shows it.")]
EveryOption = Annotated[
    float | None, typer.Option("--every-s", help="Interval, s; due at --start first, without it at once.")
]
CronOption = Annotated[str | None, typer.Option("--cron", help="Five fields: minute, hour, day, month, weekday.")]
AtOption = Annotated[list[str] | None, typer.Option("--at", help="A date, ISO 8601; may be repeated.")]
ZoneOption = Annotated[str, typer.Option("--time-zone", help="IANA name of the zone of --cron and --at.")]
WorkOption = Annotated[
    Path | None, typer.Option("--work", help="File with `kind` and `request` of the work, JSON or TOML.")
]
ResonatorOption = Annotated[
    list[str] | None,
    typer.Option("--resonator", help="In place of --work: a series of this resonator; several: in rotation."),
]
ShotsOption = Annotated[int, typer.Option("--shots", help="Shots of that series.")]
JitterOption = Annotated[float, typer.Option("--jitter-s", help="Each start is put off by up to this, s.")]
GraceOption = Annotated[float, typer.Option("--grace-s", help="A start that has to wait longer is missed, s.")]
PolicyOption = Annotated[str, typer.Option("--policy", help="Of starts that waited: coalesce, skip or run_all.")]
PriorityOption = Annotated[int, typer.Option("--priority", help="Of several that wait the highest begins first.")]
StartOption = Annotated[str | None, typer.Option("--start", help="Nothing is due before it, ISO 8601; default: now.")]
UntilOption = Annotated[str | None, typer.Option("--until", help="Nothing is due after it, ISO 8601.")]
FailuresOption = Annotated[
    int, typer.Option("--max-failures", help="Failures in a row after which the schedule is suspended.")
]
DATA = Path("data")
_OF_WORK = "Give --work FILE with what belongs to the work itself, as --rx-s of `measure` or its sequence."


@schedule_app.command(epilog=_OF_WORK)
def add(
    name: NameArgument,
    every_s: EveryOption = None,
    cron: CronOption = None,
    at: AtOption = None,
    time_zone: ZoneOption = "UTC",
    work: WorkOption = None,
    resonators: ResonatorOption = None,
    shots: ShotsOption = 1,
    jitter_s: JitterOption = 0.0,
    grace_s: GraceOption = 3600.0,
    policy: PolicyOption = "coalesce",
    priority: PriorityOption = 0,
    start: StartOption = None,
    until: UntilOption = None,
    max_failures: FailuresOption = 3,
    data: DataOption = DATA,
) -> None:
    """Start a work by the calendar from now on; its id is printed."""
    trigger = _trigger(every_s, cron, at, time_zone, jitter_s)
    rest = {"grace_s": grace_s, "policy": policy, "priority": priority, "max_failures": max_failures}
    span = {"start": start, "until": until}
    request = _request({"name": name, "trigger": trigger, **_work(work, resonators, shots), **rest, **span})
    made = schedules_of(data).add(request)
    print(f"{made.id}: next {made.next_due or 'never'}")
    _say_at_once(every_s, start)


@schedule_app.command(epilog=_OF_WORK)
def preview(
    every_s: EveryOption = None,
    cron: CronOption = None,
    at: AtOption = None,
    time_zone: ZoneOption = "UTC",
    work: WorkOption = None,
    resonators: ResonatorOption = None,
    shots: ShotsOption = 1,
    jitter_s: JitterOption = 0.0,
    start: StartOption = None,
    until: UntilOption = None,
    count: Annotated[int, typer.Option("--count", help="So many instants.", min=1, max=1000)] = 10,
    data: DataOption = DATA,
) -> None:
    """When such a schedule would start; nothing is kept."""
    trigger = _trigger(every_s, cron, at, time_zone, jitter_s)
    span = {"start": start, "until": until}
    request = _request({"name": "preview", "trigger": trigger, **_work(work, resonators, shots), **span})
    for due in schedules_of(data).preview(request, count):
        print(due)
    _say_at_once(every_s, start)


@schedule_app.command("list")
def list_all(
    data: DataOption = DATA, json_file: JsonOption = None, csv_file: CsvOption = None, force: ForceOption = False
) -> None:
    """All schedules, and when they start next."""
    from .schema import ScheduleListing

    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    found = schedules_of(data).list()
    write_json(json_file, ScheduleListing(items=found))
    write_csv(csv_file, found)
    for each in found:
        _show(each)


@schedule_app.command()
def ledger(
    identifier: IdArgument,
    after: Annotated[int, typer.Option("--after", help="Rows with larger numbers.", min=0, max=2**53)] = 0,
    limit: Annotated[int, typer.Option("--limit", help="At most so many rows.", min=1, max=1000)] = 100,
    data: DataOption = DATA,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """What became of each start, oldest first."""
    from .readings import with_readings

    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    page = schedules_of(data).page(_id(identifier, data), after, limit)
    page = with_readings(page, data / "recordings", data / "measurands")
    write_json(json_file, page)
    write_csv(csv_file, page.items)
    for row in page.items:
        late = "" if row.late_s is None else f"  {row.late_s:.1f} s late"
        what = f"{row.recording or row.job or ''}  {row.reason or ''}".rstrip()
        print(f"{row.number:>6}  {row.due}  {row.state:<8}{late}  {what}{_read(row)}".rstrip())
    if page.next is not None:
        print(f"more: --after {page.items[-1].number}")


@schedule_app.command()
def pause(identifier: IdArgument, data: DataOption = DATA) -> None:
    """Suspend a schedule: it starts nothing more; a running job continues."""
    _show(schedules_of(data).pause(_id(identifier, data)))


@schedule_app.command()
def resume(identifier: IdArgument, data: DataOption = DATA) -> None:
    """Start again what is due from now on, also where the clock had been ahead."""
    _show(schedules_of(data).resume(_id(identifier, data)))


@schedule_app.command()
def run(identifier: IdArgument, data: DataOption = DATA) -> None:
    """Start it once, now, in addition to its trigger."""
    row = schedules_of(data).run(_id(identifier, data))
    print(f"row {row.number} of the ledger, due {row.due}")


@schedule_app.command()
def remove(identifier: IdArgument, data: DataOption = DATA) -> None:
    """It starts nothing any more; its ledger stays."""
    print(f"{schedules_of(data).remove(_id(identifier, data)).id}: removed")


@schedule_app.command()
def mounted(
    resonator: Annotated[str, typer.Argument(help="Which one was put into the clamping unit.")],
    by: Annotated[str, typer.Option("--by", help="Who has done it.")],
    data: DataOption = DATA,
) -> None:
    """Say what is in the clamping unit: schedules of several resonators in turn wait for it."""
    from drivers.validation import validated
    from platform_daemon.core.schemas.unattended import MountRequest

    request = validated(MountRequest, {"resonator": resonator, "by": by}, "mounted")
    print(f"{_proxy(data).set_mounted(request).resonator} is there")


def _read(row: LedgerRow) -> str:
    """What the recording of a row reads, if its resonator is a sensor."""
    told = row.measurand
    if told is None:
        return ""
    if told.value is None or told.U is None:
        return f"  no {told.name}: {told.reason}"
    return f"  {told.name} {told.value:.6g} {told.unit}, U = {told.U:.2g} {told.unit} (95 %)"


def _say_at_once(every_s: float | None, start: str | None) -> None:
    if every_s is not None and start is None:
        print("an interval without --start is due at once", file=sys.stderr)


def _id(given: str, data: Path) -> str:
    from .named import named_id

    return named_id(schedules_of(data), given)


def schedules_of(data: Path) -> ScheduleService:
    """The schedules of the daemon in that folder.  Raises InputError if none works there."""
    service: ScheduleService = _proxy(data).service("schedules")
    return service


def _proxy(data: Path) -> PlatformServiceProxy:
    from platform_daemon.core.service.proxy import PlatformServiceProxy

    if not (data / "hardware.sock").exists():
        remedy = f"start it (platform-daemon serve --data {data}), or name the folder of the one that runs with --data"
        raise InputError("no daemon works in this folder", where=str(data), remedy=remedy)
    return PlatformServiceProxy(data)


def _show(schedule: Schedule) -> None:
    state = f"next {schedule.next_due or 'never'}" if schedule.active else f"off: {schedule.reason}"
    ahead = (
        "" if schedule.ahead_until is None else f"  the clock has been at {schedule.ahead_until} already, see resume"
    )
    name = "?" if schedule.request is None else schedule.request.name
    print(f"{schedule.id}  {name}  {state}{ahead}")


def _trigger(
    every_s: float | None, cron: str | None, at: list[str] | None, time_zone: str, jitter_s: float
) -> dict[str, Any]:
    given = {"every_s": every_s, "cron": cron, "at": at or None}
    return {
        **{key: value for key, value in given.items() if value is not None},
        "time_zone": time_zone,
        "jitter_s": jitter_s,
    }


def _work(file: Path | None, resonators: list[str] | None, shots: int) -> dict[str, Any]:
    """`work` and `resonators`.  Raises InputError for a file that cannot be read, if both are given or none is."""
    if (file is None) == (not resonators):
        remedy = "give --work FILE or --resonator NAME; a file names `resonators` next to `kind` and `request`"
        raise InputError("one work is needed", where="--work, --resonator", remedy=remedy)
    if file is None:
        assert resonators
        work = {"kind": "acquisition", "request": {"resonator": resonators[0], "shots": shots}}
        return {"work": work, "resonators": resonators if len(resonators) > 1 else None}
    try:
        text = read_text_file(file)
        found = tomllib.loads(text) if file.suffix == ".toml" else json.loads(text)
    except OSError as error:
        why = error.strerror or str(error)
        raise InputError("cannot be read", where=str(file), why=why, remedy="check the path") from None
    except (ValueError, RecursionError) as error:
        remedy = "write JSON or TOML with `kind` and `request`"
        raise InputError("the work cannot be read", where=str(file), why=str(error), remedy=remedy) from None
    if not isinstance(found, dict):
        raise InputError("is no table", where=str(file), remedy="write `kind` and `request`")
    return {"resonators": found.pop("resonators", None), "work": found}


def _request(keys: dict[str, Any]) -> ScheduleRequest:
    """Raises InputError with the option or key that is wrong."""
    from drivers.validation import validated

    from .schema import ScheduleRequest

    return validated(ScheduleRequest, keys, "schedule")
