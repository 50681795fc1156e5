"""Losses that are held at a known value, but only where the window cannot tell them from the others."""

from __future__ import annotations

from collections.abc import Mapping

from ..least_squares.constraints import held
from ..physics.models import RingDownModel
from ..refusal import Refusal
from ..result import FitResult


def holdable_losses(
    model: RingDownModel, hold_if_inseparable: Mapping[str, float] | None, fixed: Mapping[str, float], *, dipole: bool
) -> dict[str, float]:
    """Of the values to hold, those that can matter: of losses that are fitted beside another one, in the model's order.

    Raises:
        ValueError: a value for something that is no loss of the model, or a value that cannot be held.
    """
    values = hold_if_inseparable or {}
    for name in values:
        if name not in model.losses:
            raise ValueError(f"no hint can be given for {name}: the losses of {model.name} are {model.losses}")
    held(model, values, dipole=dipole)
    free = [name for name in model.losses if name not in fixed]
    return {name: values[name] for name in free if name in values and len(free) > 1}


def loss_to_hold(result: FitResult, known: Mapping[str, float]) -> dict[str, float]:
    """The one value that a result needs: of a loss that was not told from another, or where losses came out absurd."""
    absurd = result.code is Refusal.OUT_OF_RANGE
    needed = [name for name in known if absurd or name in result.inseparable]
    return {name: known[name] for name in needed[:1]}


def held_loss_notes(used: Mapping[str, float]) -> tuple[str, ...]:
    """What was done."""
    return tuple(f"hint used: {name} held at {v:g}, the window cannot tell it" for name, v in used.items())
