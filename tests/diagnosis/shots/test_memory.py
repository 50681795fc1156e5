"""Memory of freed arrays, of this process alone."""

import subprocess
import sys
import textwrap

import pytest

PROGRAM = textwrap.dedent(
    """
    import resource, sys
    import numpy as np
    from platform_daemon.diagnosis.shots.memory import give_large_arrays_back
    if sys.argv[1] == "given":
        give_large_arrays_back()
    np.zeros(24_000_000, dtype=np.uint8)  # once freed, glibc keeps what is smaller
    rows = [np.ones(500_000) for _ in range(60)]
    kept, rows = rows[-1], None
    with open("/proc/self/statm") as pages:
        print(int(pages.read().split()[1]) * resource.getpagesize())
    """
)


@pytest.mark.skipif(sys.platform != "linux", reason="only there is anything to give back")
def test_arrays_that_are_freed_below_one_that_is_kept_go_back():
    kept, given = (
        int(subprocess.run([sys.executable, "-c", PROGRAM, how], check=True, capture_output=True, text=True).stdout)
        for how in ("kept", "given")
    )
    assert given < kept - 100e6
