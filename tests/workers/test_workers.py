"""Computing elsewhere: the same results and errors as here, within bounds, and stopped at once."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from drivers.clock import SystemClock
from drivers.errors import DeviceFault, InputError, PlatformError
from drivers.urgency import be_urgent
from platform_daemon.workers import (
    Call,
    InThisProcess,
    OverBounds,
    Pool,
    Stopped,
    WorkerLimits,
    WorkerLost,
    WorkerProcess,
    check_time,
    in_time,
)
from platform_daemon.workers.bounds import Bounds
from tests.kit import tasks
from tests.kit.command_line import wait_for


def silent(done, what):
    pass


def computed(computer, task, tell=silent, stop=None, kind="preview"):
    return computer.compute(kind, task, tell, stop or threading.Event())


@pytest.fixture(scope="module")
def worker():
    made = WorkerProcess("tests", WorkerLimits().changed(["preview:2000MB", "preview:30s", "fit:1s"]), 3)
    yield made
    made.close()


@pytest.fixture(params=["here", "there"])
def computer(request, worker):
    return InThisProcess() if request.param == "here" else worker


def test_what_a_task_brings_and_says_is_the_same_here_and_there(computer):
    told = []
    assert computed(computer, tasks.Sum((1, 2, 3)), lambda done, what: told.append((done, what))) == 6
    assert told == [(1, "adding"), (2, "adding"), (3, "adding")]


def test_an_error_is_the_same_here_and_there(computer):
    with pytest.raises(DeviceFault, match=r"here: stumbled.*Remedy: lift your feet") as caught:
        computed(computer, Call(tasks.fails))
    assert caught.value.why == "there was a stone"


def test_a_task_that_is_told_to_stop_does(computer):
    stop = threading.Event()
    with pytest.raises(Stopped):
        computed(computer, tasks.Sum(tuple(range(10**7))), lambda done, what: stop.set(), stop)
    assert computed(computer, tasks.Sum((4,))) == 4


def test_it_is_another_process_that_steps_back(worker):
    assert computed(worker, Call(tasks.pid)) == worker.pid != os.getpid()
    assert computed(worker, Call(tasks.nice)) == os.nice(0) + 3


def test_stopped_in_the_midst_of_a_step_it_is_killed_at_once(worker):
    computed(worker, Call(tasks.pid))
    before, stop = worker.pid, threading.Event()
    threading.Timer(0.2, stop.set).start()
    began = time.monotonic()
    with pytest.raises(Stopped):
        computed(worker, Call(tasks.sleeps, (60,)), stop=stop)
    assert time.monotonic() - began < 5
    wait_for(lambda: not Path(f"/proc/{before}").exists())
    assert computed(worker, Call(tasks.pid)) != before


def test_over_its_time_it_is_stopped_and_told_with_the_option_that_changes_it(worker):
    computed(worker, Call(tasks.pid))
    with pytest.raises(OverBounds, match=r"longer than 1 s.*--worker-limit fit:"):
        computed(worker, Call(tasks.sleeps, (60,)), kind="fit")
    assert computed(worker, tasks.Sum((5,))) == 5


def test_over_its_memory_it_is_told_and_the_next_task_has_a_new_process(worker):
    computed(worker, Call(tasks.pid))
    before = worker.pid
    with pytest.raises(OverBounds, match=r"more than 2000 MB.*--worker-limit preview:"):
        computed(worker, Call(tasks.holds, (3000,)))
    assert computed(worker, Call(tasks.pid)) != before


LIMITED = """
import os, resource, threading
from platform_daemon.workers import Call, WorkerLimits, WorkerProcess
from tests.kit import tasks
resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000))
worker = WorkerProcess("tests", WorkerLimits(), 0)
for task in (Call(os.getppid), Call(tasks.holds, (4000,))):
    try:
        print(worker.compute("fit", task, print, threading.Event()) == os.getpid())
    except Exception as error:
        print(error)
