"""Ring-down models as data: torque terms, what is observed, and what is known of the parameters beforehand."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Literal

import numpy as np

from platform_daemon.estimation.numerics.arrays import IntArray

from .torque_term import Coefficient, TorqueTerm
from .torques import BROKEN, TERMS, code_of, is_listed
from .torques.coulomb_friction import COULOMB_FRICTION
from .torques.hertz_friction import HERTZ_FRICTION
from .torques.hertz_friction_under_weight import HERTZ_FRICTION_UNDER_WEIGHT
from .torques.linear_restoring import LINEAR_RESTORING
from .torques.magnetic_restoring import MAGNETIC_RESTORING
from .torques.viscous_damping import VISCOUS_DAMPING

ObservationKind = Literal["by_quantity", "free_gains"]


@dataclass(frozen=True)
class Parameter:
    """What is known of a public parameter before the fit.

    Attributes:
        name: public name, with its unit.
        unit: SI unit as text.
        lower, upper: the model holds strictly between them; a fit significantly outside is refused, never clamped.
        prior: mean and standard deviation of independent knowledge, or None.
        fixed: the value at which it is held unless the caller frees it, or None.
    """

    name: str
    unit: str
    lower: float = -math.inf
    upper: float = math.inf
    prior: tuple[float, float] | None = None
    fixed: float | None = None


_COMMON = (
    Parameter("f_nat_hz", "Hz", lower=0.0),
    Parameter("m_r_am2", "A m^2", lower=0.0),
    Parameter("phi_max_rad", "rad", lower=0.0, upper=math.pi),
    Parameter("psi_start_rad", "rad", lower=0.0, upper=2.0 * math.pi),
    *(Parameter(f"rodrigues_{axis}", "rad") for axis in "xyz"),
)


@dataclass(frozen=True)
class RingDownModel:
    """An equation of motion, the sum of its torque terms (in units of I w^2), and how it is observed.

    Attributes:
        name: identifier.
        terms: the torque terms.
        observation: "by_quantity": through m_r and R for dm/dt and for volts with a sensitivity, through free gains
            for volts without, as it is for an angle. "free_gains": of every channel, whatever is known.
        known: parameters about which more is known than their default.
        alternatives: models of other bearings; one that explains a record far better speaks against this one.
        alternatives_of_angle: the same where an angle is recorded: of a pendulum, whose friction has no Hertz contact.
    """

    name: str
    terms: tuple[TorqueTerm, ...]
    observation: ObservationKind = "by_quantity"
    known: tuple[Parameter, ...] = ()
    alternatives: tuple[str, ...] = ()
    alternatives_of_angle: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        names = [c.name for c in self.coefficients]
        if len(set(self.terms)) < len(self.terms) or len(set(names)) < len(names):
            raise ValueError(f"model {self.name!r} contains a torque term twice")
        frozen = [term.frozen for term in self.terms]
        if frozen != sorted(frozen) or any(term.frozen and not term.timed for term in self.terms):
            raise ValueError(f"model {self.name!r} has a frozen term that is not timed, or not the last one")
        unlisted = [term.name for term in self.terms if not is_listed(term)]
        if unlisted:
            raise ValueError(f"model {self.name!r} has a torque term that is not listed: {unlisted[0]!r}")
        unknown = {p.name for p in self.known} - {p.name for p in self._declared}
        if unknown:
            raise ValueError(f"model {self.name!r} has no parameter {', '.join(sorted(unknown))}")

    def __getstate__(self) -> dict[str, object]:
        """The fields alone: `codes` may hold addresses, which another process must not use."""
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def coefficients(self) -> tuple[Coefficient, ...]:
        """The coefficients of all terms in kernel order."""
        return tuple(c for term in self.terms for c in term.coefficients)

    @cached_property
    def powers(self) -> tuple[int, ...]:
        """c = q / w**power for every coefficient."""
        return tuple(c.power for c in self.coefficients)

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """All public parameters by name; those of the observation apply where there are such."""
        return {p.name: p for p in (*self._declared, *self.known)}

    @property
    def _declared(self) -> tuple[Parameter, ...]:
        """All parameters as every model knows them."""
        own = (
            Parameter(c.name, c.unit, lower=0.0 if c.hidden else -math.inf, fixed=c.typical if c.held else None)
            for c in self.coefficients
        )
        return (*_COMMON, *own)

    @cached_property
    def losses(self) -> tuple[str, ...]:
        """Names of the coefficients that take energy out of the motion where they are positive."""
        return tuple(t.coefficients[0].name for t in self.terms if t.loses_energy)

    @cached_property
    def speeds_of_friction(self) -> tuple[int, ...]:
        """Places of the hidden scales of losses among the coefficients: speeds at which a friction falls."""
        names = [c.name for c in self.coefficients]
        return tuple(names.index(c.name) for t in self.terms if t.loses_energy for c in t.coefficients if c.hidden)

    @cached_property
    def largest_angle_rad(self) -> float:
        """The equation of motion holds for smaller deflections only."""
        return min([math.pi, *(t.below_rad for t in self.terms if t.below_rad is not None)])

    @cached_property
    def codes(self) -> IntArray:
        """Numbers of the terms for the kernel's dispatch, int64 (terms,)."""
        return np.array([code_of(term) for term in self.terms], dtype=np.int64)

    @cached_property
    def widths(self) -> IntArray:
        """Number of coefficients of each term, int64 (terms,)."""
        return np.array([len(term.coefficients) for term in self.terms], dtype=np.int64)

    @cached_property
    def followed(self) -> int:
        """How many coefficients, the first ones, a trajectory has derivatives by."""
        return sum(len(term.coefficients) for term in self.terms if not term.frozen)

    @cached_property
    def time_dependent(self) -> bool:
        """True if a torque depends on time: only the direct path can follow it."""
        return any(term.timed for term in self.terms)

    @cached_property
    def symmetric(self) -> bool:
        """True if the motion to either side is the mirror image of the other."""
        return all(term.symmetric for term in self.terms)

    def with_terms(self, name: str, *terms: TorqueTerm) -> RingDownModel:
        """A model of this name with further terms."""
        return replace(self, name=name, terms=(*self.terms, *terms))

    def under_weight(self, share: float) -> RingDownModel:
        """The model with a Hertz contact that the rotor's weight presses on too, as a share of the magnets' pull.

        The share is held.  The model itself without such a contact, or without a weight along the main axis.
        """
        if share == 0.0 or HERTZ_FRICTION not in self.terms:
            return self
        terms = tuple(HERTZ_FRICTION_UNDER_WEIGHT if term is HERTZ_FRICTION else term for term in self.terms)
        return replace(self, terms=terms, known=(*self.known, Parameter("weight_over_pull", "1", fixed=share)))


