"""Every number of the paper that is compared, by its LaTeX label, with where ours comes from.

Nothing of ours stands here: each is computed from the design equations, the statics of a defect, or the fits.
The paper's means are over 100 shots, so that their standard error is a tenth of the standard deviation it prints.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import partial

from drivers.specimen import JewelBearing, Magnets
from platform_daemon.design.equations import PAPER_JEWEL, PAPER_MAGNETS, design_numbers, friction_increase
from platform_daemon.features.characterise.schema import FitDataset, QualityFactors, ShotStatistics

from . import reasons
from .break_even import PRINTED_BREAK_EVEN_AM2_PER_S, break_even_text
from .findings import Findings, Value, lowest_of, mean_of, median_of, scatter_of
from .paper_defects import defect_numbers
from .paper_number import CHARACTERISE, DESIGN, NOISE, SHOTS, Because, Ours, PaperNumber, printed, says, statement
from .printed_means import quality_of_the_means


def paper_numbers() -> Iterator[PaperNumber]:
    """All of them, in the order of the paper."""
    yield from _friction_in_a_cup()
    yield from defect_numbers()
    yield from _design()
    for variant in ("jewel", "thread"):
        yield from _measurement(variant)
    for variant, window in ((v, w) for v in ("jewel", "thread") for w in ("n50", "d30")):
        yield from _fit_quality(variant, window)
    for variant in ("jewel", "thread"):
        yield _visual_agreement(variant)
    for variant, window in ((v, w) for v in ("jewel", "thread") for w in ("n50", "d30")):
        yield from _parameters(variant, window)
    for variant in ("jewel", "thread"):
        yield from _significance(variant)
    yield from _windows()
    yield from _quality_factors()
    yield from _signals()
    yield from _noise()
    yield from _manufacturing()


def _friction_in_a_cup() -> Iterator[PaperNumber]:
    for k, paper in ((2.0, 1.26), (4.0, 1.10)):
        yield printed(
            "fig:simulation_lambda(t)",
            f"Lambda({k:g})",
            paper,
            partial(_lambda, k),
            2,
            DESIGN,
        )


def _lambda(ratio: float, found: Findings) -> Value:
    return Value(friction_increase(ratio))


def _design() -> Iterator[PaperNumber]:
    """Numbers of the design equations: LaTeX label, name, the paper's number, ours, printed decimals, command."""
    yield printed("eq:m_r", "m_r / mAm2", 14.6, lambda found: Value(1e3 * found.design.m_r_am2), 1, DESIGN)
    yield printed("eq:fnat", "f_nat / Hz", 229.3, lambda found: Value(found.design.f_nat_hz), 1, DESIGN)
    yield printed("eq:fm(phi)", "F_m / mN", 131.5, lambda found: Value(1e3 * found.design.f_m_n), 1, DESIGN)
    yield printed(
        "eq:tf(phi)",
        "T_f / nNm, with the printed mu = 0.15",
        115.9,
        lambda found: Value(1e9 * found.friction.friction_torque_nm),
        1,
        DESIGN,
        because=reasons.friction,
    )
    yield printed(
        "eq:TfoverI",
        "T_f/I / rad s-2, with the printed mu = 0.15",
        1168.0,
        lambda found: Value(found.friction.friction_rad_per_s2),
        0,
        DESIGN,
        because=reasons.friction,
    )
    yield PaperNumber(
        "sup:proof_size_independence",
        "Q at a tenth of the size over Q at full size",
        1.0,
        1e-9,
        "rounding",
        _size_independence,
        DESIGN,
    )


def _size_independence(found: Findings) -> Value:
    m, j = PAPER_MAGNETS, PAPER_JEWEL
    keys = m.model_dump() | {"radius_m": 0.1 * m.radius_m, "distance_m": 0.1 * m.distance_m}
    cup = JewelBearing(**(j.model_dump() | {"cup_radius_m": 0.1 * j.cup_radius_m}))
    small = design_numbers(Magnets(**keys), cup).friction
    assert small is not None
    assert small.quality_factor_per_rad is not None
    assert found.friction.quality_factor_per_rad is not None
    return Value(small.quality_factor_per_rad / found.friction.quality_factor_per_rad)


