"""One record: truth, noise, quantisation, lost samples, and its file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from tests.campaigns.angle_study.cases import Draw, drawn
from tests.campaigns.angle_study.motion import PLACE, Array, reading, vector
from tests.campaigns.angle_study.peer import DECLARED, fitted, held_out_error, rms
from tests.campaigns.angle_study.truth import true_reading

_DENSE = 24.0  # samples of a period that tell a smooth misfit
_CLOSE, _ROUNDS, _LEAP = 0.05, 10, 30.0
_NEAR_PERIODS = 3.0
_DRAWS = 6


@dataclass(frozen=True)
class Record:
    """A record and what is true of it.

    Attributes:
        draw: how it was drawn.
        motion: with its strengths.
        sigma: visibility in units of the noise, as the study has it; seen_sigma: the same if the errors of neighbouring
            samples, which the quantisation makes alike, are counted as they are.
        angle: as read, (n,); own_times: when it was read, s, without the gaps that the time column hides.
        gap_sigmas: visibility of each gap in the whole record and within a few periods.
        rests_s: from when on it rests.
        differ: rms difference of the two integrators over the noise, times the root of the samples.
    """

    draw: Draw
    motion: dict[str, float]
    sigma: float
    seen_sigma: float
    angle: Array
    own_times: Array
    gap_sigmas: tuple[tuple[float, float], ...]
    rests_s: float
    differ: float

    @property
    def gaps(self) -> list[tuple[int, int]]:
        """(first sample of the file after it, samples lost)."""
        found, lost = [], 0
        for first, count in self.draw.gaps:
            found.append((first - lost, count))
            lost += count
        return found


def record_of(seed: int, index: int) -> Record:
    """Record number `index` of this seed: of several draws the first in which the effect can be seen."""
    for again in range(_DRAWS):
        draw = drawn(seed, index, again)
        motion, sigma = _strong_enough(draw)
        if not draw.case.strengths or sigma > (1.0 - 2.0 * _CLOSE) * draw.sigma:
            break
    return _made(draw, motion, sigma)


def _made(draw: Draw, motion: dict[str, float], sigma: float) -> Record:
    own = np.arange(draw.samples + sum(count for _, count in draw.gaps))
    keep = np.ones(own.size, bool)
    for first, count in draw.gaps:
        keep[first : first + count] = False
    times = own / draw.rate_hz
    true, rests_s = true_reading(times, motion)
    differ = rms(reading(times, vector(motion)) - true) / draw.sd * math.sqrt(true.size)
    rng = np.random.default_rng([draw.seed, draw.index, draw.again, 1])
    read = true[keep] + draw.white_rad * rng.standard_normal(int(keep.sum()))
    angle = draw.quantum_rad * np.round(read / draw.quantum_rad)
    more = _alike(angle - true[keep], draw)
    visible = tuple(_gap_visible(draw, motion, k) for k in range(len(draw.gaps)))
    if draw.case.gaps and not draw.case.strengths:
        sigma = max(whole for whole, _ in visible)
    return Record(draw, motion, sigma, sigma / more, angle, times[keep], visible, rests_s, differ)


def _strong_enough(draw: Draw) -> tuple[dict[str, float], float]:
    """(the motion with its strengths, visibility): as near the wanted one as the largest strength allows."""
    case, share = draw.case, 1.0
    if case.stuck:
        motion = draw.motion | draw.largest
        return motion, visibility(draw, motion)
    if not case.strengths:
        return dict(draw.motion), 0.0
    share, seen, last = 1e-3, 0.0, None
    for _ in range(_ROUNDS):
        motion = draw.motion | {name: share * size for name, size in draw.largest.items()}
        seen = visibility(draw, motion)
        if abs(seen / draw.sigma - 1.0) < _CLOSE or (share == 1.0 and seen < draw.sigma):
            break
        power = 1.0
        if last is not None and seen > 0.0 and last[1] > 0.0 and share != last[0]:
            power = float(np.clip(math.log(seen / last[1]) / math.log(share / last[0]), 0.5, 2.0))
        last = share, seen
        factor = (draw.sigma / max(seen, 1e-6)) ** (1.0 / power)
        share = min(1.0, share * float(np.clip(factor, 1.0 / _LEAP, _LEAP)))
    return motion, seen


def visibility(draw: Draw, motion: dict[str, float]) -> float:
    """Root of the fall of chi^2 from the best fit without the effect to the truth; the least, where there are two."""
    return min(misfit(draw, motion, kept, kept) for kept in draw.case.kept)


def misfit(draw: Draw, motion: dict[str, float], free: tuple[str, ...], kept: tuple[str, ...]) -> float:
    """Root of the fall of chi^2 from the best fit with these effects to the truth.  kept: fitted from the truth on."""
    step = max(1, int(draw.rate_hz / (_DENSE * draw.motion["f_hz"])))
    times = np.arange(0, draw.samples, step) / draw.rate_hz
    true = reading(times, vector(motion))
    begin = vector({n: q for n, q in motion.items() if n not in draw.largest or n in kept} | _without_shape(draw))
    best = fitted(times, true, begin, (*DECLARED, *free), draw.sd)
    return rms(reading(times, best) - true) / draw.sd * math.sqrt(times.size * step)


def _without_shape(draw: Draw) -> dict[str, float]:
    """Shape parameters that mean nothing without the effect."""
    return dict.fromkeys(draw.case.shape, 0.0)


def _gap_visible(draw: Draw, motion: dict[str, float], k: int) -> tuple[float, float]:
    """Visibility of one gap alone: in the whole record, and within a few periods around it."""
    first, count = draw.gaps[k]
    own = np.arange(draw.samples + count)
    own = own[(own < first) | (own >= first + count)]
    true, p = reading(own / draw.rate_hz, vector(motion)), vector(motion)
    step = max(1, int(draw.rate_hz / (_DENSE * draw.motion["f_hz"])))
    even = np.arange(own.size) / draw.rate_hz
    best = fitted(even[::step], true[::step], p, DECLARED, draw.sd)
    whole = rms(reading(even[::step], best) - true[::step]) / draw.sd * math.sqrt(own.size)
    reach = int(_NEAR_PERIODS * draw.rate_hz / draw.motion["f_hz"])
    near = slice(max(0, first - reach), first + reach)
    # Near it the motion is as if it began there: angle and velocity are taken from the trajectory.
    begin, h = p.copy(), 1e-5
    t0 = own[near.start] / draw.rate_hz
    around = reading(np.array([max(t0 - h, 0.0), t0, t0 + h]), p) - p[PLACE["offset"]]
    begin[PLACE["phi"]], begin[PLACE["v"]] = around[1], (around[2] - around[0]) / (t0 + h - max(t0 - h, 0.0))
    local = even[near] - even[near.start]
    best = fitted(local, true[near], begin, DECLARED, draw.sd)
    return whole, rms(reading(local, best) - true[near]) / draw.sd * math.sqrt(local.size)


def _alike(errors: Array, draw: Draw) -> float:
    """Root of the power of the errors near and below the motion's frequency over that of white ones, at least 1."""
    spectrum = np.abs(np.fft.rfft(errors)) ** 2 / errors.size
    hz = np.fft.rfftfreq(errors.size, 1.0 / draw.rate_hz)
    near = (hz > 0.3 * draw.motion["f_hz"]) & (hz < 1.5 * draw.motion["f_hz"])
    return max(1.0, math.sqrt(float(np.mean(spectrum[near]))) / draw.sd) if near.any() else 1.0


