"""What the index keeps of a recording: its good on-line fits, and the noise outside the ring-down's harmonics."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Sequence
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from drivers.errors import RecordingError
from platform_daemon.core.recordings.header import FitTable
from platform_daemon.core.recordings.index import entry_of
from platform_daemon.core.recordings.indexed import IndexedRecording, IndexedShot
from platform_daemon.core.recordings.procedure_steps import chosen_step
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recorded_fits import read_fit
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.core.schemas.text import same_name

from .points import points_in

PREFERRED = "d30"
"""The on-line fits that are taken if there are several."""
NOISE_FROM_HZ, BESIDE_HZ, HARMONICS = 20.0, 8.0, 30
"""The noise is what lies above the first frequency and not within the second (in a second; further where there is less)
of one of so many harmonics of the swing."""
_TAG = re.compile(r"#\w[\w.:-]{0,60}")
_BESIDE_A_WORD = ".,;:!?()[]{}\"'"  # "#keep, #night." are two tags
_NOISE_S = 1.0  # of the end of the RX window


def look_at_recording(path: Path) -> tuple[IndexedRecording, Sequence[IndexedShot]] | None:
    """What the index holds of a recording and its shots; None: another program wrote it.  Raises RecordingError."""
    recording = open_recording(path)
    p = recording.provenance
    if p is None:
        return None
    fit = PREFERRED if PREFERRED in recording.fits else next(iter(recording.fits), None)
    table = None if fit is None else read_fit(recording, fit)
    shots = [] if table is None else _shots(recording, table)
    taken = chosen_step(recording, None)
    charted = shots if taken is None else [shot for shot in shots if shot.frame in taken[0].frames]
    found = IndexedRecording(
        identifier=path.stem,
        begun=_utc(p.start_time, path),
        specimen=same_name(p.sample_name),
        operator=p.operator,
        frames=recording.frames,
        good=sum(info.verdict == "good" for info in recording.frame_info),
        calibration=None if recording.calibration is None else recording.calibration.identifier,
        fit=None if table is None else f"{fit} {table.variant}".strip(),
        resonator=str(tomllib.loads(recording.resonator_toml()).get("name", "")),
        tags=tags_in(p.comment),
        points=points_in(charted),
        step="" if taken is None else str(taken[0]),
        clock=p.clock,
        listed=entry_of(recording),
    )
    return found, shots


def tags_in(comment: str) -> frozenset[str]:
    """Words that begin with #, without it, in small letters."""
    words = (word.strip(_BESIDE_A_WORD) for word in comment.split())
    return frozenset(same_name(word[1:]).casefold() for word in words if _TAG.fullmatch(word))


def _shots(recording: Recording, table: FitTable) -> list[IndexedShot]:
    found = []
    for k, info in enumerate(recording.frame_info):
        if table.verdict[k] != "good" or info.verdict != "good" or info.blank or info.time_stamp is None:
            continue
        estimated = np.isfinite(table.values[k]) & np.isfinite(table.std[k])
        values = {name: float(table.values[k, j]) for j, name in enumerate(table.parameters) if estimated[j]}
        values["nrmse"] = float(table.nrmse[k])
        values |= _noise(recording, k, values.get("f_nat_hz"), values.get("phi_max_rad", 0.0))
        field_t = None if info.excitation is None else info.excitation.field_t
        at = _utc(info.time_stamp, recording.path)
        kept = {name: value for name, value in values.items() if math.isfinite(value)}
        found.append(IndexedShot(k, at, info.temperature_c, field_t, kept))
    return found


def _noise(recording: Recording, k: int, f_nat_hz: float | None, phi_max_rad: float) -> dict[str, float]:
    """Volts RMS of each channel beside the ring-down, `noise_CHANNEL_v`; nothing in windows too short for it."""
    rate = recording.sequence.rate_hz
    volts = recording.rx_volts(k)
    volts = volts[:, -min(volts.shape[1], round(_NOISE_S * rate)) :]
    levels = noise_beside(volts, rate, f_nat_hz, phi_max_rad)
    said = recording.provenance
    names = said.channel_names if said is not None and said.channel_names else tuple(map(str, range(len(volts))))
    return {} if levels is None else {f"noise_{name}_v": float(v) for name, v in zip(names, levels, strict=True)}


def noise_beside(
    volts: NDArray[np.float64], rate_hz: float, f_nat_hz: float | None, phi_max_rad: float = 0.0
) -> NDArray[np.float64] | None:
    """RMS (channels,) of volts (channels, n) outside of the harmonics of the swing, as if it were as dense within them;
    None if nothing lies there.

    A large swing is slower than f_nat (at 55 degrees by 12 Hz), and comes up to it: each harmonic is a band.
    """
    n = volts.shape[1]
    frequency = np.fft.rfftfreq(n, 1.0 / rate_hz)
    whole = beside = frequency >= NOISE_FROM_HZ
    if f_nat_hz is not None:
        slowest_hz = f_nat_hz / (1.0 + phi_max_rad**2 / 16.0 + 11.0 * phi_max_rad**4 / 3072.0)  # of a pendulum
        aside_hz = BESIDE_HZ * max(1.0, _NOISE_S * rate_hz / n)
        order = np.maximum(np.ceil((frequency - aside_hz) / f_nat_hz), 1.0)  # the first whose band ends above it
        beside = whole & ((order * slowest_hz - aside_hz > frequency) | (order > HARMONICS))
    if not beside.any():
        return None
    window = np.hanning(n + 1)[:-1]  # periodic.  numpy's, because scipy.signal would be loaded at every start
    power = np.abs(np.fft.rfft((volts - volts.mean(axis=1, keepdims=True)) * window, axis=1)) ** 2
    share = np.count_nonzero(beside) / np.count_nonzero(whole)
    found: NDArray[np.float64] = np.sqrt(2.0 * power[:, beside].sum(axis=1) / (n * np.sum(window**2)) / share)
    return found


def _utc(text: str, path: Path) -> str:
    """ISO 8601 in UTC, so that texts are in the order of time.  Raises RecordingError."""
    try:
        found = datetime.fromisoformat(text)
        in_utc = (found if found.tzinfo else found.replace(tzinfo=UTC)).astimezone(UTC)
    except (ValueError, OverflowError):
        what, remedy = f"{text!r} is no time of ISO 8601", "write another copy of the recording"
        raise RecordingError(what, where=str(path), remedy=remedy) from None
    return in_utc.isoformat(timespec="milliseconds")
