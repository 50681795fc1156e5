"""Every number of the paper that is compared, by its LaTeX label, with where ours comes from.

Nothing of ours stands here: each is computed from the design equations, the statics of a defect, or the fits.
The paper's means are over 100 shots, so that their standard error is a tenth of the standard deviation it prints.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial

from drivers.specimen import JewelBearing, Magnets
from platform_daemon.design.equations import PAPER_JEWEL, PAPER_MAGNETS, design_numbers, friction_increase
from platform_daemon.features.characterise.schema import FitDataset, QualityFactors, ShotStatistics
from platform_daemon.features.design.checked_defect import checked_defect
from platform_daemon.features.design.schema import DefectsRequest

from .findings import Findings, Value, lowest_of, mean_of, median_of, scatter_of

SHOTS = 100
"""Of each resonator in the paper."""
DESIGN, CHARACTERISE, DEFECTS = "platform-daemon design", "platform-daemon characterise", "platform-daemon defects"
Ours = Callable[[Findings], Value | None]


@dataclass(frozen=True)
class PaperNumber:
    """A number or a statement of the paper.

    Attributes:
        label, what, paper: see Claim.
        tolerance: of the paper's part, in its unit; None: of a statement.
        rule: how the tolerance follows, in words.
        ours: takes ours from what was found; it returns None where it was not measured.
        command: that computes it.
        never: why it can never be compared, "": it can.
    """

    label: str
    what: str
    paper: float | str
    tolerance: float | None
    rule: str
    ours: Ours
    command: str
    never: str = ""


def paper_numbers() -> Iterator[PaperNumber]:
    """All of them, in the order of the paper."""
    yield from _friction_in_a_cup()
    yield from _defects()
    yield from _design()
    for variant in ("jewel", "thread"):
        yield from _measurement(variant)
    for variant, window in ((v, w) for v in ("jewel", "thread") for w in ("n50", "d30")):
        yield from _fit_quality(variant, window)
    for variant, window in ((v, w) for v in ("jewel", "thread") for w in ("n50", "d30")):
        yield from _parameters(variant, window)
    for variant in ("jewel", "thread"):
        yield from _significance(variant)
    yield from _windows()
    yield from _quality_factors()
    yield from _signals()
    yield from _noise()
    yield from _manufacturing()


def _printed(
    label: str, what: str, paper: float, ours: Ours, digits: int, command: str, unit_in_last: float = 1.0
) -> PaperNumber:
    """A number without an error: half a unit of its last printed digit."""
    tolerance = 0.5 * unit_in_last * 10.0**-digits
    return PaperNumber(label, what, paper, tolerance, "half a unit of the last printed digit", ours, command)


def _statement(
    label: str, what: str, paper: str, ours: Ours, command: str, rule: str = "the statement itself"
) -> PaperNumber:
    return PaperNumber(label, what, paper, None, rule, ours, command)


def _says(true: bool) -> Value:
    return Value("yes" if true else "no")


def _friction_in_a_cup() -> Iterator[PaperNumber]:
    for k, paper in ((2.0, 1.26), (4.0, 1.10)):
        yield _printed(
            "fig:simulation_lambda(t)",
            f"Lambda({k:g})",
            paper,
            partial(_lambda, k),
            2,
            DESIGN,
        )


def _lambda(ratio: float, found: Findings) -> Value:
    return Value(friction_increase(ratio))


def _force(bearing: str, defect: str, size: float, phi_deg: float, span: float | str | None = None) -> float:
    """F_perp, N, at the paper's design point; size: degrees, or mm of a displacement."""
    keys: dict[str, object] = {"bearing": bearing, "defect": defect, "phi_deg": [phi_deg]}
    keys["dy_mm" if defect == "lateral" else "eps_deg"] = [size]
    if span is not None:
        keys["cup_radius_over_r" if bearing == "jewel" else "thread_length_over_r"] = span
    checked = checked_defect(DefectsRequest.model_validate(keys))
    return float(checked.analysed([size], [phi_deg]).perpendicular_force_n[0, 0])


def _vanishes(bearing: str, found: Findings) -> Value:
    return _says(_force(bearing, "stator_tilt", 0.0, 30.0) < 1e-9)


def _rises_with_deflection(bearing: str, found: Findings) -> Value:
    forces = [_force(bearing, "stator_tilt", 2.0, phi) for phi in (10.0, 30.0, 50.0)]
    return _says(forces[0] < forces[1] < forces[2])


def _like_stator_tilt(bearing: str, defect: str, found: Findings) -> Value:
    return _says(abs(_force(bearing, defect, 2.0, 30.0) / _force(bearing, "stator_tilt", 2.0, 30.0) - 1.0) < 0.2)


def _rises(bearing: str, defect: str, spans: tuple[float | str, ...], found: Findings, *, falls: bool) -> Value:
    """Does the force rise with the size of cup or thread, at 2 deg or 0.1 mm, and 30 deg?"""
    forces = [_force(bearing, defect, 0.1 if defect == "lateral" else 2.0, 30.0, span) for span in spans]
    steps = [b - a for a, b in itertools.pairwise(forces)]
    return _says(all(step < 0.0 if falls else step > 0.0 for step in steps))