def written(record: Record, path: Path) -> Path:
    """The record as a file."""
    return write_angle(path, np.arange(record.angle.size) / record.draw.rate_hz, record.angle)


def write_angle(path: Path, time_s: Array, angle: Array, units: str = "rad") -> Path:
    """A file of one angle, or of several, (channel, n)."""
    with h5py.File(path, "w") as file:
        file["time"] = time_s
        file["time"].attrs["units"] = "s"
        file["signal"] = np.atleast_2d(angle)
        file["signal"].attrs["units"] = units
        file.attrs["quantity"] = "angle"
        file.attrs["units"] = units
        file.attrs["source"] = "synthetic, scipy"
    return path


def speaks_against(record: Record, names: tuple[str, ...]) -> float | None:
    """Visibility of what the best fit with these effects leaves; None if a name has no counterpart here."""
    draw = record.draw
    if draw.gaps or draw.case.stuck or not set(names) <= set(_PARAMETERS):
        return None
    free = tuple(dict.fromkeys(_PARAMETERS[name] for name in names))
    return misfit(draw, record.motion, free, kept=())


_PARAMETERS = {
    "coulomb_friction": "coulomb",
    "quadratic_drag": "quadratic",
    "angle_dependent_damping": "angle_damping",
    "restoring_anharmonicity": "cubic",
    "torsion_stiffness": "cubic",
    "bias_torque": "bias",
    "frequency_drift": "drift",
}


def least_error(record: Record, split: float) -> float:
    """Held-out error of the true model, which knows where samples are lost."""
    p, shape = vector(record.motion), [n for n in record.draw.case.shape if record.motion[n] > 0.0]
    free = (*DECLARED, *record.draw.case.strengths, *shape)
    return held_out_error(record.own_times, record.angle, p, free, record.draw.sd, split)
