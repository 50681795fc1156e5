"""From a request to a defect of a resonator, or what, where and why it makes no sense."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from drivers.errors import InputError
from drivers.specimen import Specimen
from platform_daemon.design.equations import PAPER_JEWEL, PAPER_MAGNETS, PAPER_THREAD
from platform_daemon.design.geometry import Bearing, DefectKind, StaticResonator
from platform_daemon.design.perpendicular_force import NoEquilibrium, StaticAnalysis, static_analysis

from .schema import DefectsRequest

_SPANS = {"jewel": "cup_radius_over_r", "thread": "thread_length_over_r"}
_POSSIBLE = {"jewel": "stator_tilt, jewel_tilt or lateral", "thread": "stator_tilt, rotor_tilt or lateral"}


@dataclass(frozen=True)
class CheckedDefect:
    """A defect of a resonator that makes sense.

    kind, resonator: as the static analysis takes them; span_over_r: R/r or l/r; by_option: the request came from the
    command line, so that what is wrong is called by its option.
    """

    request: DefectsRequest
    kind: DefectKind
    resonator: StaticResonator
    span_over_r: float
    by_option: bool

    def analysed(self, sizes: Sequence[float], phi_deg: Sequence[float]) -> StaticAnalysis:
        """Sizes (degrees or mm) at deflections.  Raises InputError where the rotor comes to rest nowhere."""
        try:
            return self.forces(sizes, phi_deg)
        except NoEquilibrium as refused:
            lateral = self.kind.defect == "lateral"
            value = refused.size * 1e3 if lateral else math.degrees(refused.size)
            raise InputError(
                f"the rotor has no position of rest with {value:.6g} {'mm' if lateral else 'deg'}",
                where=_place("dy_mm" if lateral else "eps_deg", self.by_option),
                why=refused.reason,
                remedy="ask for a smaller defect, or for another bearing",
            ) from None

    def forces(self, sizes: Sequence[float], phi_deg: Sequence[float]) -> StaticAnalysis:
        """The same.  Raises NoEquilibrium."""
        si = np.asarray(sizes) * 1e-3 if self.kind.defect == "lateral" else np.radians(sizes)
        return static_analysis(self.resonator, self.kind, si.tolist(), np.radians(phi_deg).tolist())


def checked_defect(
    request: DefectsRequest, specimen: Specimen | None = None, *, by_option: bool = False
) -> CheckedDefect:
    """What is requested, of a specimen's magnets or at the paper's design point.  Raises InputError."""
    _check_defect(request, by_option)
    _check_sizes(request, by_option)
    span, key = _span_over_r(request, specimen, by_option), _SPANS[request.bearing]
    given = getattr(request, key) is not None
    return CheckedDefect(
        request,
        DefectKind(request.bearing, request.defect, request.pivot or "contact", request.direction or "along"),
        static_resonator(request.bearing, specimen, span, _place(key, by_option) if given else ""),
        span,
        by_option,
    )


def static_resonator(
    bearing: Bearing, specimen: Specimen | None, span_over_r: float | None = None, where: str = ""
) -> StaticResonator:
    """Of a specimen's magnets, or of the paper's; its own cup or thread, else the paper's.

    Raises InputError that names the specimen, or `where` if that is given.
    """
    magnets = PAPER_MAGNETS if specimen is None else specimen.magnets
    ratio = own_span_over_r(bearing, specimen) if span_over_r is None else span_over_r
    try:
        return StaticResonator(
            bearing, magnets.radius_m, magnets.remanence_t, magnets.distance_m, ratio * magnets.radius_m
        )
    except ValueError as error:
        where = where or ("" if specimen is None else specimen.name)
        remedy = "correct radius, distance and bearing"
        raise InputError("there is no such resonator", where=where, why=str(error), remedy=remedy) from None


def own_span_over_r(bearing: Bearing, specimen: Specimen | None) -> float:
    """R/r or l/r of a specimen with that bearing, else the paper's."""
    if specimen is not None and bearing == "jewel" and specimen.jewel is not None:
        return specimen.jewel.cup_radius_m / specimen.magnets.radius_m
    if specimen is not None and bearing == "thread" and specimen.thread is not None:
        return specimen.thread.length_m / specimen.magnets.radius_m
    length = PAPER_JEWEL.cup_radius_m if bearing == "jewel" else PAPER_THREAD.length_m
    return length / PAPER_MAGNETS.radius_m


def _place(key: str, by_option: bool) -> str:
    return "--" + key.replace("_", "-") if by_option else key


def _refuse(key: str, by_option: bool, what: str, why: str, remedy: str) -> NoReturn:
    raise InputError(what, where=_place(key, by_option), why=why, remedy=remedy)


def _check_defect(request: DefectsRequest, by_option: bool) -> None:
    """Raises InputError for a defect that the bearing cannot have, and for what belongs to another defect."""
    bearing, defect = request.bearing, request.defect
    try:
        DefectKind(bearing, defect)
    except ValueError as error:
        remedy = f"a {bearing} bearing can have {_POSSIBLE[bearing]}"
        _refuse("defect", by_option, f"a {bearing} bearing cannot have a {defect}", str(error), remedy)
    if request.pivot is not None and defect != "jewel_tilt":
        _refuse("pivot", by_option, f"a {defect} has no pivot", "only a jewel is tilted about one", "leave it out")
    if request.direction is not None and defect != "lateral":
        _refuse("direction", by_option, f"a {defect} has no direction", "only a displacement has one", "leave it out")


def _check_sizes(request: DefectsRequest, by_option: bool) -> None:
    """Raises InputError unless there are sizes of the kind of defect, and no others."""
    lateral = request.defect == "lateral"
    needed, other = ("dy_mm", "eps_deg") if lateral else ("eps_deg", "dy_mm")
    kind, unit = ("displacement", "mm") if lateral else ("tilt", "degrees")
    if getattr(request, other) is not None:
        why = f"{request.defect} is a {kind}, its size is in {unit}"
        _refuse(other, by_option, f"a {kind} has no {other}", why, f"give {_place(needed, by_option)} in its place")
    if getattr(request, needed) is None:
        remedy = f"give sizes of the defect in {unit}"
        _refuse(needed, by_option, "is missing", f"{request.defect} is a {kind}", remedy)


def _span_over_r(request: DefectsRequest, specimen: Specimen | None, by_option: bool) -> float:
    """R/r or l/r.  Raises InputError."""
    bearing = request.bearing
    key, other = _SPANS[bearing], _SPANS["thread" if bearing == "jewel" else "jewel"]
    if getattr(request, other) is not None:
        what = "a thread bearing has no cup" if bearing == "thread" else "a jewel bearing has no thread"
        _refuse(other, by_option, what, "", f"leave it out, or give {_place(key, by_option)}")
    requested = getattr(request, key)
    value = own_span_over_r(bearing, specimen) if requested is None else float(requested)
    if bearing == "jewel" and not value > 1:
        what = f"the rotor does not rest in a cup of radius {value:g} r"
        convex = "a negative radius is a convex jewel, on which no position of rest is stable"
        why = convex if value < 0 else "the cup's radius must be larger than the rotor's"
        _refuse(key, by_option, what, why, "give more than 1, or inf")
    if bearing == "thread" and not value > 0:
        why = "the length of a thread is positive"
        _refuse(key, by_option, f"there is no thread of length {value:g} r", why, "give more than 0, or inf")
    return value
