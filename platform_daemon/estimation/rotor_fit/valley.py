"""Damped Gauss-Newton of a rotor's parameters, along the floor of a curved valley."""

from __future__ import annotations

import math
from collections.abc import Sequence
from concurrent.futures import Executor
from dataclasses import dataclass, replace

import numpy as np

from platform_daemon.estimation.numerics.arrays import Array
from platform_daemon.estimation.physics.rigid_rotor.equations import LANES
from platform_daemon.estimation.physics.rigid_rotor.rotor import LostRotorError, NoRestError, RotorValues
from platform_daemon.estimation.thresholds import THRESHOLDS

from .layout import Layout
from .shot import Linearised, RotorShot, all_linearised, residuals
from .way_back import Point, RotorFitError, WayBack, strong_directions

LIMITS = THRESHOLDS.rigid_rotor


def limited_step(matrix: Array, gradient: Array, most: Array) -> Array:
    """The step (size,) that solves matrix @ step = gradient as far as no component is above `most`, (size,).

    A component that would be larger is held there while the others are solved for: cut off alone, it would leave the
    floor of a valley, since the others have gone along with all of it.  Where none is held that should be let go again,
    this is the least of the quadratic within the bounds.

    Raises LinAlgError.
    """
    step, inside = np.zeros(len(most)), np.ones(len(most), dtype=bool)
    while True:
        pull = gradient[inside] - matrix[np.ix_(inside, ~inside)] @ step[~inside]
        step[inside] = np.linalg.solve(matrix[np.ix_(inside, inside)], pull)
        beyond = np.abs(step) > most
        if not beyond.any():
            return step
        step[beyond] = np.copysign(most[beyond], step[beyond])
        inside &= ~beyond


@dataclass(frozen=True, eq=False)
class _Normal:
    """Normal equations of all shots at some values.

    matrix: (size, size) with the weights of what is known beforehand; gradient: (size,); chi2, counts: of each shot;
    total: sum of chi^2 with what is known; by_shot: their linearisations.
    """

    matrix: Array
    gradient: Array
    chi2: list[float]
    counts: list[float]
    total: float
    by_shot: list[Linearised]

    def step(self, damping: float, most: Array) -> tuple[Array, float]:
        """A damped step (size,) with no component above (size,) `most`, and the fall of chi^2 that it promises.

        Raises RotorFitError.
        """
        damped = self.matrix + damping * np.diag(np.diag(self.matrix))
        try:
            step = limited_step(damped, self.gradient, most)
        except np.linalg.LinAlgError:
            raise RotorFitError("the shots do not determine the rotor's parameters") from None
        promised = self._fall(step)
        if promised > 0.0:
            return step, promised
        # Components that were held one after the other may lead up: the whole step, as far as the first bound.
        whole = limited_step(damped, self.gradient, np.full(len(most), np.inf))
        step = whole / max(1.0, float(np.max(np.abs(whole) / most)))
        return step, self._fall(step)

    def held_short(self, step: Array, most: Array) -> bool:
        """A component is at its bound, and the data know it better than that, so that a shorter step is worth a try."""
        try:
            sd = np.sqrt(np.abs(np.diag(np.linalg.inv(self.matrix))))
        except np.linalg.LinAlgError:
            return False
        return bool(np.any((np.abs(step) >= LIMITS.at_bound * most) & (most > sd)))

    def whole_fall(self) -> float:
        """Of chi^2 as a step promises it that is neither damped nor bounded; infinite where there is none."""
        try:
            return float(self.gradient @ np.linalg.solve(self.matrix, self.gradient))
        except np.linalg.LinAlgError:
            return math.inf

    def _fall(self, step: Array) -> float:
        return float(2.0 * self.gradient @ step - step @ self.matrix @ step)


