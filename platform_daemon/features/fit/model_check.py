"""Can it be done at all?  What a schedule asks for is checked before it is kept, long before anything is due."""

from __future__ import annotations

from collections.abc import Sequence

from platform_daemon.core.hardware.engine import Engine

_BARE, _ITS_OWN = "undamped", "magnetic_restoring"  # a declared model that any term but its own can be added to


def check_model(engine: Engine, label: str | None, terms: Sequence[str] = ()) -> None:
    """Is there such a declared or adopted model (None: whatever a recording says), are there such terms?

    Raises InputError, with the names there are.
    """
    from .online import checked_model

    labels = [] if label is None else [label]
    if any(term != _ITS_OWN for term in terms):
        labels.append("+".join((_BARE, *(term for term in terms if term != _ITS_OWN))))
    for each in labels:
        checked_model(each, engine.models)
