"""What the paper says of manufacturing defects, from the statics of its design point."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from functools import partial

from platform_daemon.features.design.checked_defect import checked_defect
from platform_daemon.features.design.schema import DefectsRequest

from .findings import Findings, Value
from .paper_number import DEFECTS, DESIGN, PaperNumber, printed, says, statement


def _force(bearing: str, defect: str, size: float, phi_deg: float, span: float | str | None = None) -> float:
    """F_perp, N, at the paper's design point; size: degrees, or mm of a displacement."""
    keys: dict[str, object] = {"bearing": bearing, "defect": defect, "phi_deg": [phi_deg]}
    keys["dy_mm" if defect == "lateral" else "eps_deg"] = [size]
    if span is not None:
        keys["cup_radius_over_r" if bearing == "jewel" else "thread_length_over_r"] = span
    checked = checked_defect(DefectsRequest.model_validate(keys))
    return float(checked.analysed([size], [phi_deg]).perpendicular_force_n[0, 0])


def _vanishes(bearing: str, found: Findings) -> Value:
    return says(_force(bearing, "stator_tilt", 0.0, 30.0) < 1e-9)


def _rises_with_deflection(bearing: str, found: Findings) -> Value:
    forces = [_force(bearing, "stator_tilt", 2.0, phi) for phi in (10.0, 30.0, 50.0)]
    return says(forces[0] < forces[1] < forces[2])


def _over_stator_tilt(bearing: str, defect: str, size: float) -> float:
    return _force(bearing, defect, size, 30.0) / _force(bearing, "stator_tilt", size, 30.0)


def _like_stator_tilt(bearing: str, defect: str, found: Findings) -> Value:
    return says(abs(_over_stator_tilt(bearing, defect, 2.0) - 1.0) < 0.2)


def _how_unlike(bearing: str, defect: str, found: Findings, ours: Value) -> str:
    ratios = [_over_stator_tilt(bearing, defect, size) for size in (1.0, 2.0, 5.0)]
    return (
        f"F_perp is {ratios[0]:.2f}, {ratios[1]:.2f} and {ratios[2]:.2f} times that of a tilted stator at 1, 2, 5 deg, "
        "so that the curves have one shape at two heights; the text has that they closely resemble each other"
    )


def _rises(bearing: str, defect: str, spans: tuple[float | str, ...], found: Findings, *, falls: bool) -> Value:
    """Does the force rise with the size of cup or thread, at 2 deg or 0.1 mm, and 30 deg?"""
    forces = [_force(bearing, defect, 0.1 if defect == "lateral" else 2.0, 30.0, span) for span in spans]
    steps = [b - a for a, b in itertools.pairwise(forces)]
    return says(all(step < 0.0 if falls else step > 0.0 for step in steps))


_CUPS: tuple[float | str, ...] = (5 / 3, 2.0, 4.0, 10.0)
_THREADS: tuple[float | str, ...] = (2.0, 4.0, 8.0, 16.0)


def defect_numbers() -> Iterator[PaperNumber]:
    """All of them."""
    label = "fig:F_tan_over_epsilon"
    yield printed(label, "F_g / mN", 1.08, lambda found: Value(1e3 * found.design.f_g_n), 2, DESIGN)
    for bearing, spans in (("jewel", _CUPS), ("thread", _THREADS)):
        yield statement(
            label,
            f"{bearing}: without a defect F_perp vanishes at 30 deg",
            "yes",
            partial(_vanishes, bearing),
            DEFECTS,
        )
        yield statement(
            label,
            f"{bearing}: F_perp rises with the deflection (2 deg of tilt; 10, 30 and 50 deg)",
            "yes",
            partial(_rises_with_deflection, bearing),
            DEFECTS,
        )
        name = "R/r" if bearing == "jewel" else "l/r"
        listed = ", ".join(f"{span:.3g}" for span in spans)
        yield statement(
            label,
            f"{bearing}: F_perp rises with {name} ({listed})",
            "yes",
            partial(_rises, bearing, "stator_tilt", spans, falls=False),
            DEFECTS,
        )
        second = "jewel_tilt" if bearing == "jewel" else "rotor_tilt"
        yield statement(
            "fig:F_tan_over_rotor_epsilon",
            f"{bearing}: {second} raises F_perp like stator_tilt (within a fifth at 2 deg and 30 deg)",
            "yes",
            partial(_like_stator_tilt, bearing, second),
            DEFECTS,
            because=partial(_how_unlike, bearing, second),
        )
        yield statement(
            "fig:F_tan_over_delta_y",
            f"{bearing}: of a lateral displacement F_perp falls with {name} ({listed})",
            "yes",
            partial(_rises, bearing, "lateral", spans, falls=True),
            DEFECTS,
        )
        for defect, size in (("stator_tilt", 10.0), (second, 10.0), ("lateral", 1.0)):
            yield statement(
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
    return says(abs(rest.displacement_m[0]) > 1e-6 and abs(rest.alpha_rad[0] - math.pi / 2) > 1e-3)