def _measurement(variant: str) -> Iterator[PaperNumber]:
    paper = {"jewel": (212.0, 0.047, 490.0, 2.0, 610.0), "thread": (212.0, 0.047, 215.0, 15.0, 270.0)}[variant]

    def of(key: int, found: Findings) -> Value | None:
        report = found.report(variant)
        if report is None or report.excitation is None:
            return None
        made = report.excitation
        told = (made.requested_hz, made.periods / made.realised_hz, 1e6 * made.field_t, report.receive_s)
        return Value(told[key])

    def highest(found: Findings) -> Value | None:
        outcome = found.outcomes.get(variant)
        ramp = None if outcome is None else outcome.ramp
        if ramp is None or ramp.max_field_t is None:
            return None
        known = ramp.threshold_t  # its 95 % interval is four standard errors long
        return Value(1e6 * ramp.max_field_t, None if known is None else 1e6 * (known.high - known.low) / 4.0)

    def none_found(found: Findings) -> str:
        outcome = found.outcomes.get(variant)
        ramp = None if outcome is None else outcome.ramp
        if ramp is None or ramp.highest_field_t is None:
            return "no ramp was made in this campaign"
        return f"its ramp has found no side modes up to {1e6 * ramp.highest_field_t:.4g} uT"

    label = "tab:measurement_parameter"
    yield printed(label, f"{variant}: f_TX / Hz", paper[0], partial(of, 0), 0, CHARACTERISE)
    yield printed(label, f"{variant}: t_TX / s", paper[1], partial(of, 1), 3, CHARACTERISE)
    yield printed(label, f"{variant}: B_TX / uT", paper[2], partial(of, 2), 0, CHARACTERISE, 10.0)
    yield printed(label, f"{variant}: t_RX / s", paper[3], partial(of, 3), 1, CHARACTERISE)
    step = "the paper's steps of 10 uT"
    what = f"{variant}: B_max / uT"
    yield PaperNumber(
        "ssec:measurement_sequence", what, paper[4], 10.0, step, highest, CHARACTERISE, missing=none_found
    )


def _of_window(
    variant: str, window: str, pick: Callable[[FitDataset], ShotStatistics | None],
    take: Callable[[ShotStatistics | None, float], Value | None], factor: float,
) -> Ours:  # fmt: skip
    def ours(found: Findings) -> Value | None:
        report = found.report(variant)
        return None if report is None else take(pick(report.n50 if window == "n50" else report.d30), factor)

    return ours


def _fit_quality(variant: str, window: str) -> Iterator[PaperNumber]:
    r2, least, nrmse, seconds = {
        ("jewel", "n50"): (99.98, 99.76, 1.38, 129.0),
        ("jewel", "d30"): (99.81, 95.53, 4.39, 1346.0),
        ("thread", "n50"): (99.98, 99.97, 1.42, 3.0),
        ("thread", "d30"): (99.89, 99.88, 3.33, 49.0),
    }[variant, window]
    label, name = "tab:fit_results_quality", f"{variant} {window.upper()}"
    of = partial(_of_window, variant, window)
    for what, paper, ours, because in (
        ("median R2", r2, of(lambda d: d.r2, median_of, 100.0), reasons.residual),
        ("least R2", least, of(lambda d: d.r2, lowest_of, 100.0), reasons.least(variant, window)),
        ("median nRMSE", nrmse, of(lambda d: d.nrmse, median_of, 100.0), reasons.residual),
    ):
        yield printed(label, f"{name}: {what} / %", paper, ours, 2, CHARACTERISE, because=because)
    yield PaperNumber(
        label,
        f"{name}: median time of a fit / s",
        seconds,
        None,
        "",
        of(lambda d: d.computing_s, median_of, 1.0),
        CHARACTERISE,
        "a time of computing belongs to a computer and a solver, not to the resonator",
    )


def _visual_agreement(variant: str) -> PaperNumber:
    """Of the fits that fig:fit_plot shows, as the discussion has it."""

    def ours(found: Findings) -> Value | None:
        report = found.report(variant)
        return None if report is None or report.d30.r2 is None else says(report.d30.r2.median > _HIGH_R2)

    what = f"{variant}: median R2 of the D30 fits is above {100.0 * _HIGH_R2:g} %"
    return statement("fig:fit_plot", what, "yes", ours, CHARACTERISE, because=reasons.residual)