class Valley:
    """Damped Gauss-Newton along the floor of a curved valley.

    The data tell main mode and losses to parts in 10^6, and what goes into them, f_nat and the error, T_f, mu and
    lambda, only together: J^T J, scaled to a unit diagonal, has eigenvalues from 1 to 10^-9.  A step along the weak
    directions climbs the walls long before it ends, since the floor bends: f_nat goes with the square of a tilt.  Each
    trial is therefore led back to the floor by steps along the strong directions alone, which need no other Jacobian,
    and only then compared.  A trial costs a few motions, a Jacobian a quarter as many as there are free parameters.
    """

    def __init__(
        self, shots: Sequence[RotorShot], layout: Layout, first: Sequence[RotorValues], window_s: float
    ) -> None:
        self._shots, self._layout, self._first, self._window_s = shots, layout, first, window_s
        self.beside = LANES if len(shots) == 1 else 1  # trials that take no longer than one

    def linearised(self, values: Sequence[RotorValues], pool: Executor) -> _Normal:
        """Raises RotorFitError."""
        layout = self._layout
        by_shot: list[Linearised] = []
        matrix, gradient = np.zeros((layout.size, layout.size)), np.zeros(layout.size)
        try:
            found = all_linearised(self._shots, values, layout.free, self._window_s, pool)
            for one, places in zip(found, layout.places, strict=True):
                matrix[np.ix_(places, places)] += one.matrix
                gradient[list(places)] += one.gradient
                by_shot.append(one)
        except (NoRestError, LostRotorError) as error:
            raise RotorFitError(str(error)) from None
        weight, pull, known = layout.prior(values, self._first)
        matrix[np.diag_indices(layout.size)] += weight
        chi2 = [one.chi2 for one in by_shot]
        return _Normal(matrix, gradient + pull, chi2, [one.expected for one in by_shot], sum(chi2) + known, by_shot)

    def start(self, values: list[RotorValues], normal: _Normal, pool: Executor) -> Point:
        """Where a fit begins, with the time steps of its trials, which one shot takes by itself as well.

        Raises RotorFitError.
        """
        if len(self._shots) == 1:
            return Point(values, [one.residual for one in normal.by_shot], normal.total)
        found = self._at(values, pool)
        if found is None:
            raise RotorFitError("the rotor with the start values cannot be followed")
        return found

    def trials(
        self, here: Point, steps: Sequence[Array], rooms: Sequence[float], normal: _Normal, pool: Executor
    ) -> tuple[Point | None, int]:
        """Where the first of some steps that leads down ends, back on the floor, and the number of that step.

        None where there is no such rotor.  Of one shot all steps go beside each other, in the lanes of one integration;
        its time steps are short enough for all of them, so that a place hardly depends on the others.

        here: where the steps begin; rooms: of each step, share of the most that a logarithm may change.

        Raises RotorFitError.
        """
        directions = {room: self._strong(room, normal) for room in set(rooms)}
        paths = [
            WayBack(self._layout, normal.total, here.total, *directions[room], self._layout.moved(here.values, step))
            for step, room in zip(steps, rooms, strict=True)
        ]
        for _ in range(1 + LIMITS.most_returns):
            going = [path for path in paths if not path.ended]
            for path, at in zip(going, self._each([path.next_values for path in going], pool), strict=True):
                path.reaches(at, lambda at: self._gradient(at, normal))
            # the first one that leads down counts, so that those after it need not be known
            if next((path for path in paths if not path.ended or path.leads_down), paths[0]).ended:
                break
        first = next((k for k, path in enumerate(paths) if path.leads_down), 0)
        return paths[first].best, first

    def _strong(self, room: float, normal: _Normal) -> tuple[Array, Array]:
        """Raises RotorFitError."""
        share = LIMITS.strong_share if len(self._shots) == 1 else LIMITS.strong_share_of_several
        # Of what the data tell too little to bound its steps, a return gives only a small part.
        return strong_directions(normal.matrix + np.diag((room * self._layout.most_step) ** -2.0), share)

    def _each(self, places: Sequence[list[RotorValues]], pool: Executor) -> list[Point | None]:
        """Of several places; None where the rotor cannot be followed."""
        if len(self._shots) > 1 or len(places) == 1:
            return [self._at(values, pool) for values in places]
        try:
            left = residuals([*self._shots] * len(places), [v for (v,) in places], self._window_s, pool)
        except (NoRestError, LostRotorError):  # one of them
            return [self._at(values, pool) for values in places]
        return [self._point(values, [one]) for values, one in zip(places, left, strict=True)]

    def _at(self, values: list[RotorValues], pool: Executor) -> Point | None:
        try:
            left = residuals(self._shots, values, self._window_s, pool)
        except (NoRestError, LostRotorError):
            return None
        return self._point(values, left)

    def _point(self, values: list[RotorValues], left: list[Array]) -> Point:
        known = self._layout.prior(values, self._first)[2]
        return Point(values, left, sum(float(r @ r) for r in left) + known)

    def _gradient(self, at: Point, normal: _Normal) -> Array:
        """By the Jacobian of another point."""
        out = self._layout.prior(at.values, self._first)[1]
        for one, residual, places in zip(normal.by_shot, at.left, self._layout.places, strict=True):
            out[list(places)] += one.columns @ residual.astype(np.float32)
        return out


