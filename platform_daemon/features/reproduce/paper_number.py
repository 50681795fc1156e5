"""A number of the paper that is compared."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from .findings import Findings, Value

SHOTS = 100
"""Of each resonator in the paper."""
DESIGN, CHARACTERISE, DEFECTS = "platform-daemon design", "platform-daemon characterise", "platform-daemon defects"
NOISE = "platform-daemon characterise --compare thread.h5 jewel.h5 --noise 0.03:1.5"
Ours = Callable[[Findings], Value | None]
Because = Callable[[Findings, Value], str]


@dataclass(frozen=True)
class PaperNumber:
    """A number or a statement of the paper.

    Attributes:
        label, what, paper: see Claim.
        tolerance: of the paper's part, in its unit; None: of a statement.
        rule: how the tolerance follows, in words.
        ours: takes ours from what was found; it returns None where it was not measured.
        command: that computes it.
        never: why it can never be compared, "": it can.
        missing: takes from what was found why ours is None.
        because: takes from what was found, and ours, why the two differ.
    """

    label: str
    what: str
    paper: float | str
    tolerance: float | None
    rule: str
    ours: Ours
    command: str
    never: str = ""
    missing: Callable[[Findings], str] = lambda found: "it was not measured in this campaign"
    because: Because = lambda found, ours: ""


def printed(
    label: str, what: str, paper: float, ours: Ours, digits: int, command: str, unit_in_last: float = 1.0,
    because: Because = lambda found, ours: "",
) -> PaperNumber:  # fmt: skip
    """A number without an error: half a unit of its last printed digit."""
    tolerance = 0.5 * unit_in_last * 10.0**-digits
    rule = "half a unit of the last printed digit"
    return PaperNumber(label, what, paper, tolerance, rule, ours, command, because=because)


def statement(
    label: str, what: str, paper: str, ours: Ours, command: str, rule: str = "the statement itself",
    because: Because = lambda found, ours: "",
) -> PaperNumber:  # fmt: skip
    """A statement, yes or no."""
    return PaperNumber(label, what, paper, None, rule, ours, command, because=because)


def says(true: bool) -> Value:
    """yes or no."""
    return Value("yes" if true else "no")
