"""The influences on a fit, each with what it does to every parameter: exact where there is an equation, else by the
linear response of the fit to its data."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date

import numpy as np
from numpy.typing import NDArray

from drivers.calibration import ReceiveCalibration, angle_of, channel_names, gain_of, phase_of, turned_towards
from drivers.errors import InputError
from drivers.specimen import Specimen
from drivers.uncertainty import DeclaredUncertainty, Influence
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.result import FitResult
from platform_daemon.uncertainty.inputs import InputQuantity

from .response import Response, turned_to_rodrigues
from .thresholds import REMANENCE_PER_K

Array = NDArray[np.float64]
AXES = "xyz"
DAYS_PER_YEAR = 365.25
_FOURTH_ORDER = 144.0 / 125.0  # of a Helmholtz pair's field, over (distance / radius)^4


@dataclass(frozen=True, eq=False)
class Effect:
    """What one influence does.

    Attributes:
        name: in words, with its axis.
        effects: change of every parameter of the fit per unit of it, (m,), in their order.
        known: how well it is known; None: nobody has declared it.
        unit, unit_text: a size that it is judged by while it is not declared, and that in words.
        kind: name of all that are declared together; "": its own name.
        mixing: (3, 3) P^+ dP of a unit of a gain or an angle, by which it mixes the axes; None: it is neither.
    """

    name: str
    effects: Array
    known: InputQuantity | None
    unit: float
    unit_text: str
    kind: str = ""
    mixing: Array | None = None


@dataclass(frozen=True, kw_only=True, eq=False)
class Situation:
    """What a fit was made of, as far as influences depend on it.

    Attributes:
        fit, response: of one frame; response None: an uncalibrated or an angle record, which P does not reach.
        calibration, specimen, declared: as the recording says.
        measured: day of the recording; temperature_c: mean of the thermometer, temperature_change_k: its highest minus
            its lowest reading, None: not measured.
    """

    fit: FitResult
    response: Response | None
    calibration: ReceiveCalibration | None
    specimen: Specimen | None
    declared: DeclaredUncertainty
    measured: date
    temperature_c: float | None
    temperature_change_k: float | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Parameters, in the order of the effects."""
        return tuple(self.fit.parameters)

    def single(self, name: str, effect: float) -> Array:
        """Effects on one parameter alone."""
        return np.array([effect if each == name else 0.0 for each in self.names])

    def of_data(self, change: Array) -> Array:
        """Effects of a change (3, n) of the data."""
        assert self.response is not None
        found = dict(zip(self.response.names, self.response.of(change).tolist(), strict=True))
        return np.array([found.get(name, 0.0) for name in self.names])


def effects_of(given: Situation) -> tuple[Effect, ...]:
    """Every influence, declared or not.

    Raises InputError for a certificate that was not valid when it was measured.
    """
    found = [*_clock(given), *_temperature(given), *_static_field(given), *_pose(given)]
    if given.response is not None and given.calibration is not None:
        found += [*_scale(given), *_channels(given, given.calibration), *_position(given, given.calibration)]
    return tuple(found)


def certified_source(declared: Influence, key: str, measured: date, *, issued_later: bool = False) -> str:
    """Where an influence is known from, in words, with its certificate.

    key: where it is declared; measured: day of the recording; issued_later: a certificate may be younger than that.
    Raises InputError for a certificate that was not valid on that day.
    """
    source = declared.source or key
    if (paper := declared.certificate) is None:
        return source
    where = f"{key}: certificate {paper.number}"
    remedy = "name a certificate that was valid then, or declare the influence without one and say how it is known"
    if paper.valid_until is not None and measured > paper.valid_until:
        what = f"expired on {paper.valid_until}; the recording was made on {measured}"
        raise InputError(what, where=where, remedy=remedy)
    if paper.date > measured and not issued_later:
        raise InputError(f"issued on {paper.date}, after it was measured on {measured}", where=where, remedy=remedy)
    return f"{source}, certificate {paper.number} of {paper.date}"


def _known(given: Situation, key: str, name: str, value: float = 0.0) -> InputQuantity | None:
    """What is declared under a key.  Raises InputError for a certificate that does not hold."""
    declared: Influence | None = getattr(given.declared, key)
    if declared is None:
        return _by_calibration(given, name, value)
    later = key == "calibration_drift_per_year"
    source = certified_source(declared, f"[uncertainty] {key}", given.measured, issued_later=later)
    return InputQuantity(
        name=name,
        value=value,
        u=declared.standard_uncertainty,
        kind=declared.kind,
        distribution=declared.distribution,
        dof=math.inf if declared.dof is None else declared.dof,
        source=source,
    )


def _by_calibration(given: Situation, name: str, value: float) -> InputQuantity | None:
    """What the calibration itself has measured of an influence."""
    made = given.calibration
    for each in () if made is None else made.influences:
        if each.name == name:
            assert made is not None
            day = f" of {made.date[:10]}" if made.date else ""
            return InputQuantity(
                name=name,
                value=value,
                u=each.u,
                kind=each.kind,
                dof=math.inf if each.dof is None else each.dof,
                source=f"calibration {made.identifier}{day}: {each.source}",
            )
    return None