_HIGH_R2 = 0.998  # sec:discussion
_PARAMETERS = {  # public name: symbol with the unit shown, factor to it
    "f_nat_hz": ("f_nat / Hz", 1.0),
    "orientation_error_rad": ("orientation error / deg", math.degrees(1.0)),
    "m_r_am2": ("m_r / mAm2", 1e3),
    "lambda_per_s": ("lambda / s-1", 1.0),
    "tf_over_i_rad_per_s2": ("T_f/I / rad s-2", 1.0),
    "phi_max_rad": ("phi_max / deg", math.degrees(1.0)),
    "psi_start_rad": ("psi_start / deg", math.degrees(1.0)),
}
_FITTED: dict[tuple[str, str], tuple[tuple[float, float] | None, ...]] = {  # (mean, deviation), in that order
    ("jewel", "n50"): ((212.93, 0.13), (0.132, 0.084), (12.262, 0.014), None, (1063, 377), (52.4, 0.5), (219.1, 2.4)),
    ("jewel", "d30"): (
        (213.25, 0.19), (0.079, 0.055), (12.028, 0.143), (0.0978, 0.1211), (1324, 353), (53.0, 0.6), (219.2, 4.9),
    ),
    ("thread", "n50"): (
        (215.53, 0.08), (0.012, 0.005), (11.647, 0.002), (0.2466, 0.0012), None, (21.8, 0.4), (333.7, 1.2),
    ),
    ("thread", "d30"): (
        (215.69, 0.08), (0.004, 0.002), (11.014, 0.004), (0.2465, 0.0010), None, (22.8, 0.4), (335.7, 1.2),
    ),
}  # fmt: skip


def _picked(name: str) -> Callable[[FitDataset], ShotStatistics | None]:
    if name == "orientation_error_rad":
        return lambda dataset: dataset.orientation_error_rad
    return lambda dataset: dataset.parameters.get(name)


def _parameters(variant: str, window: str) -> Iterator[PaperNumber]:
    label, of = "tab:model_params_fit_result", partial(_of_window, variant, window)
    for (name, (shown, factor)), row in zip(_PARAMETERS.items(), _FITTED[variant, window], strict=True):
        if row is None:
            continue
        mean, std = row
        what = f"{variant} {window.upper()}: {shown}"
        yield PaperNumber(
            label,
            f"{what}, mean",
            mean,
            3.0 * std / math.sqrt(SHOTS),
            "three standard errors of the paper's mean",
            of(_picked(name), mean_of, factor),
            CHARACTERISE,
            because=_why_a_mean(variant, window, name, mean),
        )
        yield PaperNumber(
            label,
            f"{what}, deviation",
            std,
            3.0 * std / math.sqrt(2.0 * (SHOTS - 1)),
            "three standard errors of the paper's deviation",
            of(_picked(name), scatter_of, factor),
            CHARACTERISE,
            because=reasons.scatter(variant, window, name),
        )


def _why_a_mean(variant: str, window: str, name: str, paper: float) -> Because:
    if name == "psi_start_rad":
        return reasons.phase(variant, window, paper)
    return reasons.orientation(variant) if name == "orientation_error_rad" else reasons.relative(paper)


def _significance(variant: str) -> Iterator[PaperNumber]:
    """For each parameter, whether its means over N50 and D30 differ significantly."""
    same = {"lambda_per_s", "psi_start_rad"} if variant == "jewel" else {"lambda_per_s"}
    for name, (shown, _) in _PARAMETERS.items():
        if (variant == "thread" and name == "tf_over_i_rad_per_s2") or (variant == "jewel" and name == "lambda_per_s"):
            continue  # no friction; held in N50

        printed_as_different = name not in same

        def differs(found: Findings, name: str = name, projected: bool = printed_as_different) -> Value | None:
            report = found.report(variant)
            rows = [] if report is None else [row for row in report.comparisons if row.quantity == name]
            if not rows or rows[0].significant is None or report is None:
                return None
            of_all = reasons.chance_of_as_many(rows[0]) if projected and rows[0].shots < SHOTS else None
            return says(rows[0].significant or (of_all is not None and len(report.comparisons) * of_all < report.alpha))

        yield statement(
            "ssec:primary_results",
            f"{variant}: {shown.partition(' / ')[0]} of N50 and D30 differ significantly at alpha = 0.001",
            "yes" if printed_as_different else "no",
            differs,
            CHARACTERISE,
            "paired t test over the shots of this campaign, corrected after Holm; where the paper's 100 shots differ "
            "and this campaign has fewer, what 100 shots of the same difference and scatter would say",
            reasons.significance(variant, name),
        )


