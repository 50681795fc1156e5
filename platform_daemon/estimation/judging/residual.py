"""What a fit leaves over: its residual as block means in units of the noise, how white it is, and where it stands out.

The noise's own level is not trusted here: what contaminates a record also raises the noise measured beside the
signal. Whiteness compares the residual with itself, bin by bin and stretch by stretch.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from statistics import median

import numpy as np
from scipy.fft import prev_fast_len, rfft

from ..least_squares.gauss_newton import FitState
from ..models import RingDownModel
from ..motion.trajectory import Dynamics, Trajectory
from ..noise.colour import sd_at
from ..noise.model import OF_RECORD, NoiseModel
from ..numerics.arrays import Array, medians
from ..numerics.jit import fast_kernel
from ..numerics.line_search import block_means
from ..passes.workspace import Workspace
from ..record import RingDownRecord
from ..signal.windows import SampleRange
from .floor import POINTS_PER_PERIOD, Floor, floor_of

_POINTS_PER_PERIOD = 12.0  # the band reaches to six times the fundamental: all harmonics that matter
_CHUNK_BLOCKS = 1 << 10
_EULER = 0.57721566490153286  # -mean of the logarithm of an exponentially distributed power
_FLATNESS_SD = math.sqrt(math.pi**2 / 6.0 - 1.0)  # of the logarithm of the flatness, times sqrt(bins)
_SURE_SIGMA = 8.0
_FLAT = 0.9  # noise of unknown colour, drawn in wide bands, is hardly less flat than this
_ROUNDING = 1e-9  # of the signal
_STRETCHES = 16
_OCTAVE_BANDS = 4


@dataclass(frozen=True)
class Residual:
    """Block means of the residual.

    Attributes:
        data, model: (channels, blocks) block means in the record's unit, offsets taken off the data.
        sd: (channels,) standard deviation of the noise of one block mean, were it white.
        rate_hz: blocks per second.
        start_s: middle of the first block.
        noise: its spectrum says what is only colour.
        floor: of an angle: what its residual tells of its own noise, where that can be told.
        widening: so many times the variances that the noise explains, by what the floor shows.
    """

    data: Array
    model: Array
    sd: Array
    rate_hz: float
    start_s: float
    noise: NoiseModel
    floor: Floor | None = None
    widening: float = 1.0

    @cached_property
    def scaled(self) -> Array:
        """Residual over noise, (channels, blocks)."""
        return np.asarray((self.data - self.model) / self.sd[:, None])

    def beginning(self, n: int) -> Residual:
        """The first n blocks."""
        return replace(self, data=self.data[:, :n], model=self.model[:, :n])

    @property
    def transformed(self) -> Array:
        """As much of `scaled` as the spectrum was made from, (channels, n)."""
        return self.scaled[:, : self._length]

    @property
    def _length(self) -> int:
        """Blocks that a fast transform takes."""
        return int(prev_fast_len(self.data.shape[1], real=True))

    @cached_property
    def _seen(self) -> tuple[Array, Array, Array]:
        """Power of the residual and the same over the density of the noise, (channels, bins); flatness (channels,)."""
        n = self._length
        bins = rfft(self.transformed, axis=1)[:, 1 : (n + 1) // 2]
        out = np.empty(bins.shape), np.empty(bins.shape), np.empty(bins.shape[0])
        _look(bins, 1.0 / n, self._colour, *out)
        return out

    @property
    def _power(self) -> Array:
        return self._seen[0]

    @property
    def spectrum(self) -> Array:
        """Power of the residual over the density of the noise, (channels, bins), without the bin of the offset."""
        return self._seen[1]

    @property
    def flatness(self) -> Array:
        """Spectral flatness per channel, (channels,): geometric over arithmetic mean of the power; noise only: 1."""
        return self._seen[2]

    @cached_property
    def _colour(self) -> Array:
        return self.noise.kept(_colour, self._length, self.rate_hz)

    @property
    def colour_sigma(self) -> float:
        """By how many standard deviations the least flat channel departs from white."""
        bins = self.spectrum.shape[1]
        return -math.log(max(self.flatness.min(), 1e-300)) * math.sqrt(bins) / _FLATNESS_SD

    @cached_property
    def unexplained(self) -> float:
        """Power left over beyond the median level of the residual's spectrum, relative to the model's power.

        Of an angle: beyond its floor, for there are few bins between the harmonics.
        """
        if self.floor is not None:
            floor = (self.floor.sd(self.rate_hz) / self.sd) ** 2
        else:
            floor = medians(self.spectrum) / math.log(2.0) * self._colour.mean(axis=1)
        excess = np.maximum(self._power.mean(axis=1) - floor, 0.0) * self.sd**2
        return float(excess.sum() / max(np.mean(self.model**2, axis=1).sum(), 1e-300))

    @property
    def is_rounding(self) -> bool:
        """True if so little is left over that it is the digits of the motion, and says nothing."""
        left = self.data - self.model
        return float(np.vdot(left, left)) < _ROUNDING**2 * float(np.vdot(self.model, self.model))

    @property
    def surplus(self) -> float:
        """Power beyond the noise, summed over the channels, in units of the noise."""
        return float(np.sum(np.mean(self.scaled**2, axis=1) - 1.0))

    @cached_property
    def coloured(self) -> bool:
        """True if a channel's residual is beyond doubt not white, whatever its level."""
        if self.floor is not None and (self.floor.sure or self.noise.source in OF_RECORD):
            # Beside few harmonics the colour of an angle's noise is not known.
            return self.floor.sure and not self.is_rounding
        return self.colour_sigma > _SURE_SIGMA and float(self.flatness.min()) < _FLAT

    def outburst(self) -> tuple[float, float, float]:
        """(time in s, share of all power, significance in sd) of the stretch that stands out most."""
        length = max(1, self.scaled.shape[1] // _STRETCHES)
        count = self.scaled.shape[1] // length
        pieces = self.scaled[:, : count * length].reshape(-1, count, length)
        powers = np.einsum("ckl,ckl->k", pieces, pieces).tolist()
        largest, usual = max(powers), max(median(powers), 1e-300)
        sd = usual * math.sqrt(2.0 / (length * self.scaled.shape[0]))
        middle = self.start_s + (powers.index(largest) + 0.5) * length / self.rate_hz
        return middle, largest / sum(powers), (largest - usual) / sd


@fast_kernel
def _look(bins, share, colour, power, spectrum, flatness):  # type: ignore[no-untyped-def]
    """Write what Residual._seen holds, from complex bins (channels, m); colour (channels, m), or (channels, 1)."""
    m = bins.shape[1]
    for channel in range(bins.shape[0]):
        total = logarithms = 0.0
        for i in range(m):
            here = bins[channel, i]
            power[channel, i] = share * (here.real * here.real + here.imag * here.imag)
            spectrum[channel, i] = power[channel, i] / colour[channel, min(i, colour.shape[1] - 1)]
            total += spectrum[channel, i]
            logarithms += math.log(max(spectrum[channel, i], 1e-300))
        flatness[channel] = math.exp(logarithms / m + _EULER) / max(total / m, 1e-300)


def _colour(noise: NoiseModel, length: int, rate_hz: float) -> Array:
    """Density of the noise in wide bands, (channels, bins), up to a factor per channel: lines do not count.

    length: of the transform, whose bin of the offset is left out.
    """
    if noise.frequency_hz.size <= 2:
        return np.ones((noise.psd.shape[0], 1))
    centres, levels = noise.kept(_bands)
    frequency_hz = np.arange(1, (length + 1) // 2) * rate_hz / length
    smooth = np.stack([np.interp(frequency_hz, centres, row) for row in levels])
    return np.asarray(np.exp(smooth - smooth.mean(axis=1, keepdims=True)))


def _bands(noise: NoiseModel) -> tuple[Array, Array]:
    """Middles (m,) in Hz of wide bands and the mean logarithm of the density in them, (channels, m)."""
    grid, psd = noise.frequency_hz, noise.psd
    octaves = max(1.0, math.log2(grid.size / 8.0))
    edges = np.unique(np.geomspace(8, grid.size, int(_OCTAVE_BANDS * octaves)).astype(int)[:-1])
    edges = np.concatenate([[0], edges[edges < grid.size]])
    counts = np.diff(np.append(edges, grid.size))
    levels = np.add.reduceat(np.log(np.maximum(psd, 1e-300)), edges, axis=1) / counts
    return np.add.reduceat(grid, edges) / counts, levels


def residual_of(
    record: RingDownRecord,
    workspace: Workspace,
    state: FitState,
    chosen: SampleRange,
    noise: NoiseModel,
    noise_sd: Array,
) -> Residual:
    """The residual of a fitted state over its window; noise_sd (channels,) of single samples."""
    block = _block(record, state, _POINTS_PER_PERIOD)
    sd = noise_sd / math.sqrt(block)
    data, model = _means(record, workspace, state, chosen, block, sd)
    floor = _floor(record, workspace, state, chosen) if record.quantity == "angle" else None
    return Residual(
        data=data - state.offsets[:, None],
        model=model,
        sd=sd,
        rate_hz=record.sampling_rate_hz / block,
        start_s=(chosen.first + 0.5 * (block - 1)) * record.dt_s,
        noise=noise,
        floor=floor,
        widening=1.0 if floor is None else _widening(floor, state, noise, noise_sd, record.sampling_rate_hz),
    )


def _block(record: RingDownRecord, state: FitState, points: float) -> int:
    """Samples in a block, of which there are so many in a period or a few more."""
    return max(1, int(record.sampling_rate_hz / _frequency_hz(state) / points))


def _means(
    record: RingDownRecord, workspace: Workspace, state: FitState, chosen: SampleRange, block: int, sd: Array
) -> tuple[Array, Array]:
    """Block means of the samples and of the fitted signal, (channels, blocks) each; sd (channels,): digits wanted."""
    blocks = (chosen.last - chosen.first) // block
    data = block_means(record.samples, chosen.first, block, blocks)
    gains = state.observation.gains(state.dynamics.w)
    at = state.dynamics, chosen.first, blocks, block, record.dt_s, state.observation.observable
    if state.dynamics.theta >= 0.0 and not workspace.model.time_dependent:
        largest = abs(state.dynamics.amplitude) * float((np.abs(gains).max(axis=1) / sd).max())
        return data, gains @ workspace.block_means(*at, 1.0 / max(largest, 1.0))
    # The tables know nothing of time, nor of what was before their first turning point.
    return data, gains @ _integrated(workspace.model, *at)


def _widening(floor: Floor, state: FitState, noise: NoiseModel, noise_sd: Array, rate_hz: float) -> float:
    """By how much the variances of an angle's fit are too small; the fit weighs with the noise at the fundamental."""
    sd = max(float(sd_at(noise, np.array([_frequency_hz(state)]), rate_hz)[0, 0]), float(noise_sd[0]))
    return floor.widening(sd, rate_hz)


def _frequency_hz(state: FitState) -> float:
    """Natural frequency."""
    return 0.5 * state.dynamics.w / math.pi


def _floor(record: RingDownRecord, workspace: Workspace, state: FitState, chosen: SampleRange) -> Floor | None:
    """What the residual of an angle tells of its noise."""
    block = _block(record, state, POINTS_PER_PERIOD)
    data, model = _means(record, workspace, state, chosen, block, np.full(1, 1e-9 * abs(state.dynamics.amplitude)))
    n = int(prev_fast_len(data.shape[1], real=True))
    return floor_of((data - model)[0, :n], record.sampling_rate_hz / block, _frequency_hz(state))


def _integrated(
    model: RingDownModel, dynamics: Dynamics, first: int, blocks: int, block: int, dt_s: float, observable: int
) -> Array:
    """Block means (2, blocks) of the directly integrated motion, a stretch at a time."""
    trajectory = Trajectory(model, dynamics, (first + blocks * block) * dt_s)
    out = np.empty((2, blocks))
    for begin in range(0, blocks, _CHUNK_BLOCKS):
        end = min(begin + _CHUNK_BLOCKS, blocks)
        basis = trajectory.basis(first + begin * block, first + end * block, dt_s, observable)
        out[:, begin:end] = basis[:2].reshape(2, end - begin, block).mean(axis=2)
    return out
