"""A real scheduler and two workers, each a process of its own."""

import os
import subprocess
import sys
from contextlib import ExitStack, contextmanager

import pytest

from drivers.errors import InputError, PlatformError
from platform_daemon.features.fit.batch.executors import in_this_process
from platform_daemon.features.fit.batch.run import Advanced, fit_files
from platform_daemon.features.fit.fit_request import FitSettings
from tests.kit.example_copies import WINDOW_S, copies, same

pytest.importorskip("distributed", reason="the optional extra dask is not installed")
from platform_daemon.features.fit.batch.dask_cluster import dask_cluster

SETTINGS = FitSettings(window=WINDOW_S)
ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


@contextmanager
def started(*arguments, cwd, says):
    """A Dask process; yields it with the first line of its log that says so."""
    command = [sys.executable, "-m", "dask", *map(str, arguments)]
    process = subprocess.Popen(
        command, stderr=subprocess.PIPE, text=True, cwd=cwd, env=os.environ | ONE_THREAD, bufsize=1
    )
    try:
        yield process, next(line for line in process.stderr if says in line)
    finally:
        process.kill()
        process.wait()
        process.stderr.close()


@contextmanager
def cluster(folder, workers=2):
    """Address of a scheduler, and its workers' processes."""
    with ExitStack() as stack:
        options = ("--host", "127.0.0.1", "--port", "0", "--no-dashboard")
        _, line = stack.enter_context(started("scheduler", *options, cwd=folder, says="Scheduler at:"))
        address = line.split()[-1]
        options = ("--no-nanny", "--nthreads", "1", "--no-dashboard", "--local-directory", folder)
        yield (
            address,
            [
                stack.enter_context(started("worker", address, *options, cwd=folder, says="Registered to:"))[0]
                for _ in range(workers)
            ],
        )


@pytest.mark.long
def test_a_cluster_gives_what_one_machine_gives_though_a_worker_is_killed_on_the_way(tmp_path):
    paths = copies(tmp_path, 8)
    with cluster(tmp_path) as (address, workers), dask_cluster(address, paths[0]) as reached:
        assert reached.count == 2
        assert not reached.send_content
        found = {}
        for event in fit_files(paths, SETTINGS, reached):
            found[event.path] = event
            if len(found) == 1:
                workers[0].kill()
    with in_this_process() as here:
        alone = [e for e in fit_files(paths[:2], SETTINGS, here) if not isinstance(e, Advanced)]
    for k, path in enumerate(paths):
        assert same(found[path].report.frames, alone[k % 2].report.frames)


@pytest.mark.long
def test_content_is_sent_to_workers_that_cannot_read_our_paths(tmp_path, monkeypatch):
    paths = copies(tmp_path, 2)
    from platform_daemon.features.fit.batch import dask_cluster as module

    monkeypatch.setattr(module, "_all_read", lambda client, path: False)
    with cluster(tmp_path, workers=1) as (address, _), dask_cluster(address, paths[0]) as reached:
        assert reached.send_content
        found = [e.report for e in fit_files(paths, SETTINGS, reached)]
    assert sorted(r.file for r in found) == [str(p) for p in paths]
    assert all(r.summary["m_r_am2"].mean > 0 for r in found)


def test_a_cluster_without_workers_is_said(tmp_path):
    with cluster(tmp_path, workers=0) as (address, _), pytest.raises(InputError, match="no workers"):
        dask_cluster(address, tmp_path).__enter__()


def test_workers_with_another_version_are_refused_by_name(tmp_path, monkeypatch):
    from platform_daemon.features.fit.batch import dask_cluster as module

    monkeypatch.setattr(module, "__version__", "99.0")
    with cluster(tmp_path, workers=1) as (address, _), pytest.raises(InputError, match=r"tcp:.*has version"):
        dask_cluster(address, tmp_path).__enter__()


def test_an_address_where_nobody_answers_is_said_with_the_remedy(tmp_path, monkeypatch):
    from platform_daemon.features.fit.batch import dask_cluster as module

    monkeypatch.setattr(module, "_CONNECT_S", 0.5)
    with pytest.raises(PlatformError, match=r"no scheduler answers.*dask scheduler"):
        dask_cluster("tcp://127.0.0.1:9", tmp_path).__enter__()
    with pytest.raises(InputError, match="no address"):
        dask_cluster("nonsense://x", tmp_path).__enter__()


def test_without_the_extra_the_remedy_is_its_installation(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(InputError, match=r"platform-daemon\[dask\]"):
        dask_cluster("tcp://127.0.0.1:9", tmp_path).__enter__()