def _windows() -> Iterator[PaperNumber]:
    for variant, mean, std in (("jewel", 1.28, 0.31), ("thread", 4.90, 0.01)):
        yield PaperNumber(
            "ssec:primary_results",
            f"{variant}: T of D30 / s, mean",
            mean,
            max(3.0 * std / math.sqrt(SHOTS), 0.005),
            "three standard errors of the paper's mean, at least half a unit of its last digit",
            _of_window(variant, "d30", lambda d: d.duration_s, mean_of, 1.0),
            CHARACTERISE,
            because=reasons.window if variant == "thread" else reasons.relative(mean),
        )
        yield PaperNumber(
            "ssec:primary_results",
            f"{variant}: T of D30 / s, deviation",
            std,
            max(3.0 * std / math.sqrt(2.0 * (SHOTS - 1)), 0.005),
            "three standard errors of the paper's deviation, at least half a unit of its last digit",
            _of_window(variant, "d30", lambda d: d.duration_s, scatter_of, 1.0),
            CHARACTERISE,
            because=reasons.relative(std),
        )


def _quality_factors() -> Iterator[PaperNumber]:
    def of(variant: str, pick: Callable[[QualityFactors], ShotStatistics | None]) -> Ours:
        def ours(found: Findings) -> Value | None:
            report = found.report(variant)
            return None if report is None else median_of(pick(report.quality_factors), 1.0)

        return ours

    label = "tab:quality_factors"
    for what, paper, ours, printed_means in zip(
        ("over N50", "over D30", "to infinity"),
        (1327, 897, 641),
        (of("jewel", lambda q: q.n50), of("jewel", lambda q: q.d30), of("jewel", lambda q: q.infinity)),
        quality_of_the_means(),
        strict=True,
    ):
        because = reasons.quality(printed_means)
        yield printed(label, f"jewel: equivalent Q {what}", paper, ours, 0, CHARACTERISE, because=because)
    viscous = of("thread", lambda q: q.viscous)
    yield printed(label, "thread: Q", 2750, viscous, 0, CHARACTERISE, 10.0, reasons.relative(2750))


def _signals() -> Iterator[PaperNumber]:
    def ratio(key: str, found: Findings) -> Value | None:
        reports = [found.report(variant) for variant in ("jewel", "thread")]
        first = [getattr(r.envelopes[0], key)[0] for r in reports if r is not None and r.envelopes]
        return Value(first[0] / first[1]) if len(first) == 2 else None

    label = "fig:amplitude_plot"
    rule = "jewel over thread at the start of RX"
    yield printed(label, f"u signal, {rule}", 5.0, partial(ratio, "u_am2_per_s"), 0, CHARACTERISE)
    of_v = partial(ratio, "v_am2_per_s")
    yield printed(label, f"v signal, {rule}", 3.0, of_v, 0, CHARACTERISE, because=reasons.ratio_v)

    def sooner(found: Findings) -> Value | None:
        ends = [None if (r := found.report(v)) is None else r.d30.duration_s for v in ("jewel", "thread")]
        jewel, thread = ends
        return None if jewel is None or thread is None else says(jewel.highest < thread.lowest)

    yield statement(
        label, "every shot of the jewel decays to 30 % before any of the thread", "yes", sooner, CHARACTERISE
    )


def _noise() -> Iterator[PaperNumber]:
    def ours(quantity: str, found: Findings) -> Value | None:
        crossing = found.break_even(quantity)
        if crossing is None or crossing.level_am2_per_s is None:
            return None
        ends = crossing.interval_am2_per_s  # 95 %: four standard errors long
        return Value(crossing.level_am2_per_s, None if ends is None else (ends[1] - ends[0]) / 4.0)

    def missing(quantity: str, text: str, found: Findings) -> str:
        crossing = found.break_even(quantity)
        return found.why_no_noise if crossing is None else f"no such level: {crossing.reason}; {text}"

    shown_as = ("natural frequency", "orientation")
    for (quantity, level), shown, text in zip(
        PRINTED_BREAK_EVEN_AM2_PER_S.items(), shown_as, break_even_text(), strict=True
    ):
        yield PaperNumber(
            "fig:noise_plot",
            f"level of noise from which on the jewel is more precise, {shown} / A m2 s-1",
            level,
            0.25 * level,
            f"a quarter; {text}",
            partial(ours, quantity),
            NOISE,
            missing=partial(missing, quantity, text),
        )


def _manufacturing() -> Iterator[PaperNumber]:
    for variant, minutes in (("jewel", 11.0), ("thread", 23.0)):
        yield PaperNumber(
            "tab:manufacturing_times",
            f"{variant}: total production time / min",
            minutes,
            None,
            "",
            lambda found: None,
            "",
            "a person's time at the bench is nothing that software computes",
        )
