"""What the residual says: refusals and warnings about a fit that leaves more than noise.

A small undeclared effect must pass, since diagnosis starts from it; what would spoil the numbers must not.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from platform_daemon.estimation.noise.model import NoiseModel, level_sd
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.refusal import Refusal, RefusedError
from platform_daemon.estimation.thresholds import THRESHOLDS

from .channel_gains import ChannelGains
from .compression import Compression
from .flat_tops import FlatTop
from .omitted_component import ParameterShift
from .residual import Residual
from .second_oscillation import SecondOscillation

LIMITS = THRESHOLDS.goodness_of_fit


@dataclass(frozen=True)
class ResidualFindings:
    """What was found in a misfit: a second oscillation, a compressing receiver, flat tops, other gains of channels."""

    second: SecondOscillation | None = None
    bent: Compression | None = None
    clipped: FlatTop | None = None
    gains: ChannelGains | None = None

    @property
    def cut(self) -> FlatTop | None:
        """Flat tops that explain most of the misfit, and more of it than anything else does."""
        least = max([LIMITS.cut_off_share, *(one.share for one in (self.second, self.bent) if one is not None)])
        return self.clipped if self.clipped is not None and self.clipped.share > least else None

    @property
    def may_be_clipped(self) -> bool:
        """Flat tops look much like a compression; a beat that lifts and lowers the tops does not."""
        other = 0.0 if self.second is None else self.second.share
        return self.bent is None or self.bent.share > max(LIMITS.hardly_bent_share, other)


def is_worth_a_search(residual: Residual) -> bool:
    """A residual that is not noise, and large enough for a second resonator that would spoil the numbers.

    A strong line may have passed for the noise of the record and its colour.
    """
    coloured = residual.coloured and residual.unexplained > LIMITS.search_share
    return coloured or residual.line_power > LIMITS.search_share


def may_be_compressed(residual: Residual) -> bool:
    """Large enough for a receiver that compresses by more than a percent or two."""
    return residual.unexplained > LIMITS.bend_search_share


def refuse_lack_of_fit(model_name: str, residual: Residual, found: ResidualFindings) -> None:
    """Refuse a residual above 2 % of the signal's power that no steady tone explains."""
    if not residual.coloured:
        return
    second = found.second
    explained = second.share if second is not None and _is_tone(second) else 0.0
    misfit = residual.unexplained * (1.0 - min(explained, 1.0))
    if misfit > LIMITS.misfit_share:
        raise RefusedError(Refusal.MODEL_DOES_NOT_EXPLAIN, f"{model_name}: {power_in_words(misfit)} is left over")


def power_in_words(power: float) -> str:
    """A share of the signal's power."""
    everything = power > LIMITS.everything_share
    return "as much as the signal itself, or more," if everything else f"{100.0 * power:.2g} % of the signal's power"


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
    limits = dict.fromkeys(("m_r_am2", "phi_max_rad"), LIMITS.number_share)
    limits |= dict.fromkeys(losses, LIMITS.loss_share)
    sure = [m for m in second.moves if m.name in limits and m.is_sure(LIMITS.move_sigma)]
    alone = second.plain_share > LIMITS.all_of_misfit
    far = [m for m in sure if alone and abs(m.share) > limits[m.name]]
    if far or (second.relative > LIMITS.companion_share and not _is_tone(second)):
        moved = "".join(f"; beside it {m.name} moves by {100.0 * m.share:+.2g} %" for m in far[:1])
        raise RefusedError(Refusal.TWO_RESONATORS, f"{frequency_hz:.6g} Hz and {_described(second)}{moved}")


def refuse_failed(residual: Residual, found: ResidualFindings, frequency_hz: float) -> None:
    """Name the cause why a fit failed by what a coarse fit of the whole record leaves over, if it shows.

    No numbers are published, so that the limits for a second oscillation are lower than where it refuses a good fit.
    """
    _refuse_cut(found.cut)
    refuse_compressed(found.bent)
    if found.may_be_clipped:
        _refuse_clipped(residual)
    second = found.second
    if second is not None and second.share > LIMITS.probable_share and second.relative > LIMITS.companion_share:
        raise RefusedError(Refusal.TWO_RESONATORS, f"{frequency_hz:.6g} Hz and {_described(second)}")


def _refuse_cut(cut: FlatTop | None) -> None:
    """Refuse a channel that is without more than a twentieth of its peak."""
    if cut is not None and cut.cut > LIMITS.largest_bend_share:
        raise RefusedError(Refusal.SATURATED, _missing(cut))