@dataclass
class _Caution:
    """How the steps of a fit are held back by what trials have shown of the valley's bend.

    first: damping with which it began; damping: of the next step; room: share of the most that a logarithm may change.
    """

    first: float
    damping: float
    room: float = 1.0

    @property
    def none(self) -> bool:
        """Steps are held back no more than the first one was."""
        return self.damping <= self.first and self.room == 1.0

    def after_failure(self, grows: float, short: bool) -> _Caution:
        """More of it; grows: of the damping; short: a component was held at its bound, which is made smaller first."""
        if short and self.room > LIMITS.least_room:
            return replace(self, room=self.room * LIMITS.room_falls)
        return replace(self, damping=self.damping * grows)

    def eased(self, least: float) -> None:
        """Once less of it; least: of the damping."""
        self.damping = max(LIMITS.damping_falls * self.damping, least)
        self.room = min(1.0, self.room / LIMITS.room_falls)


def _led_down(
    valley: Valley,
    here: Point,
    normal: _Normal,
    widest: Array,
    caution: _Caution,
    ends: tuple[float, float],
    pool: Executor,
) -> tuple[Point | None, float, bool]:
    """Where a trial leads that lowers chi^2, None: none does; the fall that it promised; it was the first one.

    Of one shot so many are tried at once as go beside each other, each with the caution that the failure of the one
    before would teach.

    widest: by how much a step may move each parameter, (size,); caution: of the first one, and then of the one that was
    taken; ends: promised falls below which no trial is worth while, and below which none is after a failure.
    """
    on_floor = normal.total < LIMITS.floor_chi2_per_dof * sum(normal.counts)
    more, first, grows = caution, True, LIMITS.damping_grows
    while True:
        tried = list[tuple[_Caution, Array, float]]()
        while len(tried) < valley.beside and more.damping < LIMITS.most_damping:
            try:
                step, promised = normal.step(more.damping, more.room * widest)
            except RotorFitError:
                if not tried:
                    raise
                break
            if not promised > ends[0]:
                break
            tried.append((more, step, promised))
            if promised < ends[1]:
                break
            damping = more.damping
            more = more.after_failure(grows, on_floor and normal.held_short(step, more.room * widest))
            grows *= 2.0 if more.damping > damping else 1.0
        if not tried:
            return None, 0.0, False
        reached, k = valley.trials(here, [s for _, s, _ in tried], [c.room for c, _, _ in tried], normal, pool)
        if reached is not None and reached.total < here.total:
            caution.damping, caution.room = tried[k][0].damping, tried[k][0].room
            return reached, tried[k][2], first and k == 0
        if tried[-1][2] < ends[1]:
            return None, 0.0, False
        first = False