def _clock(given: Situation) -> Iterator[Effect]:
    """A clock that is fast by 1 + e makes all times shorter: a parameter in s^-n grows by n e."""
    powers = np.array([_per_second(name) for name in given.names])
    values = np.array([each.value for each in given.fit.parameters.values()])
    if given.calibration is not None:
        # dm/dt is measured in volts, so that the moment is their size over a frequency.
        powers = np.where(np.array(given.names) == "m_r_am2", -1.0, powers)
    yield Effect(
        "sample clock",
        powers * values,
        _known(given, "sample_clock", "sample clock", 1.0),
        1e-6,
        "1e-6 of its frequency",
    )


def _per_second(name: str) -> float:
    """n of a unit s^-n."""
    unit = definition_of(name).unit
    if unit == "Hz":
        return 1.0
    found = re.search(r"/s(?:\^(\d))?$", unit)
    return 0.0 if found is None else float(found[1] or 1)


def _temperature(given: Situation) -> Iterator[Effect]:
    coefficients = given.declared.temperature_coefficient_per_k
    values = {name: each.value for name, each in given.fit.parameters.items()}
    typical = {n: REMANENCE_PER_K * value for n, value in values.items() if n in ("f_nat_hz", "m_r_am2")}
    effects = np.array([coefficients.get(name) or typical.get(name, 0.0) for name in given.names])
    declared = any(name in coefficients for name in given.names)
    known = None
    if declared and given.temperature_c is not None:
        known = _known(given, "thermometer_k", "temperature", given.temperature_c)
        effects = np.array([coefficients.get(name, 0.0) for name in given.names])
    unread = declared and known is None and given.temperature_c is not None
    yield Effect("temperature (thermometer not declared)" if unread else "temperature", effects, known, 1.0, "1 K")
    if known is not None:
        missing = {name: each for name, each in typical.items() if name not in coefficients}
        if missing:
            undeclared = np.array([missing.get(name, 0.0) for name in given.names])
            yield Effect("temperature (coefficient not declared)", undeclared, None, 1.0, "1 K")


def _static_field(given: Situation) -> Iterator[Effect]:
    """f = sqrt(m (B_s + B) / I) / 2 pi: a field B along the resting rotor adds to B_s = I (2 pi f)^2 / m."""
    if given.specimen is None or "m_r_am2" not in given.fit.parameters:
        return
    magnets = given.specimen.magnets
    inertia = 0.4 * (4.0 / 3.0 * math.pi * magnets.radius_m**3 * magnets.density_kg_per_m3) * magnets.radius_m**2
    f = given.fit.parameters["f_nat_hz"].value
    stator_t = inertia * (2.0 * math.pi * f) ** 2 / given.fit.parameters["m_r_am2"].value
    effects = given.single("f_nat_hz", f / (2.0 * stator_t))
    yield Effect("static field", effects, _known(given, "static_field_t", "static field"), 1e-6, "1 uT")


def _pose(given: Situation) -> Iterator[Effect]:
    if RODRIGUES[0] not in given.names:
        return
    turned = turned_to_rodrigues(np.array([given.fit.parameters[name].value for name in RODRIGUES]))
    for k, axis in enumerate(AXES):
        found = dict(zip(RODRIGUES, turned[:, k].tolist(), strict=True))
        effects = np.array([found.get(name, 0.0) for name in given.names])
        name = f"mounting pose about {axis}"
        yield Effect(name, effects, _known(given, "pose_rad", name), 1e-3, "1 mrad", "mounting pose")


def _scale(given: Situation) -> Iterator[Effect]:
    """All of P at once scales the moment, and nothing else (paper eq:projection)."""
    assert given.calibration is not None
    moment = given.fit.parameters.get("m_r_am2")
    effects = given.single("m_r_am2", 0.0 if moment is None else -moment.value)
    known = _known(given, "reference_dipole", "calibration", 1.0)
    if known is None and given.calibration.relative_std:
        source = f"calibration {given.calibration.identifier}: its reference dipole"
        known = InputQuantity(name="calibration", value=1.0, u=given.calibration.relative_std, source=source)
    yield Effect("calibration", effects, known, 1e-2, "1 % of the reference dipole")
    yield _drift(given, effects)


def _drift(given: Situation, effects: Array) -> Effect:
    name, per_year = "drift since the calibration", given.declared.calibration_drift_per_year
    made = (given.calibration.date if given.calibration is not None else None) or ""
    try:
        years = abs((given.measured - date.fromisoformat(made[:10])).days) / DAYS_PER_YEAR
    except ValueError:  # without a date nobody knows how far it may have drifted
        years = 0.0
    if per_year is None or years == 0.0:
        return Effect(name, effects, None, 1e-2, "1 % since the calibration")
    known = _known(given, "calibration_drift_per_year", name)
    assert known is not None
    return Effect(name, effects * years, known, 1e-2, "1 % per year")


