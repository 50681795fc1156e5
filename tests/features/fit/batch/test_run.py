import math
import os
import signal
from concurrent.futures import Executor, ThreadPoolExecutor

import pytest

from drivers.errors import InputError, PlatformError
from platform_daemon.features.fit.batch import run
from platform_daemon.features.fit.batch.executors import WorkerPool, in_this_process, processes
from platform_daemon.features.fit.batch.run import Advanced, Failed, Finished, fit_files
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest, FitSettings
from platform_daemon.features.fit.measurement import open_measurement
from tests.kit.example_copies import WINDOW_S, copies, same

SETTINGS = FitSettings(window=WINDOW_S)


def ended(paths, workers, settings=SETTINGS):
    return {e.path: e for e in fit_files(paths, settings, workers) if not isinstance(e, Advanced)}


@pytest.mark.long
def test_a_batch_gives_what_single_fits_give_in_any_number_of_processes(tmp_path):
    paths = copies(tmp_path, 3)
    with processes(2, frames_per_part=1) as workers:
        found = ended(paths, workers)
    for path in paths:
        opened = open_measurement(path)
        alone = fit_measurement(opened, FitRequest(opened.variant, WINDOW_S))
        assert same(found[path].report, alone)


def test_a_bad_file_fails_alone_and_says_why(tmp_path):
    paths = copies(tmp_path, 2)
    paths[0].write_bytes(b"no hdf5")
    with in_this_process() as workers:
        found = ended([*paths, tmp_path / "missing.h5"], workers)
    assert isinstance(found[paths[1]], Finished)
    assert isinstance(found[paths[0]].error, InputError)
    assert "missing.h5" in str(found[tmp_path / "missing.h5"].error)


def test_what_a_variant_cannot_hold_fixed_fails_its_files_only(tmp_path):
    jewel, thread = copies(tmp_path, 2)
    with in_this_process() as workers:
        found = ended([jewel, thread], workers, FitSettings(window=WINDOW_S, fixed={"tf_over_i_rad_per_s2": 1190.0}))
    assert isinstance(found[jewel], Finished)
    assert "tf_over_i" in str(found[thread].error)


def test_shares_grow_until_a_file_is_finished(tmp_path):
    (path,) = copies(tmp_path, 1)
    with in_this_process() as workers:
        events = list(fit_files([path], SETTINGS, workers))
    assert [type(e) for e in events] == [Advanced, Finished]
    assert events[0].share == 0.5


def test_no_more_parts_are_in_flight_than_twice_the_workers(tmp_path):
    paths = copies(tmp_path, 6)
    with Watched(1) as pool:
        first = next(iter(fit_files(paths, SETTINGS, WorkerPool(pool, 1, frames_per_part=1))))
    assert isinstance(first, Advanced)
    assert len(pool.submitted) == 2
    assert set(pool.submitted) <= set(paths[:2])


class Watched(ThreadPoolExecutor):
    """Keeps which files' parts it was given."""

    def __init__(self, count):
        super().__init__(count)
        self.submitted = []

    def submit(self, fn, source, *rest):
        self.submitted.append(source.path)
        return super().submit(fn, source, *rest)


def _die_on_jewel(source, settings, first, last):
    """A part whose process is killed when it meets a jewel."""
    if "jewel" in source.path.name:
        os.kill(os.getpid(), signal.SIGKILL)
    return run.fit_part(source, settings, first, last)


class Deadly(Executor):
    """Processes in which a jewel is deadly."""

    def __init__(self, pool):
        self.pool = pool

    def submit(self, fn, *part):
        return self.pool.submit(_die_on_jewel, *part)


@pytest.mark.long
def test_a_process_that_dies_takes_only_the_file_with_it_that_killed_it(tmp_path):
    paths = copies(tmp_path, 4)
    with processes(2) as workers:
        found = ended(paths, WorkerPool(Deadly(workers.executor), workers.count, workers.frames_per_part))
    assert [type(found[p]) for p in paths] == [Failed, Finished, Failed, Finished]
    assert "died" in str(found[paths[0]].error)


def test_an_unexpected_error_is_said_with_the_file(tmp_path, monkeypatch):
    (path,) = copies(tmp_path, 1)
    monkeypatch.setattr(run, "fit_part", lambda *a: 1 / 0)
    with in_this_process() as workers:
        error = ended([path], workers)[path].error
    assert isinstance(error, PlatformError)
    assert "ZeroDivisionError" in str(error)


def test_content_is_sent_where_paths_cannot_be_read(tmp_path):
    (path,) = copies(tmp_path, 1)
    with in_this_process() as here:
        by_path = ended([path], here)[path].report
        by_content = ended([path], WorkerPool(here.executor, 1, frames_per_part=None, send_content=True))[path].report
    assert same(by_content, by_path)


@pytest.mark.parametrize("frames_per_part", [1, 3, None])
def test_derived_quantities_come_with_every_split(tmp_path, frames_per_part):
    (path,) = copies(tmp_path, 1)
    with in_this_process() as here:
        settings = FitSettings(window=WINDOW_S, derived=True)
        report = ended([path], WorkerPool(here.executor, 1, frames_per_part), settings)[path].report
    assert report.derived.orientation_error.frames == (0, 1)
    found = report.frames[1]
    f_nat, damping = (found.values[n] for n in ("f_nat_hz", "lambda_per_s"))
    assert found.derived.quality_factor == pytest.approx(math.pi * f_nat / damping)
