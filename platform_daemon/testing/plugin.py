"""Fixtures for tests of an analysis or of a script against the platform, without a platform.

platform_daemon   a daemon on the simulated platform, one for the session
faulty_platform   makes a daemon on the emulated lab, with a fault
recording         makes a recording of the simulated platform, whose truth is known; cached by its arguments
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import pytest

if TYPE_CHECKING:
    from platform_daemon.library.recording import Recording

    from .processes import FaultyPlatform, RunningDaemon


@pytest.fixture(scope="session")
def platform_daemon(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningDaemon]:
    """A daemon on the simulated platform, on a free port: `.url`, `.data`, `.client()`."""
    from .processes import running_daemon

    with running_daemon(tmp_path_factory.mktemp("platform_daemon") / "data") as daemon:
        yield daemon


@pytest.fixture
def faulty_platform(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., FaultyPlatform]]:
    """Makes a daemon on the emulated lab: faulty_platform(fault="adc_clip"), faulty_platform(fault="timeout",
    device="lna").

    fault: strikes at the first shot, or that device's wire; None: `.inject` lets one strike later.  Further arguments
    go to the control socket of the emulated lab, as shot=3.
    """
    from .processes import faulty_lab

    with ExitStack() as stack:

        def make(fault: str | None = None, *, device: str | None = None, **arguments: Any) -> FaultyPlatform:
            made = stack.enter_context(faulty_lab(tmp_path_factory.mktemp("faulty_platform")))
            if fault is not None:
                made.inject(fault, device=device, **arguments)
            return made

        yield make


@pytest.fixture(scope="session")
def recording(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Callable[..., Recording]:
    """Makes a recording of the simulated platform: recording("jewel", shots=2, field_ut=490, rx_s=1.0, seed=1).

    Further arguments are the options of `platform-daemon measure`, and undeclared: effects that the simulated world has
    and does not declare, as [{"id": "quadratic_drag", "strength": 1e-3}].  `.truth` has the parameters of the first
    excited frame.  The same arguments return the same file, which the cache of pytest keeps for the next run.
    """

    def make(
        resonator: str = "jewel", *, undeclared: Sequence[dict[str, Any]] = (), seed: int = 1, **options: Any
    ) -> Recording:
        from platform_daemon import __version__
        from platform_daemon.core.recordings.truth import read_truth
        from platform_daemon.core.schemas.parameters import PARAMETERS
        from platform_daemon.library.recording import Recording, open_recording

        from .processes import measure_to

        words = {"resonator": resonator, **options}
        key = hashlib.sha256(json.dumps([__version__, words, list(undeclared), seed], sort_keys=True).encode())
        cache = getattr(request.config, "cache", None)
        folder = Path(cache.mkdir("platform_daemon")) if cache else tmp_path_factory.getbasetemp()
        path = folder / f"{resonator}-{key.hexdigest()[:16]}.h5"
        if not path.exists():
            own = path.with_name(f"{path.stem}-{uuid4().hex}.h5")  # workers of xdist may want the same one at once
            measure_to(own, words, undeclared, seed)
            own.replace(path)
        found = open_recording(path)
        truths = read_truth(path) or []
        truth = truths[found.usable_frame()].get("simulated", {}) if truths else {}
        numbers = {name: float(v) for name, v in truth.items() if name in PARAMETERS and isinstance(v, int | float)}
        return Recording(found.measurement, numbers)

    return make
