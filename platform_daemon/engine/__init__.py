"""Who owns the hardware: jobs, interlock, one shot, calibrations, self-test, procedures of several jobs.

ANALYSES: Kinds of jobs that leave the hardware alone.
AnalysisJobs: Fits, diagnoses and characterisations of what is stored, as jobs.
CalibrationFiles: The files that the platform file names.
read_receive: The receive calibration in a calibration file or a recording.
Catalogue: What can be measured, and how.
Shelf: TOML files of one kind.
TunedPresets: Sequences that tune has found.
open_catalogue: The catalogue of a daemon.
Tell: Takes events.
quiet: Nobody listens.
AcquisitionPlan: The checked plan of a series.
Engine: Runs acquisitions one after the other on one platform, and fits beside them.
ShuttingDown: The daemon takes no work any more.
WaitsNoMore: A job of an earlier run has ended while it was planned.
Asked: How it came to be asked for a job.
UnknownId: No job or recording has that id.
JobRecords: One JSON file per job in `folder`.
record_of: What is kept of a job, as it is now.
DAEMON_ENDED: The warning of a job that no person has cancelled.
AnyJob: A job of whatever kind.
Job: One piece of work.
Work: What a job does.
put_in_order: Jobs that wait, in another order.
edit_waiting: Another work for a job that has not begun.
series_work: The work of a series that writes a file of its own.
resume_series: The missing shots of a series that was cut off.
reduce_latency: Search for garbage once more, now, and from here on only in what is made later.
Budget: How much may be measured.
Callbacks: How the loop talks.
LiveDiagnosis: One loop on one resonator.
NotTuned: No frequency could be trusted within the shots that tune may make.
ProcedureFiles: Where a procedure writes.
ProcedureWork: The work of one procedure, every known step of it checked.
plan_procedure: The work of a procedure for `Engine.submit`, every known step checked.
CharacterisationFiles: Where report and page of a characterisation are kept.
CharacterisationWork: Makes the tables of a recording.
DiagnosisWork: Says what the declared model lacks in these frames of files.
DiagnosisTask: What a diagnosis computes.
FitTask: What a fit computes.
FitWork: Fits some frames of a file.
AcquisitionJob: The job of a series of shots.
queue_self_test: A self-test behind what waits for the platform.
plan_self_test: The checked work of a self-test.
plan_calibration: The checked work of a calibration.
check_model: Is there such a model, are there such terms?
"""

from .analysis_jobs import AnalysisJobs
from .asked import Asked, ShuttingDown, WaitsNoMore
from .calibration_in_use import CalibrationFiles, read_receive
from .catalogue import Catalogue, Shelf, open_catalogue
from .engine import Engine
from .happenings import Tell, quiet
from .job_records import JobRecords, record_of
from .job_registry import ANALYSES, UnknownId
from .jobs import DAEMON_ENDED, AnyJob, Job, Work
from .latency import reduce_latency
from .plan_checks import check_model, plan_calibration
from .planning import AcquisitionPlan
from .procedures.conductor import ProcedureFiles, ProcedureWork
from .procedures.diagnose import Budget, Callbacks, LiveDiagnosis
from .procedures.planned import plan_procedure
from .procedures.tune import NotTuned
from .queue_edits import edit_waiting, put_in_order, resume_series, series_work
from .queued_self_test import plan_self_test, queue_self_test
from .tuned_presets import TunedPresets
from .work.characterisation import CharacterisationFiles, CharacterisationWork
from .work.diagnosis import DiagnosisTask, DiagnosisWork
from .work.fit import FitTask, FitWork
from .work.series import AcquisitionJob

__all__ = [
    "ANALYSES",
    "DAEMON_ENDED",
    "AcquisitionJob",
    "AcquisitionPlan",
    "AnalysisJobs",
    "AnyJob",
    "Asked",
    "Budget",
    "CalibrationFiles",
    "Callbacks",
    "Catalogue",
    "CharacterisationFiles",
    "CharacterisationWork",
    "DiagnosisTask",
    "DiagnosisWork",
    "Engine",
    "FitTask",
    "FitWork",
    "Job",
    "JobRecords",
    "LiveDiagnosis",
    "NotTuned",
    "ProcedureFiles",
    "ProcedureWork",
    "Shelf",
    "ShuttingDown",
    "Tell",
    "TunedPresets",
    "UnknownId",
    "WaitsNoMore",
    "Work",
    "check_model",
    "edit_waiting",
    "open_catalogue",
    "plan_calibration",
    "plan_procedure",
    "plan_self_test",
    "put_in_order",
    "queue_self_test",
    "quiet",
    "read_receive",
    "record_of",
    "reduce_latency",
    "resume_series",
    "series_work",
]
