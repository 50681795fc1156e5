"""The verdict: from what is explained, what is left, and how sure both are."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from scipy.optimize import brentq
from scipy.stats import ncx2

from platform_daemon.diagnosis.effects.additive import SIDE_MODE
from platform_daemon.diagnosis.effects.effect import Candidate
from platform_daemon.diagnosis.effects.kick import KICK
from platform_daemon.diagnosis.regression.cross_validation import CrossValidation
from platform_daemon.diagnosis.regression.joint_fit import JointFit
from platform_daemon.diagnosis.report_schema import DiagnosisVerdict
from platform_daemon.diagnosis.selection.confounders import gain_of
from platform_daemon.diagnosis.selection.data_integrity import DataDefect
from platform_daemon.diagnosis.selection.omnibus_test import OmnibusScore
from platform_daemon.diagnosis.selection.significance import LEVEL
from platform_daemon.diagnosis.selection.stepwise import Selection
from platform_daemon.diagnosis.thresholds import THRESHOLDS
from platform_daemon.estimation.screening.spectral_lines import Zones

from .accepted_effects import AcceptedEffect

_LIMITS = THRESHOLDS.findings


def assess_diagnosis(
    found: Selection,
    final: JointFit,
    named: Sequence[AcceptedEffect],
    gaps: Sequence[DataDefect],
    after: CrossValidation,
) -> tuple[DiagnosisVerdict, tuple[str, ...]]:
    """The verdict, and why an explanation is only a part of one."""
    left = found.omnibus_test
    if not named:
        if _significant(found, final) or found.forbidden or found.best.hypothesis.effects:
            return "unexplained", ()
        return ("explained" if gaps else "nothing_missing"), ()
    explained = _explained(found, final)
    excess = max(left.excess, _noise_excess(final))
    if _significant(found, final) and explained < _LIMITS.confident_share * (explained + excess):
        return "unexplained", ()
    if final.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof and not after.total.nrmse < _LIMITS.followed_nrmse:
        return "unexplained", (f"what was not used is missed by {100.0 * after.total.nrmse:.2g} % all the same",)
    doubts = tuple(_doubts(found, final, named, after))
    return ("partly_explained" if doubts else "explained"), doubts


def _explained(found: Selection, final: JointFit) -> float:
    """Fall of chi^2 that the named effects bring."""
    return max(found.base.chi2 - final.chi2, 0.0) / final.noise_factor


def _noise_excess(final: JointFit) -> float:
    """What is left beyond the measured noise, whatever its form."""
    return (
        (final.chi2 - final.dof) / final.noise_factor
        if final.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof
        else 0.0
    )


def _significant(found: Selection, final: JointFit) -> bool:
    """Something is left that matters."""
    left = found.omnibus_test
    visible = _chance_of_rest(found) < LEVEL and left.excess > _LIMITS.negligible_rest * _explained(found, final)
    return visible or final.chi2_per_dof > THRESHOLDS.regression.noise_chi2_per_dof


def _chance_of_rest(found: Selection) -> float:
    """Logarithm."""
    return math.log(max(found.omnibus_test.p_value, 1e-300))


def _doubts(
    found: Selection, final: JointFit, named: Sequence[AcceptedEffect], after: CrossValidation
) -> Iterator[str]:
    """Why named effects may not be all, or not the right ones."""
    together = [n for n in named if n.candidate in final.hypothesis.common]
    if after.total.dof > 0 and after.total.chi2_per_dof > max(
        _LIMITS.predicted_chi2_per_dof, 1.0 + _LIMITS.predicted_sigma * math.sqrt(2.0 / after.total.dof)
    ):
        yield f"held-out data are predicted to chi2/dof {after.total.chi2_per_dof:.3g} only"
    if _significant(found, final):
        yield "what the named effects leave over is no noise"
    if found.forbidden or final.hypothesis.held_at_zero:
        yield "the best fit asks for signs that physics does not allow"
    if _patched(final, [n.candidate for n in together]):
        yield "one effect only mends what a much larger one does not quite explain"
    # Effects together imitate anything: three of them, or two that others could replace.  Several kicks are one kind of
    # effect, and each is seen at its own instant.
    kicks = sum(n.candidate.effect is KICK for n in together)
    count = len(together) - max(kicks - 1, 0)
    replaceable = any(
        r.candidate.effect is not n.candidate.effect and r.second is None for n in together for r in n.confounders
    )
    if count > _LIMITS.believed_effects or (count > 1 and (replaceable or _chance_of_rest(found) < LEVEL)):
        yield f"{len(together)} effects together may imitate one that has no name here"
    if any(_kind(n.candidate) != _kind(r.candidate) for n in together for r in n.confounders):
        yield "these data cannot tell whether the motion, the receiver or an additive signal is the cause"
    if any(_on_harmonic(n.candidate, final) for n in named if n.candidate.effect is SIDE_MODE):
        yield "a decaying oscillation at a harmonic of the motion may be the motion itself, changed by something else"
    share = _sure_share(found, final)
    if together and share < _LIMITS.sure_share:
        yield f"the evidence is weak: only {100.0 * share:.0f} % of what may be missing is surely explained"


def _patched(final: JointFit, together: Sequence[Candidate]) -> bool:
    """True if an effect gains so little beside another that it may mend it.

    Of a dipole one does not, without which more than noise is left, and beside which only noise is: something is
    missing.  The model of a pendulum is never whole.
    """
    gains = [gain_of(final, c) for c in together]
    if len(gains) < 2 or min(gains) > _LIMITS.patch_share * max(gains):
        return False
    noise = THRESHOLDS.regression.noise_chi2_per_dof
    dipole = final.prepared[0].shot.record.quantity != "angle"
    needed = dipole and final.chi2_per_dof < noise < (final.chi2 + min(gains) * final.noise_factor) / final.dof
    return not needed


def _kind(candidate: Candidate) -> str:
    """Where an effect acts."""
    if candidate.term is not None or candidate.kick_at_s is not None:
        return "motion"
    return "beside" if candidate.additive else "receiver"


def _on_harmonic(mode: Candidate, final: JointFit) -> bool:
    """Within its line width of what a harmonic of the motion sweeps through, in any shot."""
    f_hz, width_hz = mode.detail.frequency_hz or 0.0, 1.0 / (math.pi * (mode.detail.tau_s or math.inf))
    motions = [state.dynamics for state in final.states]
    zones = [Zones.of_sweep(d.w, d.amplitude, relative=0.0, margin_hz=width_hz) for d in motions]
    return any(bool(z.holds(f_hz)) for z in zones)


def _sure_share(found: Selection, final: JointFit) -> float:
    """Of all that may be missing, what is explained; what may be left is an upper limit."""
    explained, left = _explained(found, final), found.omnibus_test
    return explained / (explained + max(_most(left.torque), _most(left.envelopes), 1e-300))


def _most(left: OmnibusScore) -> float:
    """Upper limit of the gain without noise that hides in an observed one."""

    def too_likely(size: float) -> float:
        return float(ncx2.cdf(left.gain, left.directions, size)) - _LIMITS.sure_chance

    if left.directions == 0 or too_likely(0.0) <= 0.0:
        return 0.0
    return float(brentq(too_likely, 0.0, 100.0 + 4.0 * (left.gain + left.directions)))
