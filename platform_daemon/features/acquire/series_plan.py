"""From a request to the checked work of a series; nothing moves."""

from __future__ import annotations

from types import MappingProxyType

from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.schemas.acquisitions import AcquisitionSummary
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.core.schemas.value_sources import Origins
from platform_daemon.core.service.bench import HardwareBench

from .destination import Destination, OwnFile, SameFile
from .planning import AcquisitionPlan, plan_acquisition
from .work import SeriesBench, SeriesWork


def plan_series(
    engine: Engine,
    request: AcquisitionRequest,
    origins: Origins = MappingProxyType({}),
) -> AcquisitionPlan:
    """The checked plan of a request.  origins: see sourced_sequence.  Raises InputError."""
    return plan_acquisition(request, engine.side, engine.models, engine.catalogue, engine.online, origins)


def series_bench(engine: Engine) -> SeriesBench:
    """What a series is made with now."""
    return SeriesBench(
        platform=engine.platform,
        config_text=engine.config_text,
        fits=engine.fits,
        online=engine.online,
        live=engine.live,
        side=lambda: engine.side,
        in_shot=engine.read_back_in_shot,
        chain_test=engine.calibration_in_use.chain_test,
        tell=engine.tell,
    )


def series_work(
    engine: Engine, plan: AcquisitionPlan, destination: Destination, step: StepLabel | None = None
) -> SeriesWork:
    """The work of a series that is planned.  step: of a procedure, None: it belongs to none.

    Raises DeviceStateError if the transmit side is no longer the planned one.
    """
    return SeriesWork(series_bench(engine), plan, destination, step)


def plan(bench: HardwareBench, request: AcquisitionRequest) -> SeriesWork:
    """The work of a series that writes a recording of its own.  Raises InputError, StorageUnusable, InterlockError."""
    bench.check_named(request)
    found = plan_series(bench.engine, request)
    bench.check_feasible(found.disk_bytes, found.shots_in_all)
    folder = bench.folders.recordings
    destination: Destination = OwnFile(None, folder)
    if bench.resumes and bench.again is not None:
        destination = SameFile(folder / f"{bench.again.identifier}.h5")
    return series_work(bench.engine, found, destination)


def dry_run(bench: HardwareBench, request: AcquisitionRequest) -> AcquisitionSummary:
    """The same checks: what the series would be."""
    return plan(bench, request).summary()
