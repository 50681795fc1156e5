"""The one table of who may do what.  A route that is not in it is refused when the application is made."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum

from platform_daemon.schemas import Role


class Takes(Enum):
    """What answering takes; how many run at once is bounded for each (`Limits`)."""

    NOTHING = "milliseconds"
    READING = "many files"
    COMPUTING = "a core"
    DOWNLOAD = "a core, and memory until the client has fetched it"


@dataclass(frozen=True)
class Access:
    """What an operation asks for.

    Attributes:
        role: the lowest that may do it; None: no token is needed.
        takes: what answering takes.
        audited: it is written into the audit log.
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
    # Alive, and what answers mean: for probes, and for the page of documentation, which has no token to begin with.
    "get_health": Access(None),
    "get_problem_kind": Access(None),
    # Stopping is always safe: whoever may look may stop.
    "stop": Access(Role.VIEWER, audited=True),
    "reset_amplifier": CONFIRM,
    "reset_fault": ACT,
    "get_entry_points": VIEW,
    "get_readiness": VIEW,
    "get_platform": VIEW,
    "list_devices": VIEW,
    "get_mounted_resonator": VIEW,
    "say_mounted_resonator": ACT,
    "list_resonators": VIEW_FILES,
    "get_resonator": VIEW_FILES,
    "add_resonator": ACT,
    "list_sequences": VIEW_FILES,
    "get_sequence": VIEW_FILES,
    "add_sequence": ACT,
    "list_acquisitions": VIEW,
    "get_acquisition": VIEW,
    "get_shots": VIEW_FILES,
    "edit_acquisition": START,
    "order_queue": ACT,
    "pause_acquisition": CONFIRM,
    "resume_acquisition": CONFIRM,
    "start_acquisition": START,
    "cancel_acquisition": ACT,
    "dry_run": COMPUTE,
    "list_procedures": VIEW,
    "get_procedure": VIEW,
    "start_procedure": Access(Role.OPERATOR, Takes.COMPUTING, audited=True),
    "edit_procedure": Access(Role.OPERATOR, Takes.COMPUTING, audited=True),
    "cancel_procedure": ACT,
    "dry_run_procedure": COMPUTE,
    "pause_procedure": CONFIRM,
    "resume_procedure": CONFIRM,
    "get_procedure_report": VIEW_FILES,
    "list_self_tests": VIEW,
    "get_self_test": VIEW,
    "start_self_test": START,
    "edit_self_test": START,
    "cancel_self_test": ACT,
    "list_calibrations": VIEW,
    "get_calibration": VIEW,
    "start_calibration": START,
    "edit_calibration": START,
    "cancel_calibration": ACT,
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
    "list_fits": VIEW,
    "get_fit": VIEW,
    "start_fit": START,
    "cancel_fit": ACT,
    "get_derived": COMPUTE,
    "get_envelopes": COMPUTE,
    "predict": COMPUTE,
    "get_paper_design": VIEW_FILES,
    "get_design": VIEW_FILES,
    "compute_defects": COMPUTE,
    "draw_defects": COMPUTE,
    "list_diagnoses": VIEW,
    "get_diagnosis": VIEW,
    "start_diagnosis": START,
    "cancel_diagnosis": ACT,
    "get_report": VIEW_FILES,
    "adopt_model": GOVERN,
    "list_characterisations": VIEW,
    "get_characterisation": VIEW,
    "start_characterisation": START,
    "cancel_characterisation": ACT,
    "get_characterisation_report": VIEW_FILES,
    "list_models": VIEW_FILES,
    "get_model": VIEW_FILES,
    "retire_model": GOVERN,
}
