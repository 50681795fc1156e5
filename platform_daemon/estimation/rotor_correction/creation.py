"""The correction, from rotors that are drawn about a reference, and its error, from those that were held out."""

from __future__ import annotations

import math
import os
import warnings
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace

import numpy as np
from scipy.stats import qmc

from platform_daemon.estimation.noise.model import NoiseModel
from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.numerics.blas_threads import one_thread_for_products
from platform_daemon.estimation.parameters import RODRIGUES
from platform_daemon.estimation.physics.models import RingDownModel
from platform_daemon.estimation.physics.rigid_rotor.equations import LANES
from platform_daemon.estimation.physics.rigid_rotor.geometry import RotorGeometry
from platform_daemon.estimation.physics.rigid_rotor.motions import motions_beside
from platform_daemon.estimation.physics.rigid_rotor.rotor import (
    CoilDrive,
    LostRotorError,
    NoRestError,
    RigidRotor,
    RotorValues,
)
from platform_daemon.estimation.physics.rotation import rotation_from_rodrigues
from platform_daemon.estimation.physics.trajectory.direct import LostTrajectoryError
from platform_daemon.estimation.record import RingDownRecord
from platform_daemon.estimation.refusal import RefusedError
from platform_daemon.estimation.screening.windows import Window
from platform_daemon.estimation.solve import FAILURES
from platform_daemon.estimation.thresholds import THRESHOLDS

from .coordinates import TURNS, OneAngle, OneAngleCoordinates, RotorCoordinates
from .corrected_fit import coarse_window_s, corrected_fit
from .descent import smooth_fit
from .held import covariance_of_held
from .motion import BETWEEN, THIN, dm_dt_of, harmonics_of, motion, slow_harmonics
from .polynomial import Box, Polynomial
from .table import CONSTANTS, CorrectionTable, Place

LIMITS = THRESHOLDS.rotor_correction


class NoTableError(ArithmeticError):
    """The rotors about the reference cannot be followed, or not fitted."""


@dataclass(frozen=True, eq=False, kw_only=True)
class TableBasis:
    """What a table is made of.

    Attributes:
        model: of one angle, with the weight that it knows.
        reference: about which rotors are drawn, with what an adopted model holds.
        drive: of the sequence.
        rate_hz, samples, first: of the RX window, and its first sample that is fitted.
        window_s: over which the errors of what is held count; None: all of it.
        held_names, held_covariance: of parameters that the adopted model holds; (), None: not known.
    """

    model: RingDownModel
    geometry: RotorGeometry
    reference: RotorValues
    drive: CoilDrive
    rate_hz: float
    samples: int
    first: int = 0
    window_s: float | None = None
    held_names: tuple[str, ...] = ()
    held_covariance: Array | None = None


@dataclass(frozen=True, eq=False)
class _Drawn:
    """A rotor, its dm/dt, the fits of its first window and of its whole ring-down, and how long that is."""

    place: Place
    dm_dt: Array
    early: OneAngle
    whole: OneAngle
    window_s: float


def make_table(basis: TableBasis, window: Window = "d30") -> CorrectionTable:
    """The correction; takes seconds to a minute.  window: of the fits that tell its error.  Raises NoTableError."""
    one_thread_for_products()
    rotors = RotorCoordinates(basis.reference)
    with ThreadPoolExecutor(os.cpu_count()) as pool:
        places = _places(rotors)
        motions = _motions(basis, rotors, places, pool)
        coordinates = _coordinates(basis, motions[0])

        def drawn(k: int) -> _Drawn:
            return _fitted(basis, coordinates, places[k], motions[k])

        try:
            found = list(pool.map(drawn, range(len(places))))
        except (RefusedError, LostTrajectoryError, *FAILURES) as error:
            raise NoTableError(f"a rotor about the reference cannot be fitted: {error}") from None
        known = [each for k, each in enumerate(found) if k % LIMITS.held_out or not k]
        table = _regressed(basis, rotors, coordinates, known, pool)
        unknown = [each for k, each in enumerate(found) if not k % LIMITS.held_out and k]
        table = replace(table, held=covariance_of_held(basis, table.names, pool))
        return _with_error(table, basis, unknown, window)


def _places(rotors: RotorCoordinates) -> list[Place]:
    """The reference, and rotors evenly spread about it (Sobol's sequence)."""
    centre, half = rotors.centre(), _half_widths(rotors)
    count = LIMITS.draws_jewel if rotors.jewel else LIMITS.draws_thread
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # a number that is no power of two: spread evenly enough
        spread = 2.0 * qmc.Sobol(centre.size, seed=1).random(count - 1) - 1.0
    vectors = np.concatenate([centre[None], centre + half * spread])
    return [Place(vector=vector, m_r_am2=rotors.reference.m_r_am2) for vector in vectors]


