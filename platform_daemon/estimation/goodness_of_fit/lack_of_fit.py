"""What the residual says: refusals and warnings about a fit that leaves more than noise.

A small undeclared effect must pass, since diagnosis starts from it; what would spoil the numbers must not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ..noise.level_uncertainty import level_sd
from ..noise.model import NoiseModel
from ..parameters import Estimate
from ..refusal import Refusal, RefusedError
from .compression import Compression
from .flat_tops import FlatTop
from .omitted_component import ParameterShift
from .residual import Residual
from .second_oscillation import SecondOscillation

_WORTH_A_SEARCH = 1e-5  # of the signal's power: what a fit leaves of a companion of the smallest size that matters
_WORTH_A_BEND = 1e-4  # the same for a receiver that compresses
_SMALLEST_COMPANION = 0.03  # of the fitted oscillation
_SMALLEST_SIDE_MODE = 0.003
_LARGEST_MOVES = {"m_r_am2": 0.05, "phi_max_rad": 0.05}  # shares of themselves: errors that a result may not have
_LARGEST_LOSS_MOVE = 0.5
_LARGEST_MISFIT = 0.02  # of the signal's power
APART = 3.0  # periods of the beat with the fitted motion
_LOCKED = 0.3  # the same: a harmonic of the motion itself
_NO_HARMONIC = 0.1  # of the fitted oscillation: more than a small effect can add to a harmonic
_MOSTLY = 0.5  # of the misfit, more than one of a pair of side bands can have
_ALONE = 0.8
_SURE = 5.0  # standard deviations
_STEADY = 0.02  # decay over the window below which a tone is steady
_BURST_SHARE = 0.15  # of the residual's power, in a sixteenth of the window
_BURST_SIGMA = 20.0
_LARGE_CHI2 = 1.1
_BEYOND_CHANCE = 4.0  # standard deviations of chi^2 and of the noise that it is measured with
_TOPS = 12  # block means
_BEYOND = 1.005
_CLEAR = 4.0  # standard deviations of a block mean
_FLAT = 0.2
_BENT = 0.5  # of the misfit
_HARDLY_BENT = 0.3
_MOST_BEND = 1.5  # in linear approximation; nothing bends so far
_LARGEST_BEND = 0.05  # of the signal at its peak: an error that m_r may not have
_WHOLE = 0.99
_CUT_OFF = 0.6  # of the misfit
_PROBABLY = 0.6  # of the misfit, where no fit got through


@dataclass(frozen=True)
class ResidualFindings:
    """What was found in a misfit: a second oscillation, a receiver that compresses, flat tops."""

    second: SecondOscillation | None = None
    bent: Compression | None = None
    clipped: FlatTop | None = None

    @property
    def cut(self) -> FlatTop | None:
        """Flat tops that explain most of the misfit, and more of it than anything else does."""
        others = [one.share for one in (self.second, self.bent) if one is not None]
        return self.clipped if self.clipped is not None and self.clipped.share > max([_CUT_OFF, *others]) else None

    @property
    def may_be_clipped(self) -> bool:
        """Flat tops look much like a compression; a beat that lifts and lowers the tops does not."""
        other = 0.0 if self.second is None else self.second.share
        return self.bent is None or self.bent.share > max(_HARDLY_BENT, other)


def is_worth_a_search(residual: Residual) -> bool:
    """A residual that is not noise, and large enough for a second resonator that would spoil the numbers.

    A strong line may have passed for the noise of the record and its colour.
    """
    coloured = residual.coloured and residual.unexplained > _WORTH_A_SEARCH
    return coloured or residual.line_power > _WORTH_A_SEARCH


def may_be_compressed(residual: Residual) -> bool:
    """Large enough for a receiver that compresses by more than a percent or two."""
    return residual.unexplained > _WORTH_A_BEND


def refuse_lack_of_fit(model_name: str, residual: Residual, found: ResidualFindings) -> None:
    """Refuse a residual above 2 % of the signal's power that no steady tone explains."""
    if not residual.coloured:
        return
    second = found.second
    explained = second.share if second is not None and _is_tone(second) else 0.0
    misfit = residual.unexplained * (1.0 - min(explained, 1.0))
    if misfit > _LARGEST_MISFIT:
        raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, f"{model_name}: {in_words(misfit)} is left over")


