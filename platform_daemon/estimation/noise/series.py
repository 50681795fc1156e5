"""One noise model for a series of shots: from blank ones where there are any, else from between the harmonics of all.

A single short record determines its noise spectrum to some tens of per cent only; twelve determine it better. A shot
whose noise differs from that of the others keeps its own.
"""

from __future__ import annotations

import math
import time
from dataclasses import dataclass, field, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.screening.spectral_lines import Zones, is_mains
from platform_daemon.estimation.thresholds import THRESHOLDS

from .model import NoiseModel, bridge, estimate_noise, sd_of
from .tones_and_drift import find_tones

LIMITS = THRESHOLDS.noise


@dataclass(frozen=True)
class ShotNoise:
    """The noise to fit a shot with.

    Attributes:
        model: None: unknown, the fit may try for itself.
        note: why it is not that of the series, or None.
        seconds: what finding it out took.
    """

    model: NoiseModel | None
    note: str | None
    seconds: float


@dataclass
class SeriesNoise:
    """Noise of a series; learns from shots until it has seen enough. Not for several threads at once."""

    seconds: float = 0.0
    _blank: bool = False
    _models: list[NoiseModel] = field(default_factory=list)
    _levels: list[Array] = field(default_factory=list)
    _pooled: NoiseModel | None = None

    def learn(self, record: RingDownRecord, *, blank: bool = False, rings_hz: float | None = None) -> None:
        """Take a shot into account. The first blank one replaces what was learned from shots with a signal.

        rings_hz: where the rotor swings, Hz: in a blank shot it may do so still, and that is no noise.
        """
        known = len(self._models) >= LIMITS.enough_shots or self._blank
        if (
            (known and not blank)
            or (self._blank and len(self._models) >= LIMITS.enough_shots)
            or not _is_usable(record)
        ):
            return
        began = time.perf_counter()
        if blank and not self._blank:
            self._models = []
            self._levels = []
            self._blank = True
        self._models.append(_noise_of_blank(record, rings_hz) if blank else estimate_noise(record))
        self._levels.append(_level(record))
        self._pooled = self._pool()
        self.seconds += time.perf_counter() - began

    @property
    def model(self) -> NoiseModel | None:
        """What is known so far; None before the first shot."""
        return self._pooled

    def for_shot(self, record: RingDownRecord) -> ShotNoise:
        """The series' noise, or the shot's own if its level differs."""
        began = time.perf_counter()
        model, note = self.model, None
        if model is not None and _is_usable(record):
            excess = _level(record) - self._usual
            if _is_unlike(excess, record.valid.shape[1]):
                times = ", ".join(f"{r:.3g}" for r in np.exp(excess))
                note = f"this shot's noise is not that of the series ({times} times by channel): its own was used"
                model = estimate_noise(record)
        return ShotNoise(model, note, time.perf_counter() - began)

    @property
    def _usual(self) -> Array:
        return np.asarray(np.median(self._levels, axis=0))

    def _pool(self) -> NoiseModel:
        """Average over the shots that are like most."""
        pairs = zip(self._models, self._levels, strict=True)
        alike = [
            m for m, level in pairs if not _is_unlike(level - self._usual, LIMITS.series_shortest_samples)
        ] or self._models[:1]
        shots = f"{len(alike)} {'blank ' if self._blank else ''}{'shot' if len(alike) == 1 else 'shots'}"
        source = shots if self._blank else f"{shots}, outside the harmonics"
        return replace(pooled(alike), source=source, tones_hz=_shared_tones(alike))


class KnownNoise(SeriesNoise):
    """Noise that is known from elsewhere: no shot teaches it, and every shot has it."""

    def __init__(self, model: NoiseModel) -> None:
        super().__init__(_pooled=model)

    def learn(self, record: RingDownRecord, *, blank: bool = False, rings_hz: float | None = None) -> None:
        """See SeriesNoise; it knows already."""

    def for_shot(self, record: RingDownRecord) -> ShotNoise:
        """See SeriesNoise."""
        return ShotNoise(self.model, None, 0.0)