def _half_widths(rotors: RotorCoordinates) -> Array:
    reference = rotors.reference
    jewel = rotors.jewel
    turn = LIMITS.turn_rad_jewel if jewel else LIMITS.turn_rad_thread
    lambda_share = LIMITS.lambda_share_jewel if jewel else LIMITS.lambda_share_thread
    size = LIMITS.size_ln_jewel if jewel else LIMITS.size_ln_thread
    friction = [LIMITS.friction_ln] if jewel else []
    by_constants = [LIMITS.f_nat_share * reference.f_nat_hz, lambda_share * reference.lambda_per_s]
    return np.array([*by_constants, *friction, size, LIMITS.delay_s, *([turn] * TURNS)])


def _motions(
    basis: TableBasis, rotors: RotorCoordinates, places: Sequence[Place], pool: ThreadPoolExecutor
) -> list[Array]:
    """dm/dt (3, n) of each.  Each jewel takes its own steps: its friction changes sign at times of its own."""
    lanes = 1 if rotors.jewel else LANES
    groups = [places[k : k + lanes] for k in range(0, len(places), lanes)]

    def moved(group: Sequence[Place]) -> list[Array | None]:
        values = [rotors.values(each.vector, each.m_r_am2) for each in group]
        made = [RigidRotor(basis.geometry, each, basis.drive) for each in values]
        return motions_beside(made, basis.samples, basis.rate_hz)[0]

    try:
        found = [motion for group in pool.map(moved, groups) for motion in group]
    except (NoRestError, LostRotorError) as error:
        raise NoTableError(str(error)) from None
    followed = [motion for motion in found if motion is not None]
    if len(followed) < len(found):
        raise NoTableError("the motion of a rotor about the reference runs away")
    return followed


def _coordinates(basis: TableBasis, reference: Array) -> OneAngleCoordinates:
    """About the orientation of the reference and its start phase."""
    values = _fit(basis, reference, coarse_window_s(basis.model), LIMITS.coarse_noise_share)
    about = OneAngleCoordinates(basis.model, basis.reference.rotation, values["psi_start_rad"])
    rotation = rotation_from_rodrigues(np.array([values[name] for name in RODRIGUES]))
    if (about.rotation.T @ rotation)[2, 2] < 0.0:
        return replace(about, psi_rad=(about.psi_rad + np.pi) % (2.0 * np.pi))
    return about


def _fit(basis: TableBasis, dm_dt: Array, window_s: float, share: float) -> dict[str, float]:
    record = RingDownRecord(dm_dt, basis.rate_hz, "dmdt", valid_from=basis.first)
    return smooth_fit(record, basis.model, window_s, share)


def _fitted(basis: TableBasis, coordinates: OneAngleCoordinates, place: Place, dm_dt: Array) -> _Drawn:
    window_s = _window_s(dm_dt, basis.rate_hz, basis.reference.f_nat_hz)
    early = _fit(basis, dm_dt, coarse_window_s(basis.model), LIMITS.coarse_noise_share)
    whole = _fit(basis, dm_dt, window_s, LIMITS.gauge_noise_share)
    return _Drawn(place, dm_dt, coordinates.of(early), coordinates.of(whole), window_s)


def _window_s(dm_dt: Array, rate_hz: float, f_nat_hz: float) -> float:
    """When the swing has decayed, without the steps of a window that ends with a peak; or the end."""
    block = round(LIMITS.envelope_periods * rate_hz / f_nat_hz)
    count = dm_dt.shape[1] // block
    strongest = dm_dt[int(np.argmax(np.mean(dm_dt**2, axis=1)))]
    envelope = np.abs(strongest[: count * block]).reshape(count, block).max(axis=1)
    level = LIMITS.decayed_share * envelope[0]
    below = np.flatnonzero(envelope < level)
    if below.size == 0:
        return dm_dt.shape[1] / rate_hz
    k = int(below[0])
    share = (envelope[k - 1] - level) / (envelope[k - 1] - envelope[k])
    return float((k - 0.5 + share) * block / rate_hz)