_CUPS: tuple[float | str, ...] = (5 / 3, 2.0, 4.0, 10.0)
_THREADS: tuple[float | str, ...] = (2.0, 4.0, 8.0, 16.0)


def _defects() -> Iterator[PaperNumber]:
    label = "fig:F_tan_over_epsilon"
    yield _printed(label, "F_g / mN", 1.08, lambda found: Value(1e3 * found.design.f_g_n), 2, DESIGN)
    for bearing, spans in (("jewel", _CUPS), ("thread", _THREADS)):
        yield _statement(
            label,
            f"{bearing}: without a defect F_perp vanishes at 30 deg",
            "yes",
            partial(_vanishes, bearing),
            DEFECTS,
        )
        yield _statement(
            label,
            f"{bearing}: F_perp rises with the deflection (2 deg of tilt; 10, 30 and 50 deg)",
            "yes",
            partial(_rises_with_deflection, bearing),
            DEFECTS,
        )
        name = "R/r" if bearing == "jewel" else "l/r"
        told = ", ".join(f"{span:.3g}" for span in spans)
        yield _statement(
            label,
            f"{bearing}: F_perp rises with {name} ({told})",
            "yes",
            partial(_rises, bearing, "stator_tilt", spans, falls=False),
            DEFECTS,
        )
        second = "jewel_tilt" if bearing == "jewel" else "rotor_tilt"
        yield _statement(
            "fig:F_tan_over_rotor_epsilon",
            f"{bearing}: {second} raises F_perp like stator_tilt (within a fifth at 2 deg and 30 deg)",
            "yes",
            partial(_like_stator_tilt, bearing, second),
            DEFECTS,
        )
        yield _statement(
            "fig:F_tan_over_delta_y",
            f"{bearing}: of a lateral displacement F_perp falls with {name} ({told})",
            "yes",
            partial(_rises, bearing, "lateral", spans, falls=True),
            DEFECTS,
        )
        for defect, size in (("stator_tilt", 10.0), (second, 10.0), ("lateral", 1.0)):
            yield _statement(
                "fig:equilibrium_positions_defects",
                f"{bearing}, {defect}: the rotor rests off the axis, and alpha is not 90 deg",
                "yes",
                partial(_off_axis, bearing, defect, size),
                DEFECTS,
            )


def _off_axis(bearing: str, defect: str, size: float, found: Findings) -> Value:
    keys = {"bearing": bearing, "defect": defect, "phi_deg": [0.0]}
    keys["dy_mm" if defect == "lateral" else "eps_deg"] = [size]
    rest = checked_defect(DefectsRequest.model_validate(keys)).analysed([size], [0.0])
    return _says(abs(rest.displacement_m[0]) > 1e-6 and abs(rest.alpha_rad[0] - math.pi / 2) > 1e-3)


