"""A program on the emulated wires dies in a shot: its outputs go off, and power never meets the receiver."""

from __future__ import annotations

import os
import pkgutil
import signal
import subprocess
import sys
import time

import pytest

from drivers.clock import SystemClock
from drivers.errors import InterlockError
from drivers.power_guard import NoGuard
from drivers.realtime import set_realtime_priority
from platform_daemon.core import guard as guards
from platform_daemon.core.guard import guard_client
from platform_daemon.core.guard.fault_latch import Cause
from platform_daemon.core.guard.guard_client import GuardClient, guard_for
from platform_daemon.core.guard.ownership import owner_of
from platform_daemon.core.guard.state_dir import state_dir_of
from platform_daemon.core.guard.watch import LEASE_S
from platform_daemon.core.settings import load_platform
from tests.kit.dying_host import DyingHost
from tests.kit.emulated_lab import Lab
from tests.kit.threads import in_a_thread

DEATHS = [
    (signal.SIGKILL, "tx", 5.0),
    pytest.param(signal.SIGKILL, "rx", 5.0, marks=pytest.mark.long),
    pytest.param(signal.SIGSEGV, "tx", 5.0, marks=pytest.mark.long),
    (signal.SIGHUP, "rx", 5.0),
    pytest.param(signal.SIGSTOP, "tx", LEASE_S + 5.0, marks=pytest.mark.long),
]


def wait_for(true, within_s: float = 10.0) -> None:
    until = time.monotonic() + within_s
    while not true():
        assert time.monotonic() < until
        time.sleep(0.02)


@pytest.fixture(scope="module")
def lab(tmp_path_factory):
    made = Lab(tmp_path_factory.mktemp("lab"))
    yield made
    made.emulator.close()


@pytest.mark.parametrize(("number", "moment", "within_s"), DEATHS)
def test_outputs_go_off_however_the_owner_dies(lab, tmp_path, number, moment, within_s):
    host = DyingHost(lab, tmp_path)
    try:
        host.wait_for(moment)
        host.send(number)
        _, all_s = host.off_after(within_s)
        if number == signal.SIGHUP:
            assert host.process.wait(30) == 130
    finally:
        host.end()
    if number == signal.SIGSTOP:
        assert all_s > LEASE_S - 1.0
        assert "owner_hangs" in host.log.read_text()
    assert lab.violations() == ()
    wait_for(lambda: owner_of(state_dir_of(lab.file().section)) is None)
    fault = lab.reset_fault()
    if number == signal.SIGHUP:
        assert fault is None  # it ended in order
    else:
        assert fault is not None
        assert (fault.owner, fault.proved) == (host.process.pid, True)
        assert fault.cause is (Cause.HUNG if number == signal.SIGSTOP else Cause.DIED)


@pytest.fixture
def guard(lab):
    made = guard_for(lab.file().section)
    assert isinstance(made, GuardClient)
    yield made
    made.close()


def test_a_guard_that_died_is_replaced_before_the_next_power_and_told_in_the_shot(guard):
    guard.power_may_come()
    first = guard.pid
    os.kill(first, signal.SIGKILL)
    time.sleep(0.2)
    with pytest.raises(InterlockError, match="guard process has died"):
        guard.alive()
    guard.power_may_come()
    assert guard.pid != first
    guard.alive()
    guard.power_is_off()


def test_a_guard_goes_before_other_programs_where_it_may(guard):
    why_not = in_a_thread(lambda: set_realtime_priority(SystemClock()))
    wait_for(lambda: os.sched_getscheduler(guard.pid) == (os.SCHED_RR if why_not is None else os.SCHED_OTHER))


def test_a_guard_that_is_halted_is_replaced_before_the_next_power_and_owns_nothing_afterwards(lab, guard, monkeypatch):
    monkeypatch.setattr(guard_client, "_ANSWER_TIMEOUT_S", 0.5)
    monkeypatch.setattr(guard_client, "_END_TIMEOUT_S", 0.2)
    guard.power_may_come()
    guard.power_is_off()
    first = guard.pid
    os.kill(first, signal.SIGSTOP)
    guard.power_may_come()
    assert guard.pid != first
    guard.power_is_off()
    assert not os.path.exists(f"/proc/{first}")
    os.kill(guard.pid, signal.SIGSTOP)
    guard.close()
    guard_for(lab.file().section).close()


def test_a_guard_ends_when_the_devices_have_been_let_go(lab):
    guard = guard_for(lab.file().section)
    guard.power_may_come()
    guard.power_is_off()
    pid = guard.pid
    guard.close()
    assert not os.path.exists(f"/proc/{pid}")


def test_a_guard_ends_with_its_owner_and_ignores_what_a_terminal_sends(lab, tmp_path):
    program = (
        "import os, signal, sys; from platform_daemon.core.guard.guard_client import GuardClient\n"
        "from platform_daemon.core.settings import load_platform; from pathlib import Path\n"
        "guard = GuardClient(load_platform('emulated', (), Path(sys.argv[1])).section)\n"
        "guard.power_may_come(); guard.power_is_off()\n"
        "for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP): os.kill(guard.pid, number)\n"
        "guard.power_may_come(); guard.power_is_off(); print(guard.pid)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", program, str(lab.endpoints)], capture_output=True, text=True, check=True, timeout=60
    )
    until = time.monotonic() + 5.0
    while os.path.exists(f"/proc/{int(done.stdout)}") and time.monotonic() < until:
        time.sleep(0.02)
    assert not os.path.exists(f"/proc/{int(done.stdout)}")


def test_simulated_devices_need_no_guard():
    assert isinstance(guard_for(load_platform("simulated").section), NoGuard)


def test_the_guard_needs_no_web_no_kernels_and_no_pictures():
    heavy = "{'numba', 'matplotlib', 'fastapi', 'scipy.optimize', 'h5py'}"
    modules = ", ".join(
        f"{guards.__name__}.{m.name}" for m in pkgutil.iter_modules(guards.__path__) if m.name != "__main__"
    )
    program = f"import sys, {modules}, drivers.outputs_off; print(sorted({heavy} & set(sys.modules)))"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