def _regressed(
    basis: TableBasis,
    rotors: RotorCoordinates,
    coordinates: OneAngleCoordinates,
    drawn: Sequence[_Drawn],
    pool: ThreadPoolExecutor,
) -> CorrectionTable:
    """The table without its error."""
    vectors = np.array([each.place.vector for each in drawn])
    box = Box.around(vectors, rotors.bent)
    own = np.log([each.place.m_r_am2 for each in drawn])

    def biased(seen: Sequence[OneAngle]) -> Array:
        moments = np.log([each.m_r_am2 for each in seen]) - own
        return np.column_stack([[each.vector for each in seen], moments])

    early, whole = biased([d.early for d in drawn]), biased([d.whole for d in drawn])
    to_one_angle = Polynomial.fitted(box, vectors, whole)
    beside = np.array([to_one_angle.at(vector) for vector in vectors])
    bent = rotors.bent
    early_box, beside_box = Box.around(early[:, :-1], bent), Box.around(beside[:, :-1], bent)
    longest_s = max(each.window_s for each in drawn)
    samples = min(basis.samples, round(LIMITS.kept_share * longest_s * basis.rate_hz))
    thin = -(-samples // THIN) + 1

    def slow(k: int) -> Array:
        at = OneAngle(beside[k, :-1], drawn[k].place.m_r_am2 * float(np.exp(beside[k, -1])))
        dynamics = coordinates.dynamics(at)
        swing = motion(coordinates, dynamics, thin, THIN / basis.rate_hz)
        dm_dt, phase = dm_dt_of(coordinates, at, dynamics, *swing), harmonics_of(*swing)
        here = drawn[k].dm_dt[:, ::THIN][:, :thin]
        n = here.shape[1]
        return slow_harmonics((here - dm_dt[:, :n]) / at.m_r_am2, phase[:, :n])

    try:
        harmonics = np.array(list(pool.map(slow, range(len(drawn)))))
    except (ValueError, LostTrajectoryError) as error:
        raise NoTableError(f"no motion of one angle goes beside the rotor: {error}") from None
    low, high = rotors.centre() - _half_widths(rotors), rotors.centre() + _half_widths(rotors)
    constants = [name for name in CONSTANTS if rotors.jewel or name != "tf_over_i_rad_per_s2"]
    return CorrectionTable(
        coordinates=coordinates,
        rate_hz=basis.rate_hz,
        samples=samples,
        to_rotor=Polynomial.fitted(early_box, early[:, :-1], np.column_stack([vectors, -early[:, -1]])),
        window_s=Polynomial.fitted(box, vectors, np.array([each.window_s for each in drawn])),
        to_one_angle=to_one_angle,
        from_one_angle=Polynomial.fitted(beside_box, beside[:, :-1], np.column_stack([vectors, -beside[:, -1]])),
        harmonics=_by_node(box, vectors, harmonics, [each.window_s for each in drawn], THIN * BETWEEN / basis.rate_hz),
        names=(*constants, "turn_u_rad", "turn_v_rad", "turn_w_rad"),
        start=drawn[0].early,
        low=low,
        high=high,
        reference_friction=rotors.reference.tf_over_i_rad_per_s2,
    )


def _by_node(box: Box, vectors: Array, harmonics: Array, windows_s: Sequence[float], step_s: float) -> Polynomial:
    """Harmonics (m, nodes, 3, k); at each node those of rotors that still swing count."""
    parts = []
    for node in range(harmonics.shape[1]):
        late = LIMITS.late_share * np.array(windows_s) < node * step_s
        weights = np.where(late, LIMITS.late_weight, 1.0)
        parts.append(Polynomial.fitted(box, vectors, harmonics[:, node], weights).coefficients)
    return Polynomial(box, np.stack(parts, axis=1).astype(np.float32))


def _with_error(
    table: CorrectionTable, basis: TableBasis, unknown: Sequence[_Drawn], window: Window
) -> CorrectionTable:
    """The table with its error: corrected fits of rotors that it was not made from, without noise, less the rotors."""
    sd = np.full(3, LIMITS.noise_share * float(np.sqrt(np.mean(unknown[0].dm_dt[:, : table.samples] ** 2))))
    noise = NoiseModel.white(sd, basis.rate_hz)
    none = np.zeros(len(table.names))
    blank, rows, left = replace(table, error=none, worst=none + math.inf, left_share=math.inf), [], 0.0
    for each in unknown:
        record = RingDownRecord(each.dm_dt, basis.rate_hz, "dmdt", valid_from=basis.first)
        fit = corrected_fit(record, window, noise, blank)
        if fit.verdict != "good":
            raise NoTableError(f"a rotor near the reference is refused: {fit.reason}")
        true = table.values(each.place)
        seen = {name: estimate.value for name, estimate in fit.parameters.items()}
        turns = table.coordinates.of(seen).vector[-TURNS:]
        found = [seen[name] for name in table.names if name in seen] + turns.tolist()
        left = max(left, fit.nrmse or 0.0)
        rows.append(np.array(found) - np.array(list(true.values())))
    off = np.array(rows)
    return replace(table, left_share=left, error=np.sqrt(np.mean(off**2, axis=0)), worst=np.abs(off).max(axis=0))
