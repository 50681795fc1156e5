"""A daemon on an emulated lab, with everything that the world alone knows kept for comparison."""

from __future__ import annotations

import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from platform_daemon.core.hardware import hardware_thread as thread_module
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.jobs.jobs import Job
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.requests import AcquisitionRequest
from platform_daemon.features.acquire.destination import OwnFile, ShotSink
from platform_daemon.features.acquire.planning import AcquisitionPlan
from platform_daemon.features.acquire.series_plan import plan_series, series_bench
from platform_daemon.features.acquire.work import SeriesWork
from platform_daemon.processes.assembly import start_engine
from tests.kit.emulated_lab import Lab

RX_S = 0.6
HALF_A_CODE_V = 0.5 / 32768
SAMPLES_LATE = 24  # of the recording, see docs/reference/wiring.md
CHUNK = 1216
QUICK = (  # impatient, so that a campaign does not only wait
    f"io_card.chunk_samples={CHUNK}",
    "io_card.reply_timeout_s=1.5",
    "io_card.sample_timeout_s=1.5",
    "power_amplifier.timeout_s=1.6",
    "tx_rx_switch.timeout_s=1.6",
    "lna.timeout_s=1.6",
    "self_test.enabled=true",
    "self_test.tone_s=0.03",
)
PATIENCE_S = 180.0
NEVER_S = 3600.0


class WatchedSeries(SeriesWork):
    """Tells before which shot it is."""

    def __init__(self, before_shot: Callable[[int], None], *arguments: Any, **options: Any) -> None:
        super().__init__(*arguments, **options)
        self._before_shot, self._number = before_shot, 0

    def _pause(self, job: Job, done: int, series: ShotSink) -> None:
        self._number += 1
        if self._number > 1:
            self._before_shot(self._number)
        super()._pause(job, done, series)


class Bench:
    """Emulator and daemon in one process.  `shots` are all shots that the world has played, as their feeds.

    While it lives idle devices are not read back, so that a fault meets the phase it is meant for.
    """

    def __init__(self, folder: Path, seed: int) -> None:
        self.folder = folder
        self.lab = Lab(folder, 'specimen="../resonators/jewel.toml"', f"world.seed={seed}", f"seed={seed}")
        self.shots: list[Any] = []
        self._listen_in()
        self.engine: Engine | None = None
        self.made = 0
        self._idle_s, thread_module.IDLE_S = thread_module.IDLE_S, NEVER_S

    @property
    def world(self) -> Any:
        """The simulated world."""
        return self.lab.emulator.world

    def start(self) -> Engine:
        """The daemon.  Raises what a start raises."""
        if self.engine is None:
            self.engine = start_engine(self.lab.file(*QUICK))
        return self.engine

    def close(self) -> None:
        """The daemon ends."""
        engine, self.engine = self.engine, None
        if engine is not None:
            engine.close()

    def end(self) -> None:
        """Everything ends."""
        try:
            self.close()
        finally:
            thread_module.IDLE_S = self._idle_s
            self.lab.emulator.close()

    def series(
        self,
        shots: int,
        *,
        self_test: bool = False,
        before: Callable[[], None] = lambda: None,
        before_shot: Callable[[int], None] = lambda number: None,
    ) -> tuple[Job, Path]:
        """A series to its end; `before` runs in the hardware's thread at its start, `before_shot` before each shot but
        the first, with its number."""
        engine = self.start()
        self.made += 1
        target = self.folder / f"{self.made}.h5"

        made_with = series_bench(engine)
        if not self_test:
            made_with = replace(made_with, chain_test=None)
        self._first_of_all(engine, before)
        job = engine.submit(WatchedSeries(before_shot, made_with, self._plan(shots), OwnFile(target, self.folder)))
        assert job.ended.wait(PATIENCE_S), "the daemon hangs"
        return job, target

    @staticmethod
    def _first_of_all(engine: Engine, before: Callable[[], None]) -> None:
        """Have `before` called in the hardware's thread when the next job begins, which is by proving outputs off."""
        platform, prove_off = engine.platform, engine.platform.outputs_off

        def outputs_off() -> None:
            platform.outputs_off = prove_off  # type: ignore[method-assign]
            before()
            prove_off()

        platform.outputs_off = outputs_off  # type: ignore[method-assign]

    def chunks(self) -> int:
        """Hardware chunks of a shot."""
        return -(-self._plan(1).excited.timeline.total_samples // CHUNK)

    def _plan(self, shots: int) -> AcquisitionPlan:
        ask = AcquisitionRequest(resonator="jewel", shots=shots, sequence={"rx_s": RX_S}, window=None)
        return plan_series(self.start(), ask)

    def wrong_samples(self, target: Path, first: int) -> list[str]:
        """Good shots of a recording that differ from what the world's converters recorded; `first`: how many shots the
        world had played before the recording's first."""
        recording = open_recording(target)
        out = []
        for k, info in enumerate(recording.frame_info):
            if info.verdict != "good":
                continue
            volts = recording.frame_volts(k)
            if volts.shape[1] != recording.sequence.total or not self._is_true(first + k, volts):
                out.append(f"good shot {k + 1} of {target.name} is not what the world recorded")
        return out

    def _is_true(self, shot: int, volts: NDArray[np.float64]) -> bool:
        truth = self.shots[shot].volts(SAMPLES_LATE, SAMPLES_LATE + volts.shape[1])
        return bool(np.max(np.abs(volts - truth)) < HALF_A_CODE_V)

    def _listen_in(self) -> None:
        start, lock = self.world.start, threading.Lock()

        def listening(timeline: Any, feed: Any = None) -> float:
            with lock:
                self.shots.append(feed)
            at_s: float = start(timeline, feed)
            return at_s

        self.world.start = listening
