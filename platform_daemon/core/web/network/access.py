"""The table of roles: operation -> lowest role, and how much the answer takes.

A route that is not in the table is refused when the application is made.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from functools import cache
from types import MappingProxyType

from platform_daemon.core.registry import job_features
from platform_daemon.core.schemas.roles import Role


class Takes(Enum):
    """What an answer takes; `Limits` bounds how many of each kind are made at once."""

    NOTHING = "milliseconds"
    READING = "many files"
    COMPUTING = "a core"
    DOWNLOAD = "a core, and memory until the client has fetched it"


@dataclass(frozen=True)
class Access:
    """What an operation requires.

    Attributes:
        role: the lowest role that may do it; None: no token is needed.
        takes: what the answer takes.
        audited: it is recorded in the audit log.
        confirmed: a POST without values, which must be sent as JSON like all others.
    """

    role: Role | None
    takes: Takes = Takes.NOTHING
    audited: bool = False
    confirmed: bool = False


VIEW, VIEW_FILES = Access(Role.VIEWER), Access(Role.VIEWER, Takes.READING)
COMPUTE, DOWNLOAD = Access(Role.VIEWER, Takes.COMPUTING), Access(Role.VIEWER, Takes.DOWNLOAD)
START = Access(Role.OPERATOR, Takes.READING, audited=True)
ACT = Access(Role.OPERATOR, audited=True)
CONFIRM = Access(Role.OPERATOR, audited=True, confirmed=True)
GOVERN = Access(Role.ADMIN, audited=True)

ACCESS: dict[str, Access] = {
    # Health and kinds of problems: for probes, and for the documentation page, which has no token at first.
    "get_health": Access(None),
    "get_problem_kind": Access(None),
    # Files of the operator's page, which asks for the token; and who a caller is, without one: nobody.
    "get_page_file": Access(None),
    "get_caller": Access(None),
    # Stopping is always safe: every valid role may stop.
    "stop": Access(Role.VIEWER, audited=True),
    "reset_amplifier": CONFIRM,
    "reset_fault": ACT,
    "get_entry_points": VIEW,
    "get_readiness": VIEW,
    "get_platform": VIEW,
    "list_changes": VIEW_FILES,
    "list_devices": VIEW,
    "get_mounted_resonator": VIEW,
    "set_mounted_resonator": ACT,
    "list_resonators": VIEW_FILES,
    "get_resonator": VIEW_FILES,
    "add_resonator": ACT,
    "list_sequences": VIEW_FILES,
    "get_sequence": VIEW_FILES,
    "add_sequence": ACT,
    "list_jobs": VIEW,
    "get_shots": VIEW_FILES,
    "order_queue": ACT,
    "pause_acquisition": CONFIRM,
    "resume_acquisition": CONFIRM,
    "dry_run": COMPUTE,
    "dry_run_procedure": COMPUTE,
    "pause_procedure": CONFIRM,
    "resume_procedure": CONFIRM,
    "get_procedure_report": VIEW_FILES,
    "pause_reproduction": CONFIRM,
    "resume_reproduction": CONFIRM,
    "get_reproduction_report": VIEW_FILES,
    "continue_calibration": CONFIRM,
    "adopt_calibration": GOVERN,
    "list_schedules": VIEW,
    "get_schedule": VIEW,
    "get_ledger": VIEW,
    "preview_schedule": COMPUTE,
    "add_schedule": START,
    "pause_schedule": CONFIRM,
    "resume_schedule": CONFIRM,
    "run_schedule": CONFIRM,
    "remove_schedule": ACT,
    "listen": VIEW,
    "list_alarms": VIEW,
    "acknowledge_alarm": ACT,
    "get_metrics": VIEW,
    "list_recordings": VIEW_FILES,
    "get_recording": VIEW_FILES,
    "recover_recordings": Access(Role.OPERATOR, Takes.DOWNLOAD, audited=True, confirmed=True),
    "download_recording": VIEW_FILES,
    "get_dmdt": DOWNLOAD,
    "get_dmdt_npy": DOWNLOAD,
    "get_dmdt_extremes": DOWNLOAD,
    "get_dmdt_h5": DOWNLOAD,
    "list_specimens": VIEW_FILES,
    "get_specimen": COMPUTE,
    "accept_specimen": ACT,
    "get_trend": COMPUTE,
    "get_trend_picture": COMPUTE,
    "get_trend_table": COMPUTE,
    "get_harmonics": COMPUTE,
    "get_live_harmonics": VIEW,
    "get_sliding": COMPUTE,
    "draw_frame": COMPUTE,
    "get_budget": COMPUTE,
    "draw_budget": COMPUTE,
    "read_measurand": COMPUTE,
    "list_measurands": VIEW,
    "get_measurand": VIEW,
    "calibrate_measurand": Access(Role.OPERATOR, Takes.COMPUTING, audited=True),
    "get_frame_plot": COMPUTE,
    "get_derived": COMPUTE,
    "get_envelopes": COMPUTE,
    "predict": COMPUTE,
    "get_paper_design": VIEW_FILES,
    "get_design": VIEW_FILES,
    "compute_defects": COMPUTE,
    "draw_defects": COMPUTE,
    "get_report": VIEW_FILES,
    "adopt_model": GOVERN,
    "get_characterisation_report": VIEW_FILES,
    "list_models": VIEW_FILES,
    "get_model": VIEW_FILES,
    "retire_model": GOVERN,
}


@cache
def standard_access() -> Mapping[str, Access]:
    """Of the routes that every kind of job has; only what waits for the platform can be edited."""
    found: dict[str, Access] = {}
    for feature in job_features():
        kind = feature.kind
        start = Access(Role.OPERATOR, Takes.COMPUTING, audited=True) if kind.plans_on_a_core else START
        found |= {f"list_{kind.plural.replace('-', '_')}": VIEW, f"get_{kind.name}": VIEW}
        found |= {f"start_{kind.name}": start, f"cancel_{kind.name}": ACT}
        if kind.needs_hardware:
            found[f"edit_{kind.name}"] = start
    return MappingProxyType(found)


def access_of(operation: str) -> Access | None:
    """Who may do what; None: the table does not know the operation."""
    return ACCESS.get(operation) or standard_access().get(operation)


def required_access(operation: str) -> Access:
    """Who may do what.  Raises KeyError if the table does not know the operation."""
    found = access_of(operation)
    if found is None:
        raise KeyError(operation)
    return found