def in_words(power: float) -> str:
    """A share of the signal's power."""
    return (
        "as much as the signal itself, or more," if power > _WHOLE else f"{100.0 * power:.2g} % of the signal's power"
    )


def refuse_shape(residual: Residual, found: ResidualFindings) -> None:
    """Refuse flat tops, and a receiver that bends the signal."""
    _refuse_cut(found.cut)
    refuse_compressed(found.bent)
    if residual.coloured and found.may_be_clipped:
        _refuse_clipped(residual)


def refuse_second_oscillation(second: SecondOscillation | None, losses: Sequence[str], frequency_hz: float) -> None:
    """Refuse a second oscillation that is large and decays, or that moves a result by more than it may be wrong.

    One below 3 % of the fitted oscillation is an undeclared effect (a side mode) and passes with a warning, if the fit
    does not move too far when it is taken along: m_r and phi_max by 5 %, a loss by half of itself.
    """
    if second is None or not (_is_resonator(second) or _is_tone(second)):
        return
    limits = {**_LARGEST_MOVES, **dict.fromkeys(losses, _LARGEST_LOSS_MOVE)}
    sure = [m for m in second.moves if m.name in limits and m.is_sure(_SURE) and second.plain_share > _ALONE]
    far = [m for m in sure if abs(m.share) > limits[m.name]]
    if far or (second.relative > _SMALLEST_COMPANION and not _is_tone(second)):
        moved = "".join(f"; beside it {m.name} moves by {100.0 * m.share:+.2g} %" for m in far[:1])
        raise RefusedError(Refusal.TWO_RESONATORS, f"{frequency_hz:.6g} Hz and {_described(second)}{moved}")


def refuse_failed(residual: Residual, found: ResidualFindings, frequency_hz: float) -> None:
    """Name the cause why a fit failed by what a coarse fit of the whole record leaves over, if it shows.

    No numbers are at stake, so that less is asked of a second oscillation than of one that refuses a good fit.
    """
    _refuse_cut(found.cut)
    refuse_compressed(found.bent)
    if found.may_be_clipped:
        _refuse_clipped(residual)
    second = found.second
    if second is not None and second.share > _PROBABLY and second.relative > _SMALLEST_COMPANION:
        raise RefusedError(Refusal.TWO_RESONATORS, f"{frequency_hz:.6g} Hz and {_described(second)}")


def _refuse_cut(cut: FlatTop | None) -> None:
    """Refuse a channel that is without more than a twentieth of its peak."""
    if cut is not None and cut.cut > _LARGEST_BEND:
        raise RefusedError(Refusal.SATURATED, _missing(cut))


def _missing(cut: FlatTop) -> str:
    return f"channel {cut.channel} is clipped at its {cut.side}: {100.0 * cut.cut:.2g} % of the peak are missing"


def refuse_compressed(bent: Compression | None) -> None:
    """Refuse a receiver that bends the signal by more than a twentieth."""
    if bent is not None and bent.share > _BENT and _LARGEST_BEND < bent.at_peak < _MOST_BEND:
        raise RefusedError(Refusal.SATURATED, _bent(bent))


def _bent(bent: Compression) -> str:
    return f"channel {bent.channel} falls {100.0 * bent.at_peak:.2g} % behind the motion at its peak"


def _refuse_clipped(residual: Residual) -> None:
    """Refuse channels that stay at a level wherever the fitted motion goes beyond it.

    Noise that was added after an amplifier has clipped hides the flat tops from a look at single samples. Where a
    receiver merely compresses, its output still rises with the motion.
    """
    for channel, (data, model, sd) in enumerate(zip(residual.data, residual.model, residual.sd, strict=True)):
        size = np.abs(data)
        level = float(np.median(np.sort(size)[-_TOPS:]))
        beyond = np.abs(model) > _BEYOND * level + _CLEAR * sd
        excess = np.abs(model[beyond]) - level
        if np.count_nonzero(beyond) < _TOPS or np.ptp(excess) < _CLEAR * sd:
            continue
        rise = float(np.polyfit(excess, np.sign(model[beyond]) * data[beyond], 1)[0])
        if rise < _FLAT:
            raise RefusedError(Refusal.SATURATED, f"channel {channel} stays at {level:.3g} while the motion goes on")


