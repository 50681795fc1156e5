"""The durable lock, and who owns the devices: files, and processes that die."""

from __future__ import annotations

import os
import subprocess
import sys
import time

import pytest

from drivers.errors import ConfigError, DeviceDenied, InputError, InterlockError
from platform_daemon.settings import load_platform
from platform_daemon.supervisor import guard_for, owner_of, place_of
from platform_daemon.supervisor.lock_file import FAULTED, HISTORY, Cause, Fault, Reset, clear, lock, refuse, standing
from platform_daemon.supervisor.ownership import take

FAULT = Fault(platform="lab", when="2026-11-23T02:00:00+00:00", owner=7, cause=Cause.DIED, proved=True)
OWNER = (
    "import sys, time; from pathlib import Path; from platform_daemon.supervisor.ownership import take\n"
    "held = take(Path(sys.argv[1]), 'lab', Path('data')); held.power(may_be_on=sys.argv[2] == 'on')\n"
    "print('held', flush=True); time.sleep(60)\n"
)


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def lab(*overrides):
    return load_platform("lab", overrides)


def start_owner(place, power):
    process = subprocess.Popen([sys.executable, "-c", OWNER, str(place), power], stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"held\n"
    return process


def test_a_fault_stands_until_a_named_person_resets_it_and_who_did_is_kept(tmp_path):
    assert standing(tmp_path) is None
    refuse(tmp_path)
    lock(tmp_path, FAULT)
    with pytest.raises(InterlockError, match=r"process 7.*reset-fault --by NAME") as caught:
        refuse(tmp_path)
    assert caught.value.nothing_moved
    with pytest.raises(InputError, match="by a person"):
        clear(tmp_path, "  ", "")
    assert standing(tmp_path) == FAULT
    assert clear(tmp_path, "anna", "a kernel panic") == FAULT
    refuse(tmp_path)
    kept = Reset.model_validate_json((tmp_path / HISTORY).read_text())
    assert (kept.by, kept.reason, kept.fault) == ("anna", "a kernel panic", FAULT)
    assert clear(tmp_path, "anna", "") is None


def test_a_fault_is_kept_though_somebody_has_removed_the_folder_meanwhile(tmp_path):
    place = tmp_path / "platform-daemon/amplifier-1"
    lock(place, FAULT)
    assert standing(place) == FAULT


def test_a_lock_that_cannot_be_read_stands(tmp_path):
    (tmp_path / FAULTED).write_text("{")
    with pytest.raises(InterlockError, match="cannot be read"):
        refuse(tmp_path)


def test_the_place_is_that_of_the_devices_not_of_the_working_directory_nor_of_the_file(tmp_path, monkeypatch):
    first = place_of(lab().section)
    monkeypatch.chdir(tmp_path)
    assert place_of(lab("name='another'", "io_card.decimation=1024").section) == first
    assert place_of(lab("power_amplifier.product_id=7").section) != first


def test_a_place_that_cannot_be_made_is_told(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    with pytest.raises(ConfigError, match="set XDG_STATE_HOME"):
        place_of(lab().section)


def test_a_second_owner_is_refused_at_once_and_told_who_the_first_is(tmp_path):
    owner = start_owner(tmp_path, "off")
    try:
        began = time.monotonic()
        with pytest.raises(DeviceDenied, match=f"process {owner.pid}") as caught:
            take(tmp_path, "lab")
        assert time.monotonic() - began < 2.0
        assert caught.value.nothing_moved
        found = owner_of(tmp_path)
        assert found is not None
        assert (found.pid, found.lives, found.data) == (owner.pid, True, os.path.abspath("data"))
        (tmp_path / "owner").unlink()  # by somebody who takes it for one that was left behind
        with pytest.raises(DeviceDenied, match="have an owner"):
            take(tmp_path, "lab", patience_s=0.2)
    finally:
        owner.kill()
        owner.wait()
    assert owner_of(tmp_path) is None


def test_a_stale_lock_is_taken_over(tmp_path):
    owner = start_owner(tmp_path, "off")
    owner.kill()
    owner.wait()
    took = take(tmp_path, "lab")
    assert standing(tmp_path) is None
    took.release()
    assert owner_of(tmp_path) is None


def test_an_owner_that_died_with_its_guard_while_power_might_be_on_leaves_a_fault(tmp_path):
    owner = start_owner(tmp_path, "on")
    owner.kill()
    owner.wait()
    take(tmp_path, "lab").release()
    found = standing(tmp_path)
    assert found is not None
    assert (found.owner, found.cause, found.proved) == (owner.pid, Cause.TOGETHER, False)


def test_a_child_that_is_forked_does_not_hold_what_its_parent_owned(tmp_path):
    took = take(tmp_path, "lab")
    child = os.fork()
    if child == 0:
        time.sleep(5)
        os._exit(0)
    took.release()
    took_again = take(tmp_path, "lab", patience_s=0.1)
    took_again.release()
    os.kill(child, 9)
    os.waitpid(child, 0)


def test_a_lease_beyond_the_limit_of_the_site_is_refused_before_the_shot():
    file = lab("guard.lease_s=12.0", "limits.max_lease_s=8.0")
    guard = guard_for(file.section, file.limits.max_lease_s)
    try:
        refusal = guard.refusal()
        assert refusal is not None
        assert "12 s" in str(refusal)
        assert "limits.max_lease_s is 8 s" in str(refusal)
        with pytest.raises(InterlockError, match="lease"):
            guard.power_may_come()
    finally:
        guard.close()


def test_a_guard_lets_no_power_out_while_a_fault_stands():
    section = lab().section
    lock(place_of(section), FAULT)
    guard = guard_for(section)
    try:
        with pytest.raises(InterlockError, match="named person"):
            guard.power_may_come()
        assert guard.reset("anna", "") == str(FAULT)
        assert guard.refusal() is None
    finally:
        guard.close()