def pooled(models: list[NoiseModel]) -> NoiseModel:
    """Average of noise models, every bin weighted by what it rests on; those on another grid are left out."""
    first = models[0]
    grid = first.frequency_hz
    weighted = [
        (m.psd * m.degrees, m.degrees) for m in models if m.degrees is not None and np.array_equal(m.frequency_hz, grid)
    ]
    if len(weighted) < 2:
        return first
    degrees = np.sum([d for _, d in weighted], axis=0)
    total = np.sum([p for p, _ in weighted], axis=0)
    psd = bridge(total / np.maximum(degrees, 1e-300), degrees == 0.0, degrees)
    return replace(first, sd=sd_of(grid, psd), psd=psd, degrees=degrees)


def _noise_of_blank(record: RingDownRecord, rings_hz: float | None) -> NoiseModel:
    """Noise of a shot without excitation, and the steady tones in it; a swing that dies out is neither."""
    block = max(1, int(record.sampling_rate_hz / LIMITS.tone_rate_hz))
    y = record.valid
    means = y[:, : y.shape[1] // block * block].reshape(record.channels, -1, block).mean(axis=2)
    tones = find_tones(means, record.sampling_rate_hz / block, None)
    model = estimate_noise(record, blank=True).without_tones(tones)
    if rings_hz is not None:
        low_hz, high_hz = (1.0 - LIMITS.ringing_slower_share) * rings_hz, (1.0 + LIMITS.ringing_faster_share) * rings_hz
        model = model.without_ringing(low_hz, high_hz)
        # In a short window a swing that dies out slowly looks like a tone.
        swing = Zones(low_hz=low_hz, high_hz=high_hz, margin_hz=record.sampling_rate_hz / y.shape[1])
        tones = np.array([t for t in tones if not swing.holds(t) or is_mains(t, relative=LIMITS.mains_share)])
    return replace(model, tones_hz=tuple(tones.tolist()))


def _shared_tones(models: list[NoiseModel]) -> tuple[float, ...]:
    """Tones of the first blank shot that half of them have."""
    others = [np.array(m.tones_hz) for m in models]
    step_hz = models[0].frequency_hz[1]

    def shared(tone: float) -> bool:
        return 2 * sum(bool(np.any(np.abs(o - tone) < 0.5 * step_hz)) for o in others) >= len(models)

    return tuple(t for t in models[0].tones_hz if shared(t))


def _is_usable(record: RingDownRecord) -> bool:
    """Long enough, and finite."""
    return record.valid.shape[1] >= LIMITS.series_shortest_samples and bool(np.isfinite(record.valid).all())


def _level(record: RingDownRecord) -> Array:
    """Logarithm of the noise level, (channels,), from differences of neighbouring samples in a few stretches."""
    y = record.valid
    begins = np.linspace(0, max(y.shape[1] - LIMITS.level_stretch_samples, 0), LIMITS.level_stretches).astype(int)
    squares = [
        np.mean(np.diff(y[:, b : b + LIMITS.level_stretch_samples], LIMITS.level_differences, axis=1) ** 2, axis=1)
        for b in begins
    ]
    return np.asarray(0.5 * np.log(np.maximum(np.mean(squares, axis=0), 1e-300)))


def _is_unlike(excess: Array, samples: int) -> bool:
    """A level that differs beyond chance, and beyond what would matter, in any channel."""
    # Third differences of white noise are correlated: their mean square scatters like that of n / 2.3 samples.
    chance = math.sqrt(2.3 / (2.0 * min(samples, LIMITS.level_stretch_samples * LIMITS.level_stretches)))
    return bool(np.max(np.abs(excess)) > max(LIMITS.unlike_sigma * chance, LIMITS.unlike_log))
