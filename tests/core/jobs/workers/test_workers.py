"""Computing elsewhere: the same results and errors as here, within bounds, and stopped at once."""

import os
import subprocess
import sys
import threading
import time
from pathlib import Path

import pytest

from drivers.clock import SystemClock
from drivers.errors import DeviceFault, InputError
from drivers.realtime import set_realtime_priority
from platform_daemon.core.jobs.workers.bounds import Bounds, OverBounds, TaskCancelled, WorkerLost
from platform_daemon.core.jobs.workers.deadline import check_deadline, deadline
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.jobs.workers.process import WorkerProcess
from platform_daemon.core.jobs.workers.process_pool import ProcessPool
from platform_daemon.core.jobs.workers.task_executor import Call, InProcessExecutor, ignore_progress
from tests.kit import tasks
from tests.kit.command_line import wait_for


def run(executor, task, progress=ignore_progress, cancel=None, kind="preview"):
    return executor.run(kind, task, progress, cancel or threading.Event())


@pytest.fixture(scope="module")
def worker():
    made = WorkerProcess("tests", WorkerLimits().changed(["preview:2000MB", "preview:30s", "fit:1s"]), 3)
    yield made
    made.close()


@pytest.fixture(params=["here", "there"])
def executor(request, worker):
    return InProcessExecutor() if request.param == "here" else worker


def test_what_a_task_brings_and_says_is_the_same_here_and_there(executor):
    told = []
    assert run(executor, tasks.Sum((1, 2, 3)), lambda done, what: told.append((done, what))) == 6
    assert told == [(1, "adding"), (2, "adding"), (3, "adding")]


def test_an_error_is_the_same_here_and_there(executor):
    with pytest.raises(DeviceFault, match=r"here: stumbled.*Remedy: lift your feet") as caught:
        run(executor, Call(tasks.fails))
    assert caught.value.why == "there was a stone"


def test_a_task_that_is_told_to_stop_does(executor):
    stop = threading.Event()
    with pytest.raises(TaskCancelled):
        run(executor, tasks.Sum(tuple(range(10**7))), lambda done, what: stop.set(), stop)
    assert run(executor, tasks.Sum((4,))) == 4


def test_it_is_another_process_that_steps_back(worker):
    assert run(worker, Call(tasks.pid)) == worker.pid != os.getpid()
    assert run(worker, Call(tasks.nice)) == os.nice(0) + 3


def test_stopped_in_the_midst_of_a_step_it_is_killed_at_once(worker):
    run(worker, Call(tasks.pid))
    before, stop = worker.pid, threading.Event()
    threading.Timer(0.2, stop.set).start()
    began = time.monotonic()
    with pytest.raises(TaskCancelled):
        run(worker, Call(tasks.sleeps, (60,)), cancel=stop)
    assert time.monotonic() - began < 5
    wait_for(lambda: not Path(f"/proc/{before}").exists())
    assert run(worker, Call(tasks.pid)) != before


def test_over_its_time_it_is_stopped_and_told_with_the_option_that_changes_it(worker):
    run(worker, Call(tasks.pid))
    with pytest.raises(OverBounds, match=r"longer than 1 s.*--worker-limit fit:"):
        run(worker, Call(tasks.sleeps, (60,)), kind="fit")
    assert run(worker, tasks.Sum((5,))) == 5


def test_over_its_memory_it_is_told_and_the_next_task_has_a_new_process(worker):
    run(worker, Call(tasks.pid))
    before = worker.pid
    with pytest.raises(OverBounds, match=r"more than 2000 MB.*--worker-limit preview:"):
        run(worker, Call(tasks.holds, (3000,)))
    assert run(worker, Call(tasks.pid)) != before


