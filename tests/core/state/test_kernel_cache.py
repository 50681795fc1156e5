"""A cache of compiled kernels is never a condition: where none can be kept, programs run all the same."""

from __future__ import annotations

import os
import subprocess
import sys

import pytest

import platform_daemon
from platform_daemon.core.state.kernel_cache import FONTS, NOWHERE, VARIABLE, choose_font_cache, choose_kernel_cache
from tests.kit.unit_isolation import ROOT, isolated, needs_namespaces


@pytest.fixture(autouse=True)
def nothing_chosen(monkeypatch):
    """Neither place stands in the environment, and none that a test chooses stays there afterwards."""
    for name in (VARIABLE, FONTS):
        monkeypatch.setenv(name, "")  # what is deleted only if it is there is not taken back
        monkeypatch.delenv(name)


@pytest.fixture
def read_only(monkeypatch, tmp_path):
    """An installation that cannot be written, for which a file stands."""
    (tmp_path / "installed").write_text("")
    monkeypatch.setattr(platform_daemon, "__file__", str(tmp_path / "installed/platform_daemon/__init__.py"))


def test_an_installation_that_can_be_written_keeps_its_own():
    assert choose_kernel_cache() is None
    assert VARIABLE not in os.environ


def test_kernels_are_kept_with_the_state_else(read_only, monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    assert choose_kernel_cache() is None
    assert os.environ[VARIABLE] == str(tmp_path / "state/platform-daemon/kernels")


@pytest.mark.parametrize("home", ["", "~", "/proc/nowhere"])
def test_without_any_place_it_is_said_once_and_nothing_is_made(read_only, monkeypatch, tmp_path, home):
    monkeypatch.setenv("HOME", home)
    monkeypatch.delenv("XDG_STATE_HOME")
    monkeypatch.chdir(tmp_path)
    before = set(tmp_path.iterdir())
    assert "set XDG_STATE_HOME" in choose_kernel_cache()
    assert choose_kernel_cache() is None  # nor in the programs that this one starts
    assert os.environ[VARIABLE] == NOWHERE
    assert set(tmp_path.iterdir()) == before


def test_a_place_that_somebody_has_named_is_kept_if_it_can_be_used(monkeypatch, tmp_path):
    monkeypatch.setenv(VARIABLE, str(tmp_path / "mine"))
    assert choose_kernel_cache() is None
    assert os.environ[VARIABLE] == str(tmp_path / "mine")


def test_fonts_are_kept_with_the_state_where_there_is_no_home(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    choose_font_cache()
    assert FONTS not in os.environ  # matplotlib's own place
    monkeypatch.setenv("HOME", "/proc/nowhere")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    choose_font_cache()
    assert os.environ[FONTS] == str(tmp_path / "state/platform-daemon/matplotlib")
    monkeypatch.delenv(FONTS)

    def no_account():
        raise RuntimeError("Could not determine home directory.")

    monkeypatch.setattr("pathlib.Path.home", no_account)  # as of a number that no account has
    choose_font_cache()
    assert os.environ[FONTS] == str(tmp_path / "state/platform-daemon/matplotlib")


@needs_namespaces
def test_an_account_that_can_write_nothing_compiles_and_leaves_no_folder(tmp_path):
    """Case 07. Both kinds of kernels, as the account of a service without a home."""
    if os.geteuid() != 0:
        pytest.skip("only root can run a program as another account")
    work = tmp_path / "work"
    work.mkdir()
    os.chown(work, 12345, 12345)
    program = tmp_path / "program"
    program.mkdir()
    (program / "kernels.py").write_text(
        "import os\nfrom platform_daemon.core.state.kernel_cache import choose_kernel_cache\n"
        "print(choose_kernel_cache() is None, choose_kernel_cache(), os.environ.get('NUMBA_CACHE_DIR'))\n"
        "from platform_daemon.estimation.numerics.jit import kernel\n"
        "from sim_backend.rotor.kernel import kernel as simulated\n"
        "@kernel\ndef twice(x):\n    return 2.0 * x\n"
        "@simulated\ndef thrice(x):\n    return 3.0 * x\n"
        "print(twice(1.0), thrice(1.0), os.listdir('.'))\n"
    )
    for folder in (work, program):
        folder.chmod(0o755)
    command = isolated(
        ["env", "-i", "PATH=/usr/bin:/bin", f"PYTHONPATH={ROOT}", "sh", "-c",
         f"cd {work} && exec {sys.executable} {program / 'kernels.py'}"],
        [work, program], 12345,
    )  # fmt: skip
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stdout.splitlines() == ["False None /dev/null", "2.0 3.0 []"]


def test_a_full_disk_costs_the_cache_and_no_result(tmp_path):
    program = tmp_path / "kernels.py"
    program.write_text(
        "from platform_daemon.estimation.numerics.jit import kernel\n"
        "from sim_backend.rotor.kernel import kernel as simulated\n"
        "@kernel\ndef twice(x):\n    return 2.0 * x\n"
        "@simulated\ndef thrice(x):\n    return 3.0 * x\n"
        "import resource\nresource.setrlimit(resource.RLIMIT_FSIZE, (0, 0))\n"
        "import signal\nsignal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "assert (twice(1.0), thrice(1.0)) == (2.0, 3.0)\n"
    )
    environment = os.environ | {VARIABLE: str(tmp_path / "cache"), "PYTHONPATH": str(ROOT)}
    done = subprocess.run(
        [sys.executable, program], capture_output=True, text=True, env=environment, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
