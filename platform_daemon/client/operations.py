"""Which method of the client sends which operation of REST; a test compares it with the OpenAPI schema."""

from __future__ import annotations

from dataclasses import dataclass

from platform_daemon.core.registry import job_features


@dataclass(frozen=True)
class Operation:
    """One operation.

    Attributes:
        method, path: of HTTP; the path with its variables in braces.
        sent_by: method of the client that sends it, as "Client.stop".
        repeatable: sending it twice does what sending it once does, so that it is repeated when an answer is lost.
    """

    method: str
    path: str
    sent_by: str
    repeatable: bool = False


def _get(path: str, sent_by: str) -> Operation:
    return Operation("GET", path, sent_by, repeatable=True)


def _post(path: str, sent_by: str) -> Operation:
    return Operation("POST", path, sent_by)


def _compute(path: str, sent_by: str) -> Operation:
    return Operation("POST", path, sent_by, repeatable=True)


OPERATIONS: dict[str, Operation] = {
    "get_health": _get("/health", "Client.health"),
    "stop": Operation("POST", "/stop", "Client.stop", repeatable=True),
    "get_caller": _get("/caller", "Client.caller"),
    "get_readiness": _get("/ready", "Client.readiness"),
    "get_platform": _get("/platform", "Client.platform"),
    "list_devices": _get("/devices", "Client.devices"),
    "reset_amplifier": _post("/devices/power_amplifier/reset", "Client.reset_amplifier"),
    "reset_fault": _post("/platform/fault/reset", "Client.reset_fault"),
    "order_queue": _post("/platform/queue", "Client.order_queue"),
    "get_mounted_resonator": _get("/platform/resonator", "Client.mounted_resonator"),
    "set_mounted_resonator": _post("/platform/resonator", "Client.mount"),
    "get_problem_kind": _get("/problems/{kind}", "Client.problem_kind"),
    "list_resonators": _get("/resonators", "Resonators.list"),
    "add_resonator": _post("/resonators", "Resonators.add"),
    "get_resonator": _get("/resonators/{name}", "Resonators.get"),
    "get_design": _get("/resonators/{name}/design", "Resonators.design"),
    "list_sequences": _get("/sequences", "Sequences.list"),
    "add_sequence": _post("/sequences", "Sequences.add"),
    "get_sequence": _get("/sequences/{name}", "Sequences.get"),
    "listen": _get("/events", "Client.events"),
    "list_jobs": _get("/jobs", "Client.jobs"),
    "dry_run": _compute("/acquisitions/dry-run", "Client.dry_run"),
    "pause_acquisition": _post("/acquisitions/{identifier}/pause", "Acquisition.pause"),
    "resume_acquisition": _post("/acquisitions/{identifier}/resume", "Acquisition.resume"),
    "get_shots": _get("/acquisitions/{identifier}/shots", "Acquisition.shots"),
    "dry_run_procedure": _compute("/procedures/dry-run", "Client.dry_run_procedure"),
    "pause_procedure": _post("/procedures/{identifier}/pause", "Procedure.pause"),
    "resume_procedure": _post("/procedures/{identifier}/resume", "Procedure.resume"),
    "get_procedure_report": _get("/procedures/{identifier}/report", "Procedure.report"),
    "pause_reproduction": _post("/reproductions/{identifier}/pause", "Reproduction.pause"),
    "resume_reproduction": _post("/reproductions/{identifier}/resume", "Reproduction.resume"),
    "get_reproduction_report": _get("/reproductions/{identifier}/report", "Reproduction.report"),
    "add_schedule": _post("/schedules", "Schedules.add"),
    "list_schedules": _get("/schedules", "Schedules.list"),
    "preview_schedule": _compute("/schedules/preview", "Schedules.preview"),
    "get_schedule": _get("/schedules/{identifier}", "ScheduleHandle.get"),
    "remove_schedule": Operation("DELETE", "/schedules/{identifier}", "ScheduleHandle.remove"),
    "get_ledger": _get("/schedules/{identifier}/ledger", "ScheduleHandle.ledger"),
    "pause_schedule": _post("/schedules/{identifier}/pause", "ScheduleHandle.pause"),
    "resume_schedule": _post("/schedules/{identifier}/resume", "ScheduleHandle.resume"),
    "run_schedule": _post("/schedules/{identifier}/run", "ScheduleHandle.run"),
    "list_changes": _get("/changes", "Client.changes"),
    "list_alarms": _get("/alarms", "Client.alarms"),
    "acknowledge_alarm": _post("/alarms/{name}/acknowledge", "Client.acknowledge"),
    "get_metrics": _get("/metrics", "Client.metrics"),
    "adopt_calibration": _post("/calibrations/adopt", "Client.adopt_calibration"),
    "continue_calibration": _post("/calibrations/{identifier}/continue", "Calibration.proceed"),
    "list_recordings": _get("/recordings", "Recordings.list"),
    "recover_recordings": _post("/recordings/recover", "Recordings.recover"),
    "get_recording": _get("/recordings/{identifier}", "Recording.info"),
    "download_recording": _get("/recordings/{identifier}/file", "Recording.download"),
    "get_dmdt_npy": _get("/recordings/{identifier}/frames/{frame}/dmdt.npy", "Recording.samples"),
    "get_dmdt": _get("/recordings/{identifier}/frames/{frame}/dmdt", "Recording.points"),
    "get_sliding": _get("/recordings/{identifier}/frames/{frame}/sliding", "Recording.sliding"),
    "get_harmonics": _get("/recordings/{identifier}/frames/{frame}/harmonics", "Recording.harmonics"),
    "draw_frame": _get("/recordings/{identifier}/frames/{frame}/picture", "Recording.picture"),
    "get_budget": _get("/recordings/{identifier}/budget", "Recording.budget"),
    "draw_budget": _get("/recordings/{identifier}/budget/picture", "Recording.budget_picture"),
    "read_measurand": _get("/recordings/{identifier}/measurand", "Recording.measurand"),
    "list_measurands": _get("/measurands", "Client.measurands"),
    "get_measurand": _get("/measurands/{name}", "Client.measurand"),
    "calibrate_measurand": _post("/measurands", "Resonators.calibrate"),
    "get_frame_plot": _get("/recordings/{identifier}/frames/{frame}/plot", "Recording.plot_data"),
    "list_specimens": _get("/specimens", "Specimens.list"),
    "get_specimen": _get("/specimens/{specimen}", "SpecimenHandle.get"),
    "get_trend": _get("/specimens/{specimen}/trend", "SpecimenHandle.trend"),
    "get_trend_picture": _get("/specimens/{specimen}/trend/picture", "SpecimenHandle.trend_picture"),
    "get_trend_table": _get("/specimens/{specimen}/trend/table", "SpecimenHandle.trend_table"),
    "accept_specimen": _post("/specimens/{specimen}/baseline", "SpecimenHandle.accept"),
    "get_derived": _get("/fits/{identifier}/derived", "Fit.derived"),
    "get_envelopes": _get("/fits/{identifier}/frames/{frame}/envelopes", "Fit.envelopes"),
    "get_live_harmonics": _get("/live/harmonics", "Client.live_harmonics"),
    "predict": _compute("/predict", "Client.predict"),
    "get_paper_design": _get("/design", "Client.design"),
    "compute_defects": _compute("/defects", "Client.defects"),
    "draw_defects": _compute("/defects/picture", "Client.defects_picture"),
    "get_report": _get("/diagnoses/{identifier}/report", "Diagnosis.report"),
    "adopt_model": _post("/diagnoses/{identifier}/adopt", "Diagnosis.adopt"),
    "get_characterisation_report": _get("/characterisations/{identifier}/report", "Characterisation.report"),
    "list_models": _get("/models", "Models.list"),
    "get_model": _get("/models/{name}", "Models.get"),
    "retire_model": _post("/models/{name}/retire", "Models.retire"),
}
"""The operations by their names in the OpenAPI schema, without the standard ones of every kind of job."""