def _missing(cut: FlatTop) -> str:
    return f"channel {cut.channel} is clipped at its {cut.side}: {100.0 * cut.cut:.2g} % of the peak are missing"


def refuse_compressed(bent: Compression | None) -> None:
    """Refuse a receiver that bends the signal by more than a twentieth."""
    if bent is None or not bent.share > LIMITS.bent_share:
        return
    if LIMITS.largest_bend_share < bent.at_peak < LIMITS.possible_bend_share:
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
        level = float(np.median(np.sort(size)[-LIMITS.clip_means :]))
        beyond = np.abs(model) > LIMITS.clip_level_ratio * level + LIMITS.clip_sigma * sd
        excess = np.abs(model[beyond]) - level
        if np.count_nonzero(beyond) < LIMITS.clip_means or np.ptp(excess) < LIMITS.clip_sigma * sd:
            continue
        rise = float(np.polyfit(excess, np.sign(model[beyond]) * data[beyond], 1)[0])
        if rise < LIMITS.clip_slope:
            raise RefusedError(Refusal.SATURATED, f"channel {channel} stays at {level:.3g} while the motion goes on")


def _is_resonator(second: SecondOscillation) -> bool:
    """Not steady, not a harmonic of the fitted motion, alone in the residual, and not too faint to be named."""
    if second.relative < LIMITS.side_mode_share:
        return False
    if second.turns >= LIMITS.apart_turns:
        return second.share > LIMITS.most_of_misfit and not _is_tone(second)
    # Close to a harmonic the misfit of the motion itself looks much the same. At the fundamental that is a sweep or a
    # change of the decay; at others it keeps the phase of the motion, and is small.
    if second.harmonic == 1:
        return second.plain_share > LIMITS.all_of_misfit
    locked = second.turns < LIMITS.locked_turns and second.relative < LIMITS.harmonic_share
    return second.share > LIMITS.all_of_misfit and not locked


def _is_tone(second: SecondOscillation) -> bool:
    """Between the harmonics of the motion, and steady as far as can be seen."""
    decays = second.decay_per_s > max(LIMITS.decay_sigma * second.decay_sd_per_s, LIMITS.steady_decay / second.seconds)
    return second.turns >= LIMITS.apart_turns and second.share > LIMITS.most_of_misfit and not decays


def _described(second: SecondOscillation) -> str:
    """Frequency and size of a second oscillation."""
    return f"{second.frequency_hz:.6g} Hz, with {100.0 * second.relative:.2g} % of the fitted oscillation's size"


def is_large(chi2_per_dof: float, dof: int, noise: NoiseModel) -> bool:
    """More than noise leaves, as well as its level is known."""
    if chi2_per_dof <= LIMITS.large_chi2_per_dof:
        return False
    sd = math.sqrt(2.0 / dof + noise.kept(level_sd) ** 2 / noise.sd.size)
    return math.log(chi2_per_dof) > LIMITS.large_chi2_sigma * sd


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
    elif bent is not None and bent.share > LIMITS.bent_share and bent.at_peak > 0.0:
        warnings.append(f"saturated: {_bent(bent)}")
    time_s, share, significance = residual.outburst()
    if second is not None and _is_tone(second):
        warnings.append(f"steady_tone: {_described(second)}")
    elif second is not None and _is_resonator(second):
        moved = "".join(_moved(m, losses[m.name]) for m in second.moves if m.name in losses)
        warnings.append(f"side_mode: {_described(second)}{moved}")
    elif found.gains is not None:
        warnings.append(
            f"channel_gains: gains and crosstalk that differ by about {100.0 * found.gains.largest:.2g} % from the "
            f"calibration explain {100.0 * found.gains.share:.0f} % of what is left over; m_r and phi_max may be wrong "
            "by as much or more, the other numbers by more than their errors: is the resonator off centre, or the "
            "calibration of another place or gain?"
        )
    elif share > LIMITS.burst_share and significance > LIMITS.burst_sigma:
        warnings.append(
            f"residual_not_steady: {100.0 * share:.0f} % of it around t = {time_s:.3g} s: a spike, gap, step or switch "
            "there, or a motion that the model does not follow?"
        )
    if residual.coloured or chi2_is_large:
        warnings.append(
            f"residual_not_white: flatness {residual.flatness.min():.2g}, "
            f"{power_in_words(residual.unexplained)} left over{_widened(residual)}"
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
