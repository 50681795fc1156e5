"""Design numbers and forces of defects for the terminal."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from platform_daemon.core.reporting.tables import tables_text

from .schema import DefectsReport, DesignReport, FrictionReport, StaticProcedure

_ROWS, _COLUMNS = 50, 8  # of more, only the largest is shown
_UNITS = {  # of a name's ending: factor to what people read, and what it is called
    "_rad": (57.29577951308232, "deg"), "_m": (1e3, "mm"), "_n": (1e3, "mN"), "_nm": (1e6, "uNm"),
}  # fmt: skip


def design_text(report: DesignReport) -> str:
    """Magnets, numbers with the equation that gives each, friction, and the six steps."""
    m = report.magnets
    lines = [
        f"{report.resonator}: r {m.radius_m * 1e3:.4g} mm, B_r {m.remanence_t:.4g} T, "
        f"rho {m.density_kg_per_m3:.5g} kg/m3, d {m.distance_m * 1e3:.4g} mm",
        *(_line(*row) for row in _numbers(report)),
    ]
    if report.friction is not None:
        lines += [_line(*row) for row in _friction(report.friction)]
        if report.friction.printed is not None:
            lines.append(f"note: {report.friction.printed.note}.")
    if report.measured is not None:
        lines += _measured(report)
    for procedure in report.procedures:
        lines += ["", *_procedure(procedure)]
    return "\n".join(lines)


def step_rows(report: DesignReport) -> list[dict[str, Any]]:
    """For a CSV: a row per step of the procedure of each bearing."""
    return [
        {"bearing": each.bearing, "defect": each.defect, **step.model_dump()}
        for each in report.procedures
        for step in each.steps
    ]


def _line(symbol: str, value: str, source: str) -> str:
    return f"  {symbol:<8}{value:<24}{source}".rstrip()


def _numbers(report: DesignReport) -> list[tuple[str, str, str]]:
    return [
        ("m_r", f"{report.m_r_am2 * 1e3:.3f} mAm2", "eq:m_r"),
        ("f_nat", f"{report.f_nat_hz:.2f} Hz", "eq:fnat"),
        ("F_m", f"{report.f_m_n * 1e3:.2f} mN", "eq:fm(phi)"),
        ("F_g", f"{report.f_g_n * 1e3:.3f} mN", "weight of the rotor"),
        ("I", f"{report.inertia_kg_m2:.4g} kg m2", "solid sphere"),
        ("B_0", f"{report.b_0_t * 1e3:.2f} mT", "dipole at d, eq:T_m"),
    ]


def _friction(friction: FrictionReport) -> list[tuple[str, str, str]]:
    mu = f"with mu = {friction.friction_coefficient:g}"
    quality = friction.quality_factor_per_rad
    rows = [
        ("Lambda", f"{friction.lambda_factor:.4f}", f"at R/r = {friction.cup_radius_over_r:.4g}"),
        ("a", f"{friction.contact_radius_m * 1e6:.2f} um", "eq:a"),
        ("T_f", f"{friction.t_f_nm * 1e9:.1f} nNm", f"eq:tf, {mu}"),
        ("T_f/I", f"{friction.tf_over_i_rad_per_s2:.0f} rad/s2", f"eq:TfoverI, {mu}"),
        (
            "Q/phi_0",
            "-" if quality is None else f"{quality:.0f} /rad",
            "sup:proof_size_independence: at any size",
        ),
    ]
    printed = friction.printed
    if printed is not None:
        text = f"as printed; follows with mu = {printed.follows_from_friction_coefficient:.2f}"
        rows.append(("T_f", f"{printed.t_f_nm * 1e9:.1f} nNm", text))
        rows.append(("T_f/I", f"{printed.tf_over_i_rad_per_s2:.0f} rad/s2", text))
    return rows


def _measured(report: DesignReport) -> list[str]:
    measured = report.measured
    assert measured is not None
    known = [
        ("m_r", measured.m_r_am2, 1e3, "mAm2"),
        ("f_nat", measured.f_nat_hz, 1.0, "Hz"),
        ("T_f/I", measured.tf_over_i_rad_per_s2, 1.0, "rad/s2"),
    ]
    parts = [f"{name} {value * factor:.5g} {unit}" for name, value, factor, unit in known if value is not None]
    return [f"measured on it: {', '.join(parts)}"] if parts else []


def _procedure(procedure: StaticProcedure) -> list[str]:
    span = procedure.span_over_r if procedure.span_over_r == "inf" else f"{procedure.span_over_r:.4g}"
    name = "R/r" if procedure.bearing == "jewel" else "l/r"
    lines = [
        f"{procedure.bearing}, {name} = {span}: stator tilted by {procedure.eps_deg:g} deg, "
        f"rotor deflected by {procedure.phi_deg:g} deg (ssec:manufacturing_errors_side_modes)"
    ]
    for step in procedure.steps:
        lines.append(f"  {step.step}. {step.what}  [{step.source}]")
        lines.append("     " + ", ".join(_value(name, value) for name, value in step.values.items()))
    return lines


def _value(name: str, value: float | Sequence[float]) -> str:
    ending = next((e for e in sorted(_UNITS, key=len, reverse=True) if name.endswith(e)), "")
    factor, unit = _UNITS.get(ending, (1.0, ""))
    numbers = [value] if isinstance(value, float) else list(value)
    text = ", ".join(f"{x * factor:.4g}" for x in numbers)
    return f"{name.removesuffix(ending)} {text if len(numbers) == 1 else f'({text})'} {unit}".rstrip()


def defects_text(report: DefectsReport) -> str:
    """F_perp by size and deflection with the position of rest; of a large sweep the largest only."""
    key, unit = ("dy_mm", "mm") if report.defect == "lateral" else ("eps_deg", "deg")
    sizes = list(dict.fromkeys(getattr(case, key) for case in report.cases))
    deflections = list(dict.fromkeys(case.phi_deg for case in report.cases))
    title = f"{report.bearing}, {report.defect}, {_geometry(report)}"
    if len(sizes) > _ROWS or len(deflections) > _COLUMNS:
        top = max(report.cases, key=lambda case: case.f_perp_n)
        size = f"{getattr(top, key):g} {unit}, {top.phi_deg:g} deg"
        return f"{title}: {len(report.cases)} cases, the largest F_perp is {top.f_perp_n * 1e3:.4g} mN at {size}"
    force = {(getattr(case, key), case.phi_deg): case for case in report.cases}
    first = [force[size, deflections[0]] for size in sizes]
    columns = [
        (f"F_perp / mN at {phi:g} deg", [f"{force[size, phi].f_perp_n * 1e3:.4g}" for size in sizes])
        for phi in deflections
    ]
    columns.append(("|dy_C| / mm", [f"{case.dy_c_m * 1e3:.4g}" for case in first]))
    columns.append(("alpha / deg", [f"{case.alpha_rad * _UNITS['_rad'][0]:.5g}" for case in first]))
    return tables_text(title, (f"{key.partition('_')[0]} / {unit}", [f"{size:g}" for size in sizes]), columns)


def _geometry(report: DefectsReport) -> str:
    name, value = (
        ("R/r", report.cup_radius_over_r) if report.bearing == "jewel" else ("l/r", report.thread_length_over_r)
    )
    parts = [f"{name} = {value if isinstance(value, str) else format(value, '.4g')}"]
    if report.pivot is not None:
        parts.append(f"about the {report.pivot.replace('_', ' ')}")
    if report.direction == "across":
        parts.append("across the magnetisation")
    return ", ".join(parts)