def _channels(given: Situation, calibration: ReceiveCalibration) -> Iterator[Effect]:
    """d(dm/dt) = -P^+ dP dm/dt for a change dP of the sensitivity, at both harmonics or at one of them."""
    assert given.response is not None
    p, inverse = calibration.sensitivity, np.linalg.pinv(calibration.sensitivity)
    odd, even = given.response.odd, given.response.even
    both = odd + even
    names = channel_names(len(p))
    radians_per_s = 2.0 * math.pi * given.fit.parameters["f_nat_hz"].value
    for c, name in enumerate(names):
        through = np.outer(inverse[:, c], p[c])
        yield Effect(
            gain_of(name), given.of_data(-through @ both), _known(given, "gain", gain_of(name), 1.0), 1e-2,
            "1 % of each", "gain of the channels", through,
        )  # fmt: skip
        yield Effect(
            phase_of(name), given.of_data(through @ given.response.slope / radians_per_s),
            _known(given, "phase_rad", phase_of(name)), 1e-3, "1 mrad of each", "phase of the channels",
        )  # fmt: skip
    for c, axis in turned_towards(p):
        label = angle_of(names[c], axis)
        turned = np.outer(inverse[:, c], np.eye(3)[axis]) * float(np.abs(p[c]).max())
        known = _known(given, "orthogonality_rad", label)
        yield Effect(
            label, given.of_data(-turned @ both), known, 1e-3, "1 mrad of each", "orthogonality of the coils", turned
        )
    if calibration.p_std is None or calibration.frequency_hz is None or calibration.frequency_response is None:
        return
    f = given.fit.parameters["f_nat_hz"].value
    for harmonic, signal in ((1, odd), (2, even)):
        k = int(np.argmin(np.abs(calibration.frequency_hz - harmonic * f)))
        std = calibration.p_std[:, :, k] / np.abs(calibration.frequency_response[:, k])[:, None]
        for (c, axis), u in np.ndenumerate(std):
            if u > 0.0:
                name = f"calibration, noise of P[{names[c]}, {AXES[axis]}] at {'f' if harmonic == 1 else '2 f'}"
                effects = given.of_data(-np.outer(inverse[:, c], np.eye(3)[axis]) @ signal)
                source = f"calibration {calibration.identifier}: the noise of its shots"
                known = InputQuantity(name=name, value=float(p[c, axis]), u=float(u), kind="A", source=source)
                yield Effect(name, effects, known, float(u), "")


def _position(given: Situation, calibration: ReceiveCalibration) -> Iterator[Effect]:
    """By the fourth order of Helmholtz pairs: the larger change on both sides of the declared place, at one u from it.

    At the centre all derivatives vanish up to the third, so that the slope of the secant counts (JCGM 100:2008, 5.1.3,
    note 2).
    """
    radii = given.declared.coil_radius_m
    if radii is None or len(calibration.sensitivity) != 3 or given.specimen is None:
        nothing = given.single("m_r_am2", math.nan)
        yield Effect("position", nothing, None, 1e-3, "1 mm (coil_radius_m is not declared)")
        return
    assert given.response is not None
    both = given.response.odd + given.response.even
    here = np.array(given.specimen.pose.position_m)
    for k, axis in enumerate(AXES):
        name = f"position along {axis}"
        known = _known(given, "position_m", name, float(here[k]))
        step = 1e-3 if known is None else known.u
        sides = []
        for sign in (1.0, -1.0):
            moved = here + sign * step * np.eye(3)[k]
            relative = np.linalg.solve(pair_fields(here, radii), pair_fields(moved, radii)) - np.eye(3)
            sides.append(sign * given.of_data(-relative @ both) / step)
        effects = np.where(np.abs(sides[0]) >= np.abs(sides[1]), *sides)
        yield Effect(name, effects, known, 1e-3, "1 mm", "position")


def pair_fields(place: Array, radii: tuple[float, float, float]) -> Array:
    """Field of unit Helmholtz pairs along x, y, z at places (..., 3), over that at the centre, (..., coil, axis), to
    fourth order: B_z = 1 - 144/125 (z^4 - 3 z^2 r^2 + 3/8 r^4) / R^4, B_r = -144/125 (3/2 z r^3 - 2 z^3 r) / R^4."""
    rows = []
    for k, radius in enumerate(radii):
        along = place[..., k] / radius
        across = np.delete(place, k, axis=-1) / radius
        r2 = np.sum(across**2, axis=-1)
        row = np.insert(-_FOURTH_ORDER * (1.5 * along * r2 - 2.0 * along**3)[..., None] * across, k, 0.0, axis=-1)
        row[..., k] = 1.0 - _FOURTH_ORDER * (along**4 - 3.0 * along**2 * r2 + 0.375 * r2**2)
        rows.append(row)
    return np.stack(rows, axis=-2)
