"""Why a number of ours differs from the paper's, with the arithmetic that follows from the campaign."""

from __future__ import annotations

import math

from scipy import stats

from platform_daemon.design.equations import (
    PAPER_JEWEL,
    PAPER_MAGNETS,
    PRINTED_FRICTION_TORQUE_NM,
    friction_coefficient_of,
)
from platform_daemon.features.characterise.schema import WindowComparison

from .break_even import JEWEL_N50, THREAD_N50, smallest_error_deg
from .findings import Findings, Value
from .paper_number import SHOTS, Because

_PAPER_F_HZ = {
    ("jewel", "n50"): JEWEL_N50["f_nat_hz"],
    ("jewel", "d30"): 213.25,
    ("thread", "n50"): THREAD_N50["f_nat_hz"],
    ("thread", "d30"): 215.69,
}  # tab:model_params_fit_result


def friction(found: Findings, ours: Value) -> str:
    """Of T_f and T_f/I by the design equations."""
    mu = friction_coefficient_of(PRINTED_FRICTION_TORQUE_NM, PAPER_MAGNETS, PAPER_JEWEL)
    printed = PAPER_JEWEL.friction_coefficient
    return f"T_f is proportional to mu; the printed value follows with mu = {mu:.3f}, and {printed:g} is printed"


def residual(found: Findings, ours: Value) -> str:
    """Of R2 and nRMSE."""
    return (
        "R2 = 1 - nRMSE^2: both say how much the model leaves over, which is what acts on the resonator beside it; "
        "when effects were looked for that reproduce the paper's means, the residual was not fitted"
    )


def least(variant: str, window: str) -> Because:
    """Of the least R2."""

    def because(found: Findings, ours: Value) -> str:
        report = found.report(variant)
        made = 0 if report is None else (report.n50 if window == "n50" else report.d30).good
        of = "" if made >= SHOTS else f"; the least of {made} shots lies higher than that of {SHOTS} would"
        return residual(found, ours) + of

    return because


def scatter(variant: str, window: str, name: str) -> Because:
    """Of a deviation from shot to shot: what the fits' own errors make of it, and for how long was measured."""

    def because(found: Findings, ours: Value) -> str:
        report = found.report(variant)
        if report is None:
            return ""
        dataset = report.n50 if window == "n50" else report.d30
        if name == "orientation_error_rad":
            return orientation(variant)(found, ours)
        known = dataset.parameters.get(name)
        said = "" if known is None or known.fit_std is None else f"the fits' own errors are {known.fit_std:.2g} (SI)"
        if known is None or known.shots >= SHOTS:
            return said
        lasts_s, paper_s = (count * report.receive_s for count in (known.shots, SHOTS))
        drift = (
            f"{known.shots} shots take {lasts_s:.0f} s of RX, the paper's {paper_s:.0f} s, and the temperature drifts"
        )
        return "; ".join(filter(None, (said, drift)))

    return because


def phase(variant: str, window: str, paper_deg: float) -> Because:
    """Of the mean of psi_start: an angle is a time between burst and first sample, which the paper does not print."""

    def because(found: Findings, ours: Value) -> str:
        if isinstance(ours.value, str):
            return ""
        f_hz = _PAPER_F_HZ[variant, window]
        apart_s = abs(ours.value - paper_deg) / 360.0 / f_hz
        told = f"{abs(ours.value - paper_deg):.2g} deg are {1e6 * apart_s:.0f} us of {f_hz:g} Hz"
        return f"{told}; when RX begins after the burst is not printed, and neither is the delay of the receiver"

    return because


def orientation(variant: str) -> Because:
    """Of an orientation error."""

    def because(found: Findings, ours: Value) -> str:
        least = smallest_error_deg(variant)
        told = "white noise of 14, 21 and 55 mA m2/s, as the paper has it, allows an unbiased N50 fit no less than "
        told += f"{least:.3f} deg"
        report = found.report(variant)
        error = None if report is None else report.n50.orientation_error_rad
        if error is None:
            return told
        own = math.degrees(error.mean)
        return (
            f"{told}; the measured {variant} has {own:.2g} deg in N50, {own / least:.2g} times as much: what is beyond "
            "noise is its own turning from shot to shot"
        )

    return because


def relative(paper: float) -> Because:
    """Of another mean."""

    def because(found: Findings, ours: Value) -> str:
        if isinstance(ours.value, str):
            return ""
        share = f"{100.0 * abs(ours.value / paper - 1.0):.2g} %"
        return f"{share} of it: the measured resonator has another mean than the paper's"

    return because


def chance_of_as_many(row: WindowComparison) -> float | None:
    """p of the paired t test if the paper's number of shots had the difference and the scatter of these; None: no
    test was made."""
    if row.p_value is None or row.shots < 2:
        return None
    t = float(stats.t.isf(0.5 * row.p_value, row.shots - 1)) * math.sqrt(SHOTS / row.shots)
    return 2.0 * float(stats.t.sf(t, SHOTS - 1))


def significance(variant: str, name: str) -> Because:
    """Of a statement that the means of two windows differ, or do not: what as many shots as in the paper would say."""

    def because(found: Findings, ours: Value) -> str:
        report = found.report(variant)
        row = next((each for each in report.comparisons if each.quantity == name), None) if report else None
        of_all = None if row is None else chance_of_as_many(row)
        if row is None or row.difference is None:
            return ""
        if of_all is None or row.shots >= SHOTS:
            return f"the mean difference is {row.difference:.3g} (SI)"
        return (
            f"the mean difference is {row.difference:.3g} (SI), p = {row.p_value:.2g} of {row.shots} shots; the same "
            f"difference and scatter of {SHOTS} shots would have p = {of_all:.2g}"
        )

    return because


def window(found: Findings, ours: Value) -> str:
    """Of the mean length of the thread's D30."""
    return (
        f"a decay by the printed lambda takes ln(1/0.3) / 0.2465 = {math.log(1.0 / 0.3) / 0.2465:.2f} s for the "
        "deflection; the v signal falls a little sooner, and the paper does not say how it reads the 30 %"
    )


def quality(printed_means: float) -> Because:
    """Of an equivalent Q; printed_means: what eq:tilde-Q gives at the paper's means."""
    return lambda found, ours: f"eq:tilde-Q at the means of tab:model_params_fit_result gives {printed_means:.0f}"


def ratio_v(found: Findings, ours: Value) -> str:
    """Of the v signals: m_r times the largest angular velocity, by eq:dotvarphimax at the paper's means of D30."""
    jewel, thread = (
        m_r * f_hz * math.sqrt(2.0 - 2.0 * math.cos(math.radians(deg)))
        for m_r, f_hz, deg in ((12.028, 213.25, 53.0), (11.014, 215.69, 22.8))
    )
    return (
        f"m_r times eq:dotvarphimax at the means of tab:model_params_fit_result gives {jewel / thread:.2f}, not the "
        "three of the text"
    )
