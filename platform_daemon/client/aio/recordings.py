"""Recordings: what they hold, their signals, and the files."""

from __future__ import annotations

import asyncio
import io
from collections.abc import AsyncIterator
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import httpx2

from platform_daemon.client.downloads import PAUSE_S, TRIES, Download
from platform_daemon.client.errors import ConnectionFailed, Unavailable
from platform_daemon.core.reporting.dataframes import signal_array
from platform_daemon.core.schemas.harmonics import ShotHarmonics
from platform_daemon.core.schemas.recordings import DmdtSeries, RecordingInfo, RecordingSummary, RecoveryReport
from platform_daemon.features.budget.schema import BudgetReport
from platform_daemon.features.fit.frame_plot_schema import FramePlot
from platform_daemon.features.fit.sliding_schema import SlidingReport
from platform_daemon.features.measurand.schema import MeasurandReport

from .transport import AsyncTransport

if TYPE_CHECKING:
    import numpy as np
    import xarray as xr
    from numpy.typing import NDArray

Window = Literal["n50", "d30"] | float


class AsyncRecording:
    """A recording in the data folder of the daemon.  Frames are counted from 0."""

    def __init__(self, transport: AsyncTransport, identifier: str) -> None:
        self._transport, self.id = transport, identifier

    def __repr__(self) -> str:
        return f"<{type(self).__name__} {self.id}>"

    async def info(self, *, first: int = 0, limit: int | None = None) -> RecordingInfo:
        """What it holds: frames, channels, windows, calibration, who measured what and how.

        first, limit: describe frames from this one on, from 0, and so many at most; None: all.
        """
        query = {"first": first, "limit": limit}
        return await self._transport.get(RecordingInfo, "get_recording", query, identifier=self.id)

    async def samples(
        self, frame: int = 0, *, start_s: float | None = None, stop_s: float | None = None
    ) -> NDArray[np.float64]:
        """Every sample of a frame, (channels, n): dm/dt in A m^2/s on the world axes x, y, z; volts of the receive
        channels if the recording has no calibration.

        start_s, stop_s: only this stretch, s after the first RX sample; None: from the beginning, to the end.
        """
        import numpy as np

        query = {"start_s": start_s, "stop_s": stop_s}
        response = await self._transport.send("get_dmdt_npy", query=query, identifier=self.id, frame=frame)
        found: NDArray[np.float64] = np.load(io.BytesIO(response.content))
        return found

    async def dmdt(self, frame: int = 0, *, start_s: float | None = None, stop_s: float | None = None) -> xr.DataArray:
        """The same as an array with the dimensions (channel, time), unit, and the windows of the shot in `.attrs`.

        start_s, stop_s: as of `samples`.  Attributes: units, sampling_rate_hz, recording, frame, tx_s, switch_s, rx_s.
        """
        info = await self.info()
        samples = await self.samples(frame, start_s=start_s, stop_s=stop_s)
        windows = info.windows
        calibrated = info.calibration is not None
        first = 0 if start_s is None else round(start_s * info.rate_hz)
        return signal_array(
            samples,
            info.rate_hz,
            quantity="dmdt" if calibrated else "voltage",
            channels=list("xyz") if calibrated else [str(k) for k in range(len(samples))],
            start_s=first / info.rate_hz,
            attributes={
                "recording": self.id,
                "frame": frame,
                "tx_s": windows.tx.seconds,
                "switch_s": windows.switch.seconds,
                "rx_s": windows.rx.seconds,
            },
        )

    async def points(
        self, frame: int = 0, *, points: int = 2000, start_s: float | None = None, stop_s: float | None = None
    ) -> DmdtSeries:
        """Smallest and largest values of each of so many stretches of a frame, for a plot.

        points: at most so many values; start_s, stop_s: as of `samples`.
        """
        query = {"points": points, "start_s": start_s, "stop_s": stop_s}
        return await self._transport.get(DmdtSeries, "get_dmdt", query, identifier=self.id, frame=frame)

    async def plot_data(self, frame: int = 0, *, window: Window = "d30", variant: str | None = None) -> FramePlot:
        """Signal, fit and residual of a frame, as the page draws them.

        window: evaluation window, n50, d30 or seconds; variant: the model, declared or adopted, None: the resonator's.
        """
        query = {"window": window, "variant": variant}
        return await self._transport.get(FramePlot, "get_frame_plot", query, identifier=self.id, frame=frame)

    async def picture(self, frame: int = 0, *, window: Window = "d30", variant: str | None = None) -> bytes:
        """Signal, fit and residual of a frame as a PNG.

        window: evaluation window, n50, d30 or seconds; variant: the model, declared or adopted, None: the resonator's.
        """
        query = {"window": window, "variant": variant}
        return (await self._transport.send("draw_frame", query=query, identifier=self.id, frame=frame)).content

    async def harmonics(self, frame: int = 0) -> ShotHarmonics:
        """What the harmonics alone tell of a frame, without a fit."""
        return await self._transport.get(ShotHarmonics, "get_harmonics", identifier=self.id, frame=frame)

    async def budget(
        self,
        quantity: str = "f_nat_hz",
        *,
        shot: int | None = None,
        coverage: float = 0.95,
        window: Window = "d30",
        variant: str | None = None,
    ) -> BudgetReport:
        """The uncertainty budget of a parameter: what each influence contributes, and what is not declared.

        quantity: public name of the parameter, as m_r_am2.  shot: one frame, from 0; None: the mean of the series.
        coverage: probability of the interval value ± U, above 0 and below 1.  window: n50, d30 or seconds; variant: the
        model, declared or adopted, None: the resonator's.

        Raises NotFound; InvalidRequest for a quantity, shot or model that it has not, and where no frame has a fit.
        """
        query = {"quantity": quantity, "shot": shot, "coverage": coverage, "window": window, "variant": variant}
        return await self._transport.get(BudgetReport, "get_budget", query, identifier=self.id)

    async def budget_picture(
        self,
        quantity: str = "f_nat_hz",
        *,
        shot: int | None = None,
        coverage: float = 0.95,
        window: Window = "d30",
        variant: str | None = None,
    ) -> bytes:
        """The same as a PNG: a bar for each contribution, the largest on top.

        quantity, shot, coverage, window, variant: as of `budget`, and so are the errors.
        """
        query = {"quantity": quantity, "shot": shot, "coverage": coverage, "window": window, "variant": variant}
        return (await self._transport.send("draw_budget", query=query, identifier=self.id)).content

    async def measurand(
        self, calibration: str | None = None, *, coverage: float = 0.95, extrapolate: bool = False
    ) -> MeasurandReport:
        """The recording as readings of a sensor: value and expanded uncertainty of every shot and of their mean.

        calibration: KEY or KEY@VERSION; None: the newest of the specimen.  coverage: probability of the interval value
        ± U, above 0 and below 1.  extrapolate: read outside of its range, too.
        """
        query = {"calibration": calibration, "coverage": coverage, "extrapolate": extrapolate}
        return await self._transport.get(MeasurandReport, "read_measurand", query, identifier=self.id)

    async def sliding(
        self, frame: int = 0, *, window_s: float | None = None, step_s: float | None = None, variant: str | None = None
    ) -> SlidingReport:
        """The parameters in a window that slides over a frame.

        window_s: its length, s; step_s: from one to the next, s; variant: the model; None: the daemon's defaults.
        """
        query = {"window_s": window_s, "step_s": step_s, "variant": variant}
        return await self._transport.get(SlidingReport, "get_sliding", query, identifier=self.id, frame=frame)

    async def download(self, path: str | Path) -> Path:
        """Save the file (HDF5) at `path`, or in that folder under its own name; the place of it.

        A download that is cut off is continued where it ended.  The file has its name once it is whole and its SHA-256
        is that of the daemon.  Raises ConnectionFailed, ChecksumMismatch.
        """
        target = Path(path)
        download = Download(target / f"{self.id}.h5" if target.is_dir() else target)
        tries = 0
        while not download.complete:
            before = download.done
            try:
                await self._continue(download)
            except (httpx2.TransportError, Unavailable) as error:
                tries = 0 if download.done > before else tries + 1
                if tries > TRIES:
                    remedy = "check the network and the daemon, then download it again"
                    why = str(error) or type(error).__name__
                    raise ConnectionFailed("the download was cut off", where=self.id, why=why, remedy=remedy) from None
                await asyncio.sleep(PAUSE_S)
        return download.finish()

    async def _continue(self, download: Download) -> None:
        async with self._transport.stream("download_recording", download.headers(), identifier=self.id) as response:
            download.begin(response)
            async for chunk in response.aiter_raw():
                download.add(chunk)


