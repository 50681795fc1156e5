"""Kernels are compiled late, and never stale."""

import subprocess
import sys

from platform_daemon.estimation import jit, warm_up
from platform_daemon.estimation.half_swing import integrate_half_swing
from platform_daemon.estimation.moments import collect_swings
from platform_daemon.estimation.sampling import fill_basis
from platform_daemon.estimation.terms.dispatch import acceleration, timed_acceleration
from platform_daemon.estimation.trace import trace_half_swings


def test_the_cache_of_every_kernel_depends_on_the_sources_of_all_kernels():
    kernels = [integrate_half_swing, trace_half_swings, acceleration, timed_acceleration]
    assert {k._cache._cache_file._source_stamp for k in kernels} == {jit._sources_digest()}


def test_importing_the_room_compiles_nothing():
    code = (
        "import platform_daemon.estimation as e, platform_daemon.estimation.trace as t; "
        "assert not t.trace_half_swings.signatures, t.trace_half_swings.signatures"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60)


def test_each_entry_kernel_is_compiled_for_one_signature_only():
    warm_up()
    # Inner kernels have none at all when the outer ones came from the cache.
    assert [len(k.signatures) for k in (trace_half_swings, fill_basis, collect_swings)] == [1, 1, 1]
