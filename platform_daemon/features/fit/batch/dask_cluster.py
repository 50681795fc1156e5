"""An executor on a Dask cluster: archives that outgrow one machine.  Needs the optional extra `dask`.

Whole files are tasks: a file is fitted where one worker reads it. Dask itself sends tasks of lost workers to others.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from importlib.metadata import version
from pathlib import Path
from typing import Any

from drivers.errors import InputError, PlatformError
from platform_daemon import __version__

from .executors import WorkerPool

_CONNECT_S = 10.0
_PACKAGE = "platform-daemon"


@contextmanager
def dask_cluster(address: str, first: Path) -> Iterator[WorkerPool]:
    """The workers of the scheduler at `address`; `first`, one of the files, tells whether they can read our paths.

    Raises InputError if the extra is missing, the address is wrong or the workers lack this software; PlatformError if
    no scheduler answers there.
    """
    with _connected(address) as client:
        _check_software(client, address)
        threads = sum(client.nthreads().values())
        yield WorkerPool(client.get_executor(pure=False), threads, send_content=not _all_read(client, first))


@contextmanager
def _connected(address: str) -> Iterator[Any]:
    """A client that lets go of its futures when it is left."""
    try:
        from distributed import Client
    except ImportError:
        remedy = "install it: pip install 'platform-daemon[dask]'"
        raise InputError("the optional extra 'dask' is not installed", where="--dask", remedy=remedy) from None
    try:
        client = Client(address, timeout=_CONNECT_S, set_as_default=False)
    except (OSError, TimeoutError) as error:
        remedy = "start it with `dask scheduler`, and give the address that it prints, as in tcp://host:8786"
        raise PlatformError("no scheduler answers", where=address, why=_first_line(error), remedy=remedy) from None
    except ValueError as error:
        remedy = "give it as in tcp://host:8786"
        raise InputError("is no address of a scheduler", where=address, why=_first_line(error), remedy=remedy) from None
    try:
        yield client
    finally:
        client.close(timeout=2)


def _check_software(client: Any, address: str) -> None:
    """Raises InputError unless there are workers, all with this version."""
    # A function of the standard library, so that a worker without our package can still answer.
    found = client.run(version, _PACKAGE, on_error="return")
    if not found:
        remedy = f"start some: dask worker {address}"
        raise InputError("the cluster has no workers", where=address, remedy=remedy)
    for worker, theirs in found.items():
        if theirs != __version__:
            have = f"has version {theirs}" if isinstance(theirs, str) else "does not have it"
            why = f"{_PACKAGE} {__version__} is needed, {worker} {have}"
            remedy = "install the same version on every worker"
            raise InputError("a worker cannot fit", where=address, why=why, remedy=remedy)


def _all_read(client: Any, path: Path) -> bool:
    """True if every worker sees this very file under this path."""
    seen = client.run(_signature, str(path.absolute()))
    return set(seen.values()) == {_signature(str(path.absolute()))}


def _signature(path: str) -> tuple[int, int] | None:
    try:
        found = Path(path).stat()
    except OSError:
        return None
    return found.st_size, found.st_mtime_ns


def _first_line(error: BaseException) -> str:
    return (str(error).splitlines() or [type(error).__name__])[0]
