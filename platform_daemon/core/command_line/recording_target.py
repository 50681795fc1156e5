"""The recording that a command is going to write."""

from __future__ import annotations

import sys
from pathlib import Path

from .output import must_not_exist


def prepare_target(out: Path, *, force: bool, dry_run: bool) -> None:
    """Check that the recording can be written; a dry run writes none.

    Series in the folder of `out` whose program was killed are put together first, and named on standard error.

    Raises InputError as `must_not_exist` does.
    """
    if dry_run:
        return
    from platform_daemon.core.recordings.recovery import PUT_TOGETHER, recover  # here, because HDF5 is loaded with it

    for path in recover(out.parent, out if force else None):
        print(f"recovered: {path}: {PUT_TOGETHER}", file=sys.stderr)
    must_not_exist(out, force, ".h5", ".hdf5", ".mmr")