def settled(
    shots: Sequence[RotorShot],
    layout: Layout,
    values: list[RotorValues],
    first: Sequence[RotorValues],
    window_s: float,
    last: bool,
    pool: Executor,
    to_beat: float = math.inf,
    *,
    left_chi2: float = LIMITS.found_chi2,
) -> tuple[list[RotorValues], Array, list[float], list[float]]:
    """Values, J^T J, chi^2 and degrees of freedom of each shot, where chi^2 of a window falls no more.

    last: no longer window follows, and the fit is not only to be compared; to_beat: chi^2 above which the fit is of no
    use, which ends at once where the first whole step does not promise to come near it; left_chi2: predicted fall at
    which it ends, also where a step brought all but so much of what the whole one promised, if that was little (in the
    last window a step of about a standard error, since J^T J is that of the place before).

    Where trials had to be damped more before one led down, the next step keeps that damping, since the valley bends as
    much there; where the first one leads down, the next step is damped less.  The same holds for the room that
    logarithms have, which is made smaller first where one at its bound may be why a trial failed.

    Where a step that is held back promises too little, or does not lead down, one that is less held back is tried
    before the fit ends.

    Raises RotorFitError, also above `to_beat`; the fit ends where steps as good as the last one will not lead below.
    """
    most_steps = LIMITS.most_steps if last else LIMITS.few_steps
    # By how much chi^2 moves with the time steps that motions choose: one such failure more tells nothing.
    chance_chi2 = LIMITS.settled_chi2 * math.sqrt(len(shots))
    valley = Valley(shots, layout, first, window_s)
    here: Point | None = None
    first_damping = LIMITS.first_damping if len(shots) == 1 else LIMITS.first_damping_of_several
    caution = _Caution(first_damping, first_damping)
    for left in reversed(range(most_steps)):
        normal = valley.linearised(values, pool)
        matrix, counts = normal.matrix, normal.counts
        here = here or valley.start(values, normal, pool)
        begins = left == most_steps - 1
        if begins and here.total - LIMITS.surely_falls * max(0.0, normal.whole_fall()) > to_beat:
            break
        # Far from the floor no step is more than a direction, and the others need not go along.
        near = normal.total < LIMITS.near_chi2_per_dof * sum(counts)
        widest = layout.most_step if near else np.full(layout.size, np.inf)
        # A step that is held back says nothing of what is left.
        fewest = max(left_chi2, chance_chi2)
        while not caution.none and normal.step(caution.damping, caution.room * widest)[1] < fewest:
            caution.eased(first_damping)
        freely = caution.none
        ends = left_chi2, chance_chi2
        reached, promised, at_once = _led_down(valley, here, normal, widest, caution, ends, pool)
        while reached is None and not caution.none:  # so short a step may fail by chance
            caution.eased(first_damping)
            freely = caution.none
            reached, promised, at_once = _led_down(valley, here, normal, widest, caution, ends, pool)
        if reached is None:
            break
        values, fall, here = reached.values, here.total - reached.total, reached
        small = max(fall, LIMITS.good_fall * promised) < left_chi2
        told = not at_once or freely  # a larger step was tried
        kept = fall < (chance_chi2 if last else LIMITS.kept_chi2) and abs(normal.whole_fall() - fall) < left_chi2
        if (small and told) or kept:
            break
        if at_once and (small or fall > LIMITS.good_fall * promised):
            caution.eased(LIMITS.least_damping_share * first_damping)
        if told and caution.room == 1.0 and reached.total - left * fall > to_beat:
            break
        del normal  # before the next one, which is as large
    assert here is not None
    chi2 = [float(r @ r) for r in here.left]
    if sum(chi2) + layout.prior(values, first)[2] > to_beat:
        raise RotorFitError(f"another rotor explains the first {window_s:.3g} s better")
    own = layout.size / len(shots)
    return values, matrix, chi2, [count - own for count in counts]
