"""The real daemon on the simulated platform; nothing is mocked."""

from __future__ import annotations

import gc
import math
import os
import signal
import sys
import tempfile
from collections.abc import Callable, Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest
from hypothesis import settings

from platform_daemon.__main__ import SELDOM
from platform_daemon.core.hardware import latency
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.settings import load_platform
from platform_daemon.estimation.numerics.blas_threads import one_thread_for_products
from platform_daemon.processes.assembly import start_engine

pytest_plugins = [f"tests.kit.fixtures.{name}" for name in ("command_line", "network", "processes", "service", "web")]
pytest.register_assert_rewrite("tests.kit")  # what is compared there is shown as in a test

# Collecting makes objects that all stay: looking through them again and again takes a fifth of its time.
gc.disable()

# The same examples every time: a red run must be red again.  `make campaign` draws new ones.
settings.register_profile("repeatable", derandomize=True)
settings.register_profile("campaign")
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

# What tests leave behind of owners that died must not lock the devices of this account.
_STATE = tempfile.TemporaryDirectory()
os.environ["XDG_STATE_HOME"] = _STATE.name

# A container often says that nothing compiled is to be kept.  The tests start hundreds of processes: each of them, and
# each worker of xdist, would compile all sources anew, at 0.3 s a time.
sys.dont_write_bytecode = False
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)

# Every core has a worker of xdist.  Threads of BLAS that wait for one take it from the others meanwhile: the threshold
# of a ramp takes 45 s of a processor with two threads, 10 s with one.
one_thread_for_products()
os.environ["OPENBLAS_NUM_THREADS"] = "1"  # of what the tests start

# A shell that starts the tests in the background has them ignore Ctrl-C, and every process that they start.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
signal.signal(signal.SIGHUP, signal.SIG_DFL)  # `nohup` has them ignore a closed terminal, in the same way

# Real processes, sockets and clocks: beside another program one of them may come late.  What needed its second attempt
# is listed at the end of the run.  Tests of what is never allowed, and of numbers, have one attempt.
_REAL_TIME = (
    "campaigns/*",
    "cli/*",
    "core/command_line/*",
    "core/guard/*",
    "core/hardware/*",
    "core/jobs/*",
    "core/service/*",
    "core/web/*",
    "drivers/*",
    "features/acquire/*",
    "features/alarms/*",
    "features/calibrate/*",
    "features/procedures/*",
    "features/self_test/*",
    "features/schedules/*",
    "features/*command.py",
    "features/*daemon.py",
    "features/*routes.py",
    "features/*work.py",
    "features/diagnose/test_live.py",
    "processes/*",
    "system/*",
)


def pytest_collection_finish() -> None:
    """From here on objects are collected; those of the collection itself live to the end, and are not looked at."""
    gc.freeze()
    gc.set_threshold(*SELDOM)
    gc.enable()
    latency.ALL_EVERY_S = math.inf  # a series would look through them once a minute, for 1.5 s of a processor


# These wait more than they compute.  The first worker begins with them, beside others that compute: at the end, where
# they stand by the alphabet, all workers would wait at once.
_FIRST = ("system/emulated/*", "drivers/*", "processes/*", "client/*")


# Single ones of these take minutes in `make test-long`: each worker begins with some, since the last to begin would run
# alone.
_LONGEST = (
    "testing/*",
    "system/test_*.py",
    "client/test_written_down.py",
    "core/web/test_generated_client.py",
    "features/reproduce/*",
    "campaigns/test_attack_api.py",
)


@cache
def _is_among(path: Path, patterns: tuple[str, ...]) -> bool:
    name = path.relative_to(Path(__file__).parent).as_posix()
    return any(fnmatch(name, each) for each in patterns)


@pytest.hookimpl(trylast=True)  # when the items are those that will run
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """What waits stands first, behind what takes longest; real processes, sockets and clocks have one more attempt."""
    items.sort(key=lambda item: not _is_among(item.path, _FIRST))
    items[:] = _in_shares(items, int(os.environ.get("PYTEST_XDIST_WORKER_COUNT", "1")))
    for item in items:
        if (
            _is_among(item.path, _REAL_TIME)
            and "interlock" not in item.nodeid
            and "campaigns/faults" not in item.nodeid
        ):
            item.add_marker(pytest.mark.flaky(reruns=1))


def _in_shares(items: list[pytest.Item], workers: int) -> list[pytest.Item]:
    """The same for so many workers.  xdist has each begin with its share of the list: at its head are some of the
    longest files."""
    files: dict[Path, list[pytest.Item]] = {}
    rest: list[pytest.Item] = []
    for item in items:
        (files.setdefault(item.path, []) if _is_among(item.path, _LONGEST) else rest).append(item)
    ordered: list[pytest.Item] = []
    for worker in range(workers):
        head = [item for file in list(files.values())[worker::workers] for item in file]
        others = max(0, len(items) * (worker + 1) // workers - len(ordered) - len(head))
        ordered += [*head, *rest[:others]]
        del rest[:others]
    return [*ordered, *rest]


@pytest.fixture(autouse=True)
def environment_stays() -> Iterator[None]:
    """A place of compiled kernels that a test left in the environment once let a later one compile everything anew, for
    a minute in each run.  Libraries may note something there when they are loaded; what we read is as it was."""
    before = _environment()
    yield
    assert _environment() == before, "the environment is not as it was before this test"


def _environment() -> dict[str, str]:
    ours = ("PLATFORM_DAEMON_", "NUMBA_", "MPLCONFIGDIR", "XDG_", "HOME", "TZ", "OPENBLAS_")
    return {name: value for name, value in os.environ.items() if name.startswith(ours)}


@pytest.fixture
def engine_with() -> Iterator[Callable[..., Engine]]:
    """Makes engines on the shipped simulated platform with overrides; closes them all."""
    made: list[Engine] = []

    def make(*overrides: str, jobs: Path | None = None, models: Path | None = None) -> Engine:
        records = JobRecords(None if jobs is None else jobs / "state.sqlite")
        made.append(start_engine(load_platform("simulated", overrides), records, models))
        return made[-1]

    yield make
    for engine in made:
        engine.close()
