"""The law of a jewel's contact."""

from __future__ import annotations

from typing import NamedTuple


class ContactLaw(NamedTuple):
    """What `RotorValues` has of it: how it creeps, and whether slip and spin share the friction of one disc."""

    creep_law: float
    contact_coupling: float
