"""N50 fits of recorded shots with white noise added: the part that workers do."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError
from platform_daemon.estimation.fit import fit_ring_down
from platform_daemon.estimation.noise.model import NoiseModel, estimate_noise
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.thresholds import THRESHOLDS
from platform_daemon.features.fit.batch.part import InputFile, opened
from platform_daemon.features.fit.fit_request import FitSettings

from .noise_schema import NoiseDraw, NoisePart

_MARGIN_S = 0.01  # beyond N50, so that the window is not the last of the record
_KNOWN = 0.02  # so well the noise of a record is known: a level so little below its own counts as its own


@dataclass(frozen=True)
class NoisyShots:
    """Some shots of one specimen at every level: a part of a sweep.

    Attributes:
        source: the recording; settings: of its N50 fits, with these frames.
        levels: mean over the channels of the standard deviation of a sample, A m^2/s.
        draws: of noise for each shot and level; seed: the noise follows from seed, specimen, frame, level and draw, so
            that it does not depend on who makes which part.
        specimen: its number among those that are compared.
    """

    source: InputFile
    settings: FitSettings
    levels: tuple[float, ...]
    draws: int
    seed: int
    specimen: int


def fit_noisy_shots(part: NoisyShots) -> NoisePart:
    """Every shot at every level in every draw.  Raises PlatformError for a frame that cannot be read."""
    found: list[NoiseDraw] = []
    with opened(part.source, part.settings) as (measurement, ask):
        series = measurement.noise()
        for k in part.settings.frames or ():
            record = measurement.signal(k).record
            known = series.for_shot(record).model or estimate_noise(record)
            short = _first_part(record)
            for level, wanted in enumerate(part.levels):
                added = added_sd(known.sd, wanted)
                noise = _with_white(known, added, record.sampling_rate_hz)
                for draw in range(part.draws):
                    rng = np.random.default_rng([part.seed, part.specimen, k, level, draw])
                    noisy = replace(short, samples=short.samples + added * rng.standard_normal(short.samples.shape))
                    fit = fit_ring_down(noisy, ask.ring_down_model, "n50", noise=noise, fixed=ask.fixed)
                    values = {name: estimate.value for name, estimate in fit.parameters.items()}
                    good = "f_nat_hz" in values and RODRIGUES[0] in values
                    found.append(
                        NoiseDraw(
                            frame=k,
                            level=level,
                            f_nat_hz=values["f_nat_hz"] if good else None,
                            rodrigues_rad=tuple(values[name] for name in RODRIGUES) if good else None,
                        )
                    )
    return NoisePart(specimen=part.specimen, fits=tuple(found))


def own_noise(source: InputFile, settings: FitSettings) -> tuple[NDArray[np.float64], float]:
    """(standard deviation of a sample per channel, A m^2/s, of the noisiest shot; sampling rate, Hz)."""
    with opened(source, settings) as (measurement, _):
        series = measurement.noise()
        known = []
        for k in settings.frames or ():
            record = measurement.signal(k).record
            known.append((series.for_shot(record).model or estimate_noise(record)).sd)
    return max(known, key=lambda sd: float(np.mean(sd))), record.sampling_rate_hz


def added_sd(own: NDArray[np.float64], level: float) -> float:
    """Standard deviation of the noise that must be added to every channel, so that the mean over them is `level`.

    The paper's level of 30 mA m^2/s is the mean over the channels of 14, 21 and 55 mA m^2/s (fig:noise_plot).  Raises
    InputError below the own level.
    """
    from scipy.optimize import brentq

    def excess(added: float) -> float:
        return float(np.mean(np.hypot(own, added))) - level

    if excess(0.0) > _KNOWN * level:
        what = f"the record's own noise of {np.mean(own):.4g} A m2/s is above {level:.4g} A m2/s"
        raise InputError(what, where="noise", remedy=f"begin at {_above(float(np.mean(own))):g} A m2/s or more")
    return 0.0 if excess(0.0) >= 0.0 else float(brentq(excess, 0.0, level * math.sqrt(own.size) + 1.0))


def _above(level: float) -> float:
    """The next number above with two digits."""
    step = 10.0 ** (math.floor(math.log10(level)) - 1)
    return math.ceil(level / step) * step


def _first_part(record: RingDownRecord) -> RingDownRecord:
    count = record.valid_from + math.ceil((THRESHOLDS.screening.n50_s + _MARGIN_S) * record.sampling_rate_hz)
    last = min(count, record.end)
    return replace(record, samples=record.samples[:, :last], valid_to=last)


def _with_white(known: NoiseModel, added: float, rate_hz: float) -> NoiseModel:
    return replace(known, sd=np.hypot(known.sd, added), psd=known.psd + 2.0 * added**2 / rate_hz)
