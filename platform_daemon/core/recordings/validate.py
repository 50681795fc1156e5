"""Checks what the engine hands over, before anything is written."""

from __future__ import annotations

import re
from dataclasses import fields
from datetime import datetime

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError

from .checks import check_calibration
from .header import FitTable, SeriesHeader, ShotRecord
from .layout import VARIANTS, VERDICTS
from .recording import Excitation


def check_header(header: SeriesHeader) -> None:
    """Raises InputError (for the calibration RecordingError) unless every reader will accept shots of this header."""
    s = header.sequence
    _require(np.isfinite(s.base_frequency_hz) and s.base_frequency_hz > 0, "base frequency must be above 0 Hz")
    _require(s.decimation >= 1, "decimation must be at least 1")
    _require(min(s.tx_samples, s.switch_samples) >= 0 and s.rx_samples >= 1, "windows need tx, switch >= 0, rx >= 1")
    _require(header.channels >= 1, "a recording needs at least one channel")
    _require(header.variant in (None, *VARIANTS), f"variant must be {' or '.join(VARIANTS)}")
    _require(header.planned_shots is None or header.planned_shots >= 1, "planned_shots must be at least 1")
    _require(len(header.channel_names) in (0, header.channels), "channel_names needs one name per channel")
    check_instant(header.start_time, "start_time")
    if header.calibration is not None:
        check_calibration(header.calibration, header.channels, "the header of the series")
    if header.excitation is not None:
        check_excitation(header.excitation)


def check_excitation(excitation: Excitation) -> None:
    """Raises InputError unless it has a waveform, finite numbers, the axis is (3,) and the currents are a list."""
    for entry in fields(excitation):
        if entry.name != "waveform":
            finite = np.isfinite(np.asarray(getattr(excitation, entry.name), dtype=float)).all()
            _require(bool(finite), f"excitation.{entry.name} is not finite")
    _require(bool(excitation.waveform), "excitation.waveform needs a name")
    _require(np.shape(excitation.axis) == (3,), "excitation.axis needs three components")
    _require(np.ndim(excitation.current_a) == 1, "excitation.current_a needs one value per output")


def check_instant(text: str, name: str) -> None:
    """Raises InputError unless `text` is an ISO 8601 instant."""
    try:
        datetime.fromisoformat(text)
    except ValueError:
        raise InputError(f"{name} {text!r} is no ISO 8601 instant", remedy="use datetime.isoformat()") from None


def padded_volts(header: SeriesHeader, shot: ShotRecord) -> tuple[NDArray[np.float32], int]:
    """Volts as they go into /data, (c, n) float32, and how many leading samples are real.

    Raises InputError for a good shot that is short or not finite, and for volts that belong to another sequence.
    A refused shot keeps what it has up to the first sample that is not finite.
    """
    _require(shot.verdict in VERDICTS, f"verdict must be {' or '.join(VERDICTS)}")
    shape = (header.channels, header.sequence.total)
    given = np.asarray(shot.volts)
    fits = given.ndim == 2 and given.shape[0] == shape[0] and given.shape[1] <= shape[1]
    _require(fits or given.size == 0, f"a shot has shape {given.shape}, the sequence {shape}")
    volts = np.zeros(shape, np.float32)
    valid = 0
    if given.size:
        with np.errstate(over="ignore"):
            real = given.astype(np.float32)
        bad = np.flatnonzero(~np.isfinite(real).all(axis=0))
        valid = int(bad[0]) if bad.size else real.shape[1]
        volts[:, :valid] = real[:, :valid]
    _require(valid == shape[1] or shot.verdict == "refused", f"a good shot has {valid} usable of {shape[1]} samples")
    return volts, valid


def check_fit(fit: FitTable, frames: int) -> None:
    """Raises InputError unless the table has one row per frame and one column per parameter."""
    named = re.fullmatch(r"[\w-][\w.-]*", fit.name) is not None
    _require(named, f"fit name {fit.name!r} must consist of letters, digits, _ - and .")
    k = len(fit.parameters)
    expected = {"values": (frames, k), "std": (frames, k), "covariance": (frames, k, k)}
    expected |= dict.fromkeys(("r2", "nrmse", "chi2_per_dof", "window_s", "verdict", "reason"), (frames,))
    for name, shape in expected.items():
        found = np.shape(getattr(fit, name))
        _require(found == shape, f"fit {fit.name!r}: {name} has shape {found}, expected {shape}")


def _require(holds: bool, what: str) -> None:
    if not holds:
        raise InputError(what, where="recording", remedy="correct what is handed to the store")