def _design() -> Iterator[PaperNumber]:
    yield _printed("eq:m_r", "m_r / mAm2", 14.6, lambda found: Value(1e3 * found.design.m_r_am2), 1, DESIGN)
    yield _printed("eq:fnat", "f_nat / Hz", 229.3, lambda found: Value(found.design.f_nat_hz), 1, DESIGN)
    yield _printed("eq:fm(phi)", "F_m / mN", 131.5, lambda found: Value(1e3 * found.design.f_m_n), 1, DESIGN)
    yield _printed(
        "eq:tf(phi)",
        "T_f / nNm, with the printed mu = 0.15",
        115.9,
        lambda found: Value(1e9 * found.friction.friction_torque_nm),
        1,
        DESIGN,
    )
    yield _printed(
        "eq:TfoverI",
        "T_f/I / rad s-2, with the printed mu = 0.15",
        1168.0,
        lambda found: Value(found.friction.friction_rad_per_s2),
        0,
        DESIGN,
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
        if ramp is None or ramp.operating_field_t is None:
            return None
        return Value(1e6 * ramp.operating_field_t / 0.8)

    label = "tab:measurement_parameter"
    yield _printed(label, f"{variant}: f_TX / Hz", paper[0], partial(of, 0), 0, CHARACTERISE)
    yield _printed(label, f"{variant}: t_TX / s", paper[1], partial(of, 1), 3, CHARACTERISE)
    yield _printed(label, f"{variant}: B_TX / uT", paper[2], partial(of, 2), 0, CHARACTERISE, 10.0)
    yield _printed(label, f"{variant}: t_RX / s", paper[3], partial(of, 3), 1, CHARACTERISE)
    step = "the paper's steps of 10 uT"
    yield PaperNumber(
        "ssec:measurement_sequence", f"{variant}: B_max / uT", paper[4], 10.0, step, highest, CHARACTERISE
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
    yield _printed(label, f"{name}: median R2 / %", r2, of(lambda d: d.r2, median_of, 100.0), 2, CHARACTERISE)
    yield _printed(label, f"{name}: least R2 / %", least, of(lambda d: d.r2, lowest_of, 100.0), 2, CHARACTERISE)
    yield _printed(label, f"{name}: median nRMSE / %", nrmse, of(lambda d: d.nrmse, median_of, 100.0), 2, CHARACTERISE)
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
    for (name, (shown, factor)), printed in zip(_PARAMETERS.items(), _FITTED[variant, window], strict=True):
        if printed is None:
            continue
        mean, std = printed
        what = f"{variant} {window.upper()}: {shown}"
        yield PaperNumber(
            label,
            f"{what}, mean",
            mean,
            3.0 * std / math.sqrt(SHOTS),
            "three standard errors of the paper's mean",
            of(_picked(name), mean_of, factor),
            CHARACTERISE,
        )
        yield PaperNumber(
            label,
            f"{what}, deviation",
            std,
            3.0 * std / math.sqrt(2.0 * (SHOTS - 1)),
            "three standard errors of the paper's deviation",
            of(_picked(name), scatter_of, factor),
            CHARACTERISE,
        )


def _significance(variant: str) -> Iterator[PaperNumber]:
    same = {"lambda_per_s", "psi_start_rad"} if variant == "jewel" else {"lambda_per_s"}
    for name, (shown, _) in _PARAMETERS.items():
        if (variant == "thread" and name == "tf_over_i_rad_per_s2") or (variant == "jewel" and name == "lambda_per_s"):
            continue  # no friction; held in N50

        def differs(found: Findings, name: str = name) -> Value | None:
            report = found.report(variant)
            rows = [] if report is None else [row for row in report.comparisons if row.quantity == name]
            return _says(rows[0].significant) if rows and rows[0].significant is not None else None

        yield _statement(
            "ssec:primary_results",
            f"{variant}: {shown.partition(' / ')[0]} of N50 and D30 differ significantly at alpha = 0.001",
            "no" if name in same else "yes",
            differs,
            CHARACTERISE,
            "paired t test over the shots of this campaign, corrected after Holm; the paper's are 100",
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
        )
        yield PaperNumber(
            "ssec:primary_results",
            f"{variant}: T of D30 / s, deviation",
            std,
            max(3.0 * std / math.sqrt(2.0 * (SHOTS - 1)), 0.005),
            "three standard errors of the paper's deviation, at least half a unit of its last digit",
            _of_window(variant, "d30", lambda d: d.duration_s, scatter_of, 1.0),
            CHARACTERISE,
        )


def _quality_factors() -> Iterator[PaperNumber]:
    def of(variant: str, pick: Callable[[QualityFactors], ShotStatistics | None]) -> Ours:
        def ours(found: Findings) -> Value | None:
            report = found.report(variant)
            return None if report is None else median_of(pick(report.quality_factors), 1.0)

        return ours

    label = "tab:quality_factors"
    yield _printed(label, "jewel: equivalent Q over N50", 1327, of("jewel", lambda q: q.n50), 0, CHARACTERISE)
    yield _printed(label, "jewel: equivalent Q over D30", 897, of("jewel", lambda q: q.d30), 0, CHARACTERISE)
    yield _printed(label, "jewel: equivalent Q to infinity", 641, of("jewel", lambda q: q.infinity), 0, CHARACTERISE)
    yield _printed(label, "thread: Q", 2750, of("thread", lambda q: q.viscous), 0, CHARACTERISE, 10.0)


def _signals() -> Iterator[PaperNumber]:
    def ratio(key: str, found: Findings) -> Value | None:
        reports = [found.report(variant) for variant in ("jewel", "thread")]
        first = [getattr(r.envelopes[0], key)[0] for r in reports if r is not None and r.envelopes]
        return Value(first[0] / first[1]) if len(first) == 2 else None

    label = "fig:amplitude_plot"
    rule = "jewel over thread at the start of RX"
    yield _printed(label, f"u signal, {rule}", 5.0, partial(ratio, "u_am2_per_s"), 0, CHARACTERISE)
    yield _printed(label, f"v signal, {rule}", 3.0, partial(ratio, "v_am2_per_s"), 0, CHARACTERISE)

    def sooner(found: Findings) -> Value | None:
        ends = [None if (r := found.report(v)) is None else r.d30.duration_s for v in ("jewel", "thread")]
        jewel, thread = ends
        return None if jewel is None or thread is None else _says(jewel.highest < thread.lowest)

    yield _statement(
        label, "every shot of the jewel decays to 30 % before any of the thread", "yes", sooner, CHARACTERISE
    )


def _noise() -> Iterator[PaperNumber]:
    for quantity, level in (("natural frequency", 0.17), ("orientation", 0.54)):
        yield PaperNumber(
            "fig:noise_plot",
            f"level of noise from which on the jewel is more precise, {quantity} / A m2 s-1",
            level,
            0.25 * level,
            "a quarter",
            lambda found: None,
            "",
            "noise is not added to recorded shots by this version",
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
