"""The fault latch, and who owns the devices: files, and processes that die."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from uuid import uuid4

import pytest

from drivers.errors import ConfigError, DeviceDenied, InputError, InterlockError
from platform_daemon.core.guard.fault_latch import (
    FAULT_FILE,
    RESETS_FILE,
    Cause,
    Fault,
    Reset,
    check_no_fault,
    clear_fault,
    latch_fault,
    latched_fault,
)
from platform_daemon.core.guard.guard_client import guard_for
from platform_daemon.core.guard.ownership import owner_of, take_ownership
from platform_daemon.core.guard.state_dir import state_dir_of
from platform_daemon.core.settings import load_platform

FAULT = Fault(platform="lab", when="2026-11-23T02:00:00+00:00", owner=7, cause=Cause.DIED, proved=True)
OWNER = (
    "import sys, time; from pathlib import Path; from platform_daemon.core.guard.ownership import take_ownership\n"
    "held = take_ownership(Path(sys.argv[1]), 'lab', Path('data')); held.power(may_be_on=sys.argv[2] == 'on')\n"
    "print('held', flush=True); time.sleep(60)\n"
)


@pytest.fixture
def tmp_path(tmp_path):
    """A folder whose name no other test of this computer has: it is the name of the devices, which are claimed."""
    folder = tmp_path / uuid4().hex
    folder.mkdir()
    return folder


@pytest.fixture(autouse=True)
def state(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))


def lab(*overrides):
    return load_platform("lab", overrides)


def start_owner(folder, power):
    process = subprocess.Popen([sys.executable, "-c", OWNER, str(folder), power], stdout=subprocess.PIPE)
    assert process.stdout.readline() == b"held\n"
    return process


def test_a_fault_stands_until_a_named_person_resets_it_and_who_did_is_kept(tmp_path):
    assert latched_fault(tmp_path) is None
    check_no_fault(tmp_path)
    latch_fault(tmp_path, FAULT)
    with pytest.raises(InterlockError, match=r"process 7.*reset-fault --by NAME") as caught:
        check_no_fault(tmp_path)
    assert caught.value.nothing_moved
    with pytest.raises(InputError, match="by a person"):
        clear_fault(tmp_path, "  ", "")
    assert latched_fault(tmp_path) == FAULT
    assert clear_fault(tmp_path, "anna", "a kernel panic") == FAULT
    check_no_fault(tmp_path)
    kept = Reset.model_validate_json((tmp_path / RESETS_FILE).read_text())
    assert (kept.by, kept.reason, kept.fault) == ("anna", "a kernel panic", FAULT)
    assert clear_fault(tmp_path, "anna", "") is None


def test_a_fault_is_kept_though_somebody_has_removed_the_folder_meanwhile(tmp_path):
    folder = tmp_path / "platform-daemon/amplifier-1"
    latch_fault(folder, FAULT)
    assert latched_fault(folder) == FAULT


def test_a_fault_that_cannot_be_read_is_one(tmp_path):
    (tmp_path / FAULT_FILE).write_text("{")
    with pytest.raises(InterlockError, match="cannot be read"):
        check_no_fault(tmp_path)


def test_the_place_is_that_of_the_devices_not_of_the_working_directory_nor_of_the_file(tmp_path, monkeypatch):
    first = state_dir_of(lab().section)
    monkeypatch.chdir(tmp_path)
    assert state_dir_of(lab("name='another'", "io_card.decimation=1024").section) == first
    assert state_dir_of(lab("power_amplifier.product_id=7").section) != first


def test_a_place_that_cannot_be_made_is_told(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "file"))
    with pytest.raises(ConfigError, match="set XDG_STATE_HOME"):
        state_dir_of(lab().section)


def test_a_second_owner_is_refused_at_once_and_told_who_the_first_is(tmp_path):
    owner = start_owner(tmp_path, "off")
    try:
        began = time.monotonic()
        with pytest.raises(DeviceDenied, match=f"process {owner.pid}") as caught:
            take_ownership(tmp_path, "lab")
        assert time.monotonic() - began < 2.0
        assert caught.value.nothing_moved
        found = owner_of(tmp_path)
        assert found is not None
        assert (found.pid, found.lives, found.data) == (owner.pid, True, os.path.abspath("data"))
        (tmp_path / "owner").unlink()  # by somebody who takes it for one that was left behind
        with pytest.raises(DeviceDenied, match="have an owner"):
            take_ownership(tmp_path, "lab", patience_s=0.2)
    finally:
        owner.kill()
        owner.wait()
    assert owner_of(tmp_path) is None


def test_the_record_of_a_dead_owner_is_taken_over(tmp_path):
    owner = start_owner(tmp_path, "off")
    owner.kill()
    owner.wait()
    took = take_ownership(tmp_path, "lab")
    assert latched_fault(tmp_path) is None
    took.release()
    assert owner_of(tmp_path) is None


def test_an_owner_that_died_with_its_guard_while_power_might_be_on_leaves_a_fault(tmp_path):
    owner = start_owner(tmp_path, "on")
    owner.kill()
    owner.wait()
    take_ownership(tmp_path, "lab").release()
    found = latched_fault(tmp_path)
    assert found is not None
    assert (found.owner, found.cause, found.proved) == (owner.pid, Cause.TOGETHER, False)


def test_a_child_that_is_forked_does_not_hold_what_its_parent_owned(tmp_path):
    took = take_ownership(tmp_path, "lab")
    child = os.fork()
    if child == 0:
        time.sleep(5)
        os._exit(0)
    took.release()
    took_again = take_ownership(tmp_path, "lab", patience_s=0.1)
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
    latch_fault(state_dir_of(section), FAULT)
    guard = guard_for(section)
    try:
        with pytest.raises(InterlockError, match="named person"):
            guard.power_may_come()
        assert guard.reset("anna", "") == str(FAULT)
        assert guard.refusal() is None
    finally:
        guard.close()
