"""Who owns the hardware: jobs, interlock, one shot, calibrations, self-test, procedures of several jobs.

ActivationRequest: kind.
CalibrationFiles: The files that the platform file names.
read_receive: The receive calibration in a calibration file or a recording.
Engine: Runs acquisitions one after the other on one platform, and fits beside them.
UnknownId: No job or recording has that id.
JobRecords: One JSON file per job in `folder`.
Cancelled: Somebody asked the job to stop, and it did at a safe point.
Job: One piece of work.
reduce_latency: Search for garbage once more, now, and from here on only in what is made later.
AcquisitionRequest: A series of shots on one resonator.
Budget: How much may be measured.
Callbacks: How the loop talks.
LiveDiagnosis: One loop on one resonator.
CalibrationRequest: A calibration.
"""

from .calibration_in_use import ActivationRequest, CalibrationFiles, read_receive
from .engine import Engine, UnknownId
from .job_records import JobRecords
from .jobs import Cancelled, Job
from .latency import reduce_latency
from .planning import AcquisitionRequest
from .procedures.diagnose import Budget, Callbacks, LiveDiagnosis
from .work.calibration_bench import CalibrationRequest

__all__ = [
    "AcquisitionRequest",
    "ActivationRequest",
    "Budget",
    "CalibrationFiles",
    "CalibrationRequest",
    "Callbacks",
    "Cancelled",
    "Engine",
    "Job",
    "JobRecords",
    "LiveDiagnosis",
    "UnknownId",
    "read_receive",
    "reduce_latency",
]