LIMITED = """
import os, resource, threading
from platform_daemon.core.jobs.workers.limits import WorkerLimits
from platform_daemon.core.jobs.workers.process import WorkerProcess
from platform_daemon.core.jobs.workers.task_executor import Call
from tests.kit import tasks
resource.setrlimit(resource.RLIMIT_AS, (3_000_000_000, 3_000_000_000))
worker = WorkerProcess("tests", WorkerLimits(), 0)
for task in (Call(os.getppid), Call(tasks.holds, (4000,))):
    try:
        print(worker.run("fit", task, print, threading.Event()) == os.getpid())
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
    run(worker, Call(tasks.pid))
    before = worker.pid
    assert run(worker, Call(tasks.holds, (10,))) == 10_000_000
    assert worker.pid == before
    assert run(worker, Call(tasks.keeps, (700,))) == 700_000_000
    assert run(worker, Call(tasks.pid)) != before


def test_a_process_that_dies_is_an_error_and_the_next_task_has_another(worker):
    with pytest.raises(WorkerLost, match="signal 9"):
        run(worker, Call(tasks.dies))
    assert run(worker, tasks.Sum((6,))) == 6


@pytest.mark.parametrize("task", [Call(tasks.breaks), Call(tasks.cannot_be_sent)])
def test_an_error_that_nobody_foresaw_is_told_with_its_words(worker, task):
    with pytest.raises(RuntimeError, match=r"KeyError|[Pp]ickl"):
        run(worker, task)
    assert run(worker, tasks.Sum((7,))) == 7


def test_two_that_ask_one_worker_wait_for_each_other(worker):
    run(worker, Call(tasks.pid))
    slow = threading.Thread(target=run, args=(worker, Call(tasks.sleeps, (0.5,))))
    slow.start()
    time.sleep(0.1)
    began = time.monotonic()
    assert run(worker, tasks.Sum((8,))) == 8
    assert time.monotonic() - began > 0.2
    slow.join()


def test_a_closed_worker_leaves_no_process():
    made = WorkerProcess("closed", WorkerLimits(), 0)
    run(made, Call(tasks.pid))
    pid = made.pid
    made.close()
    wait_for(lambda: not Path(f"/proc/{pid}").exists())


def test_a_worker_dies_with_the_process_that_started_it():
    code = (
        "import os, signal, threading\n"
        "from platform_daemon.core.jobs.workers.limits import WorkerLimits\n"
        "from platform_daemon.core.jobs.workers.process import WorkerProcess\n"
        "from platform_daemon.core.jobs.workers.task_executor import Call\n"
        "from tests.kit import tasks\n"
        "if __name__ == '__main__':\n"
        "    w = WorkerProcess('w', WorkerLimits(), 0)\n"
        "    ask = lambda task: w.run('preview', task, lambda d, t: None, threading.Event())\n"
        "    ask(Call(tasks.pid)); print(w.pid, flush=True)\n"
        "    threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGKILL)).start()\n"
        "    ask(Call(tasks.sleeps, (60,)))\n"
    )
    done = subprocess.run([sys.executable, "-c", code], check=False, capture_output=True, text=True, timeout=60)
    pid = int(done.stdout.split()[0])
    wait_for(lambda: not Path(f"/proc/{pid}").exists(), 10)


def test_a_pool_shares_its_tasks_and_one_that_waits_can_be_cancelled():
    pool = ProcessPool("p", 2, WorkerLimits(), nice=0)
    try:
        stop, leave = threading.Event(), threading.Event()
        threads = [
            threading.Thread(target=_until_stopped, args=(pool, Call(tasks.sleeps, (60,)), stop)) for _ in range(2)
        ]
        for each in threads:
            each.start()
        time.sleep(0.3)
        threading.Timer(0.3, leave.set).start()
        began = time.monotonic()
        with pytest.raises(TaskCancelled):
            run(pool, Call(tasks.pid), cancel=leave)
        assert 0.2 < time.monotonic() - began < 5
        stop.set()
        for each in threads:
            each.join()
        assert run(pool, tasks.Sum((9,))) == 9
    finally:
        pool.close()


def test_the_process_that_a_pool_used_last_gets_the_next_task():
    pool = ProcessPool("p", 3, WorkerLimits(), nice=0)
    try:
        assert len({run(pool, Call(tasks.pid)) for _ in range(3)}) == 1
    finally:
        pool.close()


def _until_stopped(pool, task, stop):
    with pytest.raises(TaskCancelled):
        run(pool, task, cancel=stop)


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
        set_realtime_priority(SystemClock())
        executor = WorkerProcess("ordinary", WorkerLimits(), 0)
        found.append((os.sched_getscheduler(0), run(executor, Call(os.sched_getscheduler, (0,)))))
        executor.close()

    thread = threading.Thread(target=start)
    thread.start()
    thread.join()
    assert found[0][1] == os.SCHED_OTHER


def test_work_of_this_process_looks_at_the_clock_itself_and_the_nearer_limit_holds():
    check_deadline()  # nobody set a limit
    long, short = Bounds(4000, 60.0), Bounds(4000, 0.0)
    with deadline("planning", long):
        check_deadline()
        with deadline("fit", short), pytest.raises(OverBounds, match="the fit took longer than 0 s") as over:
            _later()
        assert "--worker-limit fit:SECONDSs" in over.value.remedy
        check_deadline()
    with (
        deadline("planning", short),
        deadline("fit", long),
        pytest.raises(OverBounds, match="the planning took longer"),
    ):
        _later()
    check_deadline()


def _later():
    time.sleep(0.001)
    check_deadline()