def _is_resonator(second: SecondOscillation) -> bool:
    """Not steady, not a harmonic of the fitted motion, alone in the residual, and not too faint to be told."""
    if second.relative < _SMALLEST_SIDE_MODE:
        return False
    if second.turns >= APART:
        return second.share > _MOSTLY and not _is_tone(second)
    # Close to a harmonic the misfit of the motion itself looks much the same. At the fundamental that is a sweep or a
    # change of the decay; at others it keeps the phase of the motion, and is small.
    if second.harmonic == 1:
        return second.plain_share > _ALONE
    locked = second.turns < _LOCKED and second.relative < _NO_HARMONIC
    return second.share > _ALONE and not locked


def _is_tone(second: SecondOscillation) -> bool:
    """Beside the harmonics of the motion, and steady as far as can be seen."""
    decays = second.decay_per_s > max(_SURE * second.decay_sd_per_s, _STEADY / second.seconds)
    return second.turns >= APART and second.share > _MOSTLY and not decays


def _described(second: SecondOscillation) -> str:
    """Frequency and size of a second oscillation."""
    return f"{second.frequency_hz:.6g} Hz, with {100.0 * second.relative:.2g} % of the fitted oscillation's size"


def is_large(chi2_per_dof: float, dof: int, noise: NoiseModel) -> bool:
    """More than noise leaves, as well as its level is known."""
    if chi2_per_dof <= _LARGE_CHI2:
        return False
    sd = math.sqrt(2.0 / dof + noise.kept(level_sd) ** 2 / noise.sd.size)
    return math.log(chi2_per_dof) > _BEYOND_CHANCE * sd


def lack_of_fit_warnings(
    residual: Residual, found: ResidualFindings, losses: Mapping[str, Estimate], *, chi2_is_large: bool
) -> tuple[str, ...]:
    """What the residual says about a result that may pass all the same; losses: the fitted ones."""
    if residual.is_rounding:
        return ()
    warnings = []
    second, bent = found.second, found.bent
    if found.cut is not None:
        warnings.append(f"saturated: {_missing(found.cut)}")
    elif bent is not None and bent.share > _BENT and bent.at_peak > 0.0:
        warnings.append(f"saturated: {_bent(bent)}")
    time_s, share, significance = residual.outburst()
    if second is not None and _is_tone(second):
        warnings.append(f"steady_tone: {_described(second)}")
    elif second is not None and _is_resonator(second):
        moved = "".join(_moved(m, losses[m.name]) for m in second.moves if m.name in losses)
        warnings.append(f"side_mode: {_described(second)}{moved}")
    elif share > _BURST_SHARE and significance > _BURST_SIGMA:
        warnings.append(
            f"residual_not_steady: {100.0 * share:.0f} % of it around t = {time_s:.3g} s: a spike, gap, step or switch?"
        )
    if residual.coloured or chi2_is_large:
        warnings.append(
            f"residual_not_white: flatness {residual.flatness.min():.2g}, {in_words(residual.unexplained)} left over"
            f"{_widened(residual)}"
        )
    return tuple(warnings)


def _widened(residual: Residual) -> str:
    """What was done to the errors, if anything."""
    if residual.widening == 1.0:
        return ""
    return f"; errors made {math.sqrt(residual.widening):.2g} times as large, and too small still where it is no noise"


def colour_notes(residual: Residual) -> tuple[str, ...]:
    """What was done to the errors of a fit that leaves nothing but noise."""
    if residual.widening == 1.0 or residual.coloured:
        return ()
    wider = math.sqrt(residual.widening)
    return (f"the noise is {wider:.2g} times as large near the motion as white noise would be; errors follow it",)


def _moved(move: ParameterShift, estimate: Estimate) -> str:
    """By how much a loss moves if the second oscillation is fitted too; nothing if it is held."""
    if estimate.std is None:
        return ""
    return f"; beside it {move.name} is {move.value + move.shift:.3g}, {move.shift / estimate.std:+.2g} of its std away"
