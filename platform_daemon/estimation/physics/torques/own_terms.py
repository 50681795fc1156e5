"""Torque terms of other packages, by entry point: each is compiled by itself, so that no kernel is compiled again.

A package names its term in the group `platform_daemon.torque_terms`, under the name of the term.  One that cannot be
used is left out, and an error about its name says why: it must not keep other models from being fitted.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from importlib.metadata import EntryPoint, entry_points

from platform_daemon.estimation.physics.torque_term import TorqueTerm

GROUP = "platform_daemon.torque_terms"
_NAME = re.compile(r"[a-z][a-z0-9_]{0,50}")


def own_terms(known: Iterable[TorqueTerm]) -> tuple[tuple[TorqueTerm, ...], dict[str, str]]:
    """The terms of other packages by their order of names, and why others cannot be used, by name.

    known: the terms of this package, whose names and parameters are taken.
    """
    taken = {name for term in known for name in (term.name, *(c.name for c in term.coefficients))}
    found: list[TorqueTerm] = []
    broken: dict[str, str] = {}
    for entry in sorted(entry_points(group=GROUP), key=lambda entry: entry.name):
        try:
            term = entry.load()
        except Exception as error:  # a foreign module may raise anything
            broken[entry.name] = f"{entry.value} cannot be imported: {error!r}"
            continue
        why = _fault(entry, term, taken)
        if why:
            broken[entry.name] = f"{entry.value}: {why}"
            continue
        found.append(term)
        taken |= {term.name, *(c.name for c in term.coefficients)}
    return tuple(found), broken


def _fault(entry: EntryPoint, term: object, taken: set[str]) -> str:
    """Why it cannot be used; empty: it can."""
    if not isinstance(term, TorqueTerm):
        return f"it is a {type(term).__name__}, and no TorqueTerm"
    if term.name != entry.name or not _NAME.fullmatch(term.name):
        return f"the name of the term, {term.name!r}, must be that of the entry point: small letters, digits, _"
    if not term.coefficients:
        return "it has no coefficient, which a fit could estimate"
    twice = taken & {term.name, *(c.name for c in term.coefficients)}
    return f"{min(twice)!r} is taken: give it another name" if twice else ""
