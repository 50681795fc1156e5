"""Kernels are compiled late, and never stale."""

import os
import subprocess
import sys
from pathlib import Path

import numba

from platform_daemon.estimation.compilation import synthetic_record, warm_up
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.moments.tabulated import collect_half_cycles
from platform_daemon.estimation.numerics import jit
from platform_daemon.estimation.numerics.jit import part
from platform_daemon.estimation.physics.torques import AUTONOMOUS, TIMED
from platform_daemon.estimation.physics.trajectory.basis_functions import fill_basis
from platform_daemon.estimation.physics.trajectory.direct import Trajectory
from platform_daemon.estimation.physics.trajectory.direct_chain import trace_half_cycles
from platform_daemon.estimation.physics.trajectory.half_cycle_chain import walk_half_cycles
from platform_daemon.estimation.physics.trajectory.half_cycle_table import build_table


def test_the_cache_of_every_kernel_depends_on_the_sources_of_all_kernels():
    kernels = [trace_half_cycles, fill_basis, build_table, walk_half_cycles, collect_half_cycles]
    stamps = {k._cache._cache_file._source_stamp for k in kernels}  # noqa: SLF001 numba's own
    assert stamps == {jit.sources_digest()}


def test_every_inlined_torque_term_counts_as_a_source_of_kernels():
    for term in (*AUTONOMOUS, *TIMED):
        assert jit.has_kernels(Path(sys.modules[term.function.__module__].__file__).read_bytes()), term.name


def test_importing_the_room_compiles_nothing():
    code = (
        "import platform_daemon.estimation as e, platform_daemon.estimation.physics.trajectory.direct_chain as t; "
        "assert not t.trace_half_cycles.signatures, t.trace_half_cycles.signatures"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_each_entry_kernel_is_compiled_for_one_signature_only():
    warm_up()
    assert [len(k.signatures) for k in (trace_half_cycles, fill_basis, collect_half_cycles)] == [1, 1, 1]


def test_a_part_is_compiled_once_whatever_the_options_of_its_callers_and_is_plain_python_elsewhere():
    @part
    def doubled(x):
        return 2.0 * x

    exact = numba.njit(lambda x: doubled(x) + 1.0)
    fast = numba.njit(fastmath=True, nogil=True)(lambda x: doubled(x) - 1.0)
    assert (exact(3.0), fast(3.0), doubled(3.0)) == (7.0, 5.0, 6.0)
    assert len(doubled.compiled.overloads) == 1


def test_the_made_up_record_passes_as_clean_so_that_no_more_than_a_clean_fit_needs_is_compiled_first(monkeypatch):
    def traced(*_args, **_keys):
        raise AssertionError("the residual was looked into")

    monkeypatch.setattr(Trajectory, "__init__", traced)
    record, noise = synthetic_record()
    assert fit_ring_down(record, "thread", noise=noise).verdict == "good"


def test_without_compilation_kernels_are_plain_python():
    """Case 11: NUMBA_DISABLE_JIT."""
    program = (
        "from platform_daemon.estimation.numerics.jit import kernel, part, fast_kernel, fast_part, inlined\n"
        "import platform_daemon.estimation.fit, sim_backend.rotor.motion\n"
        "for decorate in (kernel, part, fast_kernel, fast_part, inlined):\n"
        "    assert decorate(lambda x: -x)(-1) == 1\n"
    )
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run([sys.executable, "-c", program], env=environment, capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")