worker.close()
"""


def test_where_this_process_may_have_less_that_is_the_limit():
    done = subprocess.run([sys.executable, "-c", LIMITED], capture_output=True, text=True, timeout=60, check=True)
    first, second = done.stdout.splitlines()
    assert first == "True"
    assert "more than 3000 MB" in second


def test_what_it_took_it_gives_back(worker):
    computed(worker, Call(tasks.pid))
    before = worker.pid
    assert computed(worker, Call(tasks.holds, (10,))) == 10_000_000
    assert worker.pid == before
    assert computed(worker, Call(tasks.keeps, (700,))) == 700_000_000
    assert computed(worker, Call(tasks.pid)) != before


def test_a_process_that_dies_is_an_error_and_the_next_task_has_another(worker):
    with pytest.raises(WorkerLost, match="signal 9"):
        computed(worker, Call(tasks.dies))
    assert computed(worker, tasks.Sum((6,))) == 6


@pytest.mark.parametrize("task", [Call(tasks.breaks), Call(tasks.cannot_be_sent)])
def test_an_error_that_nobody_foresaw_is_told_with_its_words(worker, task):
    with pytest.raises(RuntimeError, match=r"KeyError|[Pp]ickl"):
        computed(worker, task)
    assert computed(worker, tasks.Sum((7,))) == 7


def test_two_that_ask_one_worker_wait_for_each_other(worker):
    computed(worker, Call(tasks.pid))
    slow = threading.Thread(target=computed, args=(worker, Call(tasks.sleeps, (0.5,))))
    slow.start()
    time.sleep(0.1)
    began = time.monotonic()
    assert computed(worker, tasks.Sum((8,))) == 8
    assert time.monotonic() - began > 0.2
    slow.join()


def test_a_closed_worker_leaves_no_process():
    made = WorkerProcess("closed", WorkerLimits(), 0)
    computed(made, Call(tasks.pid))
    pid = made.pid
    made.close()
    wait_for(lambda: not Path(f"/proc/{pid}").exists())


def test_a_worker_dies_with_the_process_that_started_it():
    code = (
        "import os, signal, threading\n"
        "from platform_daemon.workers import Call, WorkerLimits, WorkerProcess\n"
        "from tests.kit import tasks\n"
        "if __name__ == '__main__':\n"
        "    w = WorkerProcess('w', WorkerLimits(), 0)\n"
        "    ask = lambda task: w.compute('preview', task, lambda d, t: None, threading.Event())\n"
        "    ask(Call(tasks.pid)); print(w.pid, flush=True)\n"
        "    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGKILL)).start()\n"
        "    ask(Call(tasks.sleeps, (60,)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=60)
    pid = int(done.stdout.split()[0])
    wait_for(lambda: not Path(f"/proc/{pid}").exists(), 10)


class TooMany(PlatformError):
    """For the test."""


def test_a_pool_shares_its_work_and_turns_away_who_waits_too_long():
    pool = Pool([WorkerProcess(f"p{k}", WorkerLimits(), 0) for k in range(2)], 0.3, lambda: TooMany("busy"))
    try:
        stop = threading.Event()
        threads = [
            threading.Thread(target=_until_stopped, args=(pool, Call(tasks.sleeps, (60,)), stop)) for _ in range(2)
        ]
        for each in threads:
            each.start()
        time.sleep(0.3)
        with pytest.raises(TooMany):
            computed(pool, Call(tasks.pid))
        stop.set()
        for each in threads:
            each.join()
        assert computed(pool, tasks.Sum((9,))) == 9
    finally:
        pool.close()


def _until_stopped(pool, task, stop):
    with pytest.raises(Stopped):
        computed(pool, task, stop=stop)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("fit", "KIND:NUMBERMB"),
        ("fit:8GB", "KIND:NUMBERMB"),
        ("dream:8000MB", "diagnosis"),
        ("fit:10MB", "libraries alone"),
        ("fit:0s", "no time"),
        ("fit:-1s", "KIND"),
    ],
)
def test_a_limit_that_is_none_is_refused_with_how_to_say_it(text, words):
    with pytest.raises(InputError, match=words):
        WorkerLimits().changed([text])


def test_limits_are_changed_one_by_one():
    changed = WorkerLimits().changed(["fit:9000MB", "diagnosis:30s"])
    assert (changed.of("fit").memory_mb, changed.of("fit").time_s) == (9000, WorkerLimits().of("fit").time_s)
    assert (changed.of("diagnosis").memory_mb, changed.of("diagnosis").time_s) == (
        WorkerLimits().of("diagnosis").memory_mb,
        30,
    )


def test_a_worker_that_the_thread_of_the_shots_starts_stands_in_line_with_all_others():
    found = []

    def start():
        be_urgent(SystemClock())
        computer = WorkerProcess("ordinary", WorkerLimits(), 0)
        found.append((os.sched_getscheduler(0), computed(computer, Call(os.sched_getscheduler, (0,)))))
        computer.close()

    thread = threading.Thread(target=start)
    thread.start()
    thread.join()
    assert found[0][1] == os.SCHED_OTHER


def test_work_of_this_process_looks_at_the_clock_itself_and_the_nearer_limit_holds():
    check_time()  # nobody set a limit
    long, short = Bounds(4000, 60.0), Bounds(4000, 0.0)
    with in_time("planning", long):
        check_time()
        with in_time("fit", short), pytest.raises(OverBounds, match="the fit took longer than 0 s") as over:
            _later()
        assert "--worker-limit fit:SECONDSs" in over.value.remedy
        check_time()
    with in_time("planning", short), in_time("fit", long), pytest.raises(OverBounds, match="the planning took longer"):
        _later()
    check_time()


def _later():
    time.sleep(0.001)
    check_time()