_DRY = ("jewel_constant_friction",)
THREAD = RingDownModel(
    "thread", (MAGNETIC_RESTORING, VISCOUS_DAMPING), alternatives=("jewel",), alternatives_of_angle=_DRY
)
JEWEL = RingDownModel("jewel", (MAGNETIC_RESTORING, VISCOUS_DAMPING, HERTZ_FRICTION), alternatives_of_angle=_DRY)
_MODELS = (
    THREAD,
    JEWEL,
    # eq:Jewel_ODE_norm_simp, the approximation that the paper compares with.
    RingDownModel(
        "jewel_constant_friction", (MAGNETIC_RESTORING, VISCOUS_DAMPING, COULOMB_FRICTION), alternatives=("jewel",)
    ),
    # equ:ODE_norm.
    RingDownModel(
        "undamped", (MAGNETIC_RESTORING,), alternatives=("thread", "jewel"), alternatives_of_angle=("thread", *_DRY)
    ),
    # The regime sin(phi) ~ phi of equ:ODE_norm, with the losses of either bearing.
    RingDownModel(
        "undamped_small_angle",
        (LINEAR_RESTORING,),
        alternatives=("thread", "jewel"),
        alternatives_of_angle=("thread", *_DRY),
    ),
    RingDownModel(
        "thread_small_angle",
        (LINEAR_RESTORING, VISCOUS_DAMPING),
        alternatives=("thread", "jewel"),
        alternatives_of_angle=("thread", *_DRY),
    ),
    RingDownModel(
        "jewel_small_angle",
        (LINEAR_RESTORING, VISCOUS_DAMPING, COULOMB_FRICTION),
        alternatives=("jewel",),
        alternatives_of_angle=_DRY,
    ),
)
MODELS = {model.name: model for model in _MODELS}


def model_named(name: str) -> RingDownModel:
    """The declared model of this name, or one with further torque terms, as in "thread+quadratic_drag".

    Raises:
        ValueError: an unknown name, with the known ones, or a term that the model contains already.
    """
    declared, *terms = name.split("+")
    if declared not in MODELS:
        raise ValueError(f"unknown variant {declared!r}: expected one of {', '.join(MODELS)}")
    unknown = [term for term in terms if term not in TERMS]
    if unknown:
        why = f" ({BROKEN[unknown[0]]})" if unknown[0] in BROKEN else ""
        raise ValueError(f"unknown torque term {unknown[0]!r}{why}: expected one of {', '.join(TERMS)}")
    return MODELS[declared].with_terms(name, *(TERMS[term] for term in terms)) if terms else MODELS[declared]


def alternatives_of(model: RingDownModel, quantity: str) -> tuple[RingDownModel, ...]:
    """The declared models that speak against this one if they explain a record of this quantity far better."""
    return tuple(MODELS[name] for name in (model.alternatives_of_angle if quantity == "angle" else model.alternatives))