STARTED_BY = {
    "acquisition": "Client.measure",
    "procedure": "Client.start_procedure",
    "reproduction": "Client.reproduce",
    "calibration": "Client.calibrate",
    "self_test": "Client.self_test",
    "fit": "Client.fit",
    "diagnosis": "Client.diagnose",
    "characterisation": "Client.characterise_recording",
}
"""Which method starts a job of a kind."""

WITHOUT_METHOD = {
    "get_entry_points": "the client knows the paths",
    "get_dmdt_h5": "Recording.samples has the same numbers, Recording.download the file",
    "get_dmdt_extremes": "the page draws it; Recording.points has the same numbers",
}
"""Operations that no method sends, each with the reason."""


def operations() -> dict[str, Operation]:
    """All operations that the client sends, those of every kind of job included."""
    found = dict(OPERATIONS)
    for feature in job_features():
        kind = feature.kind
        name, path = kind.name, f"/{kind.plural}"
        found[f"start_{name}"] = _post(path, STARTED_BY[name])
        found[f"list_{kind.plural.replace('-', '_')}"] = _get(path, "Client.jobs_of")
        found[f"get_{name}"] = _get(f"{path}/{{identifier}}", "Job.refresh")
        found[f"cancel_{name}"] = Operation("DELETE", f"{path}/{{identifier}}", "Job.cancel", repeatable=True)
        if kind.needs_hardware:
            found[f"edit_{name}"] = Operation("PUT", f"{path}/{{identifier}}", "QueuedJob.edit")
    return found