class AsyncRecordings:
    """The recordings in the data folder of the daemon: `recordings[id]` is one of them."""

    def __init__(self, transport: AsyncTransport) -> None:
        self._transport = transport

    def __getitem__(self, identifier: str) -> AsyncRecording:
        return AsyncRecording(self._transport, identifier)

    __iter__ = None  # else `for` would ask for 0, 1, 2, ... without end: `list` has them all

    async def list(
        self,
        *,
        specimen: str | None = None,
        sample: str | None = None,
        resonator: str | None = None,
        operator: str | None = None,
        since: str | None = None,
        until: str | None = None,
        verdict: str | None = None,
        tag: str | None = None,
    ) -> AsyncIterator[RecordingSummary]:
        """The recordings that are so, oldest name first; None: any.

        specimen, sample, resonator, operator: as they were named at the measurement; since, until: ISO 8601; verdict:
        refused (with a refused shot) or good (without one); tag: a word of the comment after #.
        """
        query: dict[str, Any] = {"specimen": specimen, "sample": sample, "resonator": resonator, "operator": operator}
        query |= {"since": since, "until": until, "verdict": verdict, "tag": tag}
        async for each in self._transport.items(RecordingSummary, "list_recordings", query):
            yield each

    async def recover(self) -> RecoveryReport:
        """Put the shots of series that were cut off together to recordings."""
        return await self._transport.post(RecoveryReport, "recover_recordings")
