"""What is read of each file for a diagnosis: frames and angles with their noise, and what had to be left out."""

from __future__ import annotations

from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from drivers.errors import PlatformError
from platform_daemon.diagnosis.selection.data_integrity import DataDefect
from platform_daemon.diagnosis.shots.shot import DiagnosisShot
from platform_daemon.estimation.noise.model import estimate_noise
from platform_daemon.estimation.noise.series import SeriesNoise
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.screening.screening import screen_free_swing
from platform_daemon.features.fit.measurement import AngleMeasurement, VoltageMeasurement
from platform_daemon.features.fit.rotor_context import assumed_rotor_context

_NO_FREE_SWING = (Refusal.NOT_FINITE, Refusal.TOO_SHORT, Refusal.NO_SIGNAL, Refusal.NO_DECAY)
_MOST_SEARCHED = 12_000_000  # values of all channels: a minute of three at 61 kHz takes 1.2 GB and half a minute
_FEWEST_SEARCHED = 4  # shots
ABSORBED = (
    "no calibration: every coil has two free sensitivities, of the odd harmonics and of the even ones, which take up "
    "the gains of the channels, their mixing, the orientation and the moment; effects of these kinds cannot be seen"
)
"""What volts cannot tell."""


@dataclass
class LoadedShots:
    """What has been read so far; remedies: for what was left out, where there is a better one than another record."""

    shots: list[DiagnosisShot]
    flaws: list[DataDefect]
    notes: list[str]
    refusals: list[str] = field(default_factory=list)
    remedies: list[str] = field(default_factory=list)
    further: list[Callable[[], DiagnosisShot | None]] = field(default_factory=list)

    def leave_out(self, name: str, why: str, remedy: str = "") -> None:
        """A frame that is no good."""
        self.refusals.append(f"{name} was left out: {why}")
        self.notes.append(self.refusals[-1])
        self.remedies += [remedy] if remedy else []


def add_frames(
    recorded: VoltageMeasurement, frames: Sequence[int], searched: Container[int], bearing: str, loaded: LoadedShots
) -> None:
    """Good frames of a recording with its noise; blank ones only tell the noise.

    searched: frames that are read now; the others are read when they are requested; bearing: name of the model, by
    which a rotor is assumed where the recording declares none.
    """
    reader = _FrameReader(recorded, bearing)
    if recorded.calibration is None and ABSORBED not in loaded.notes:
        loaded.notes.append(ABSORBED)
    for k in frames:
        info = recorded.recording.frame_info[k]
        if info.blank:
            continue
        if info.verdict != "good":
            loaded.leave_out(reader.name(k), info.reason or info.verdict)
        elif k in searched:
            reader.add(k, loaded)
        else:
            loaded.further.append(partial(reader.shot, k))


class _FrameReader:
    """Frames of one recording as shots, with its noise."""

    def __init__(self, recorded: VoltageMeasurement, bearing: str) -> None:
        self._recorded, self._noise, self._sensitivity = recorded, recorded.noise(), None
        self._bearing = bearing
        if recorded.calibration is not None:
            sensitivity = np.asarray(recorded.calibration.sensitivity, dtype=np.float64)
            self._sensitivity = sensitivity if sensitivity.shape[0] == sensitivity.shape[1] else None

    def name(self, k: int) -> str:
        """As a report calls frame k."""
        return f"{self._recorded.path.name} frame {k}"

    def shot(self, k: int) -> DiagnosisShot | None:
        """Frame k; None if it cannot be used."""
        alone = LoadedShots([], [], [])
        self.add(k, alone)
        return alone.shots[0] if alone.shots else None

    def add(self, k: int, loaded: LoadedShots) -> None:
        """Frame k to the shots, or why not to the notes."""
        name, recorded = self.name(k), self._recorded
        try:
            signal = recorded.signal(k)
        except PlatformError as error:
            loaded.leave_out(name, error.what)
            return
        clipped = signal.clipping()
        if clipped is not None:
            loaded.flaws.append(DataDefect(id="saturation", where=f"{name}: {clipped}", shot=-1))
            loaded.leave_out(name, f"saturated: {clipped}", "record excited shots without clipping")
            return
        of_shot = self._noise.for_shot(signal.record)
        if of_shot.model is None:
            loaded.leave_out(name, "its noise cannot be measured")
            return
        loaded.notes += [f"{name}: {note}" for note in (*signal.notes, of_shot.note) if note]
        unit = "counts" if recorded.recording.counts else ""
        shot = DiagnosisShot(
            name, signal.record, of_shot.model, self._sensitivity, recorded.path.name, unit,
            assumed_rotor_context(recorded.recording, k, self._bearing) if recorded.calibration is not None else None,
        )  # fmt: skip
        loaded.shots.append(shot)


def searched_frames(recorded: Sequence[tuple[VoltageMeasurement, Sequence[int]]]) -> list[set[int]]:
    """Of every recording the frames that are searched: all, or so many, evenly spread, as memory and time allow."""
    good = [
        (n, k, m.recording.channels * (m.recording.sequence.total - m.recording.sequence.rx_start))
        for n, (m, frames) in enumerate(recorded)
        for k in frames
        if not m.recording.frame_info[k].blank and m.recording.frame_info[k].verdict == "good"
    ]
    most = _MOST_SEARCHED * len(good) / max(sum(values for _, _, values in good), 1)
    count = min(len(good), max(_FEWEST_SEARCHED, int(most)))
    chosen = {round(place) for place in np.linspace(0, len(good) - 1, count)} if count else set()
    return [{k for i, (of, k, _) in enumerate(good) if of == n and i in chosen} for n in range(len(recorded))]


def add_angle(measurement: AngleMeasurement, noise: SeriesNoise, loaded: LoadedShots) -> None:
    """An angle series is one shot, with a common noise where several are alike."""
    name, signal = measurement.path.name, measurement.signal(0)
    series = measurement.series
    loaded.flaws += [DataDefect(id="clock_gap", where=f"{name}: {text}", shot=-1) for text in series.clock]
    loaded.notes += [f"{name}: {text}" for text in series.done]
    if not series.finite:
        loaded.flaws.append(DataDefect(id="not_finite", where=f"{name}: samples are not finite numbers", shot=-1))
    try:
        screen_free_swing(signal.record)
    except RefusedError as refused:
        # Other defects are reported by the fits, or with them.
        if refused.code in _NO_FREE_SWING:
            code, advice = refused.code.name.lower(), refused.advice or refused.code.value.rpartition("; ")[2]
            loaded.leave_out(name, f"{code}: {refused.seen}", advice)
            return
    # A short record says nothing about others, and something about itself.
    model = noise.for_shot(signal.record).model or estimate_noise(signal.record)
    loaded.shots.append(DiagnosisShot(name, signal.record, model, None, name))
