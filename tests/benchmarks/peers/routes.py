"""All rows by name, and one of them on one dataset."""

from __future__ import annotations

import importlib
import os
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

from tests.benchmarks.peers import narmax, neural, operon, ours, sindy, viscous, weak_form
from tests.benchmarks.peers.columns import Model, effects_named
from tests.benchmarks.peers.datasets import Task
from tests.benchmarks.peers.score import Score, score

FLOOR, TRUE, OURS = "viscous floor", "true model", "ours"

REFITTED = ("PySINDy physical columns refitted", "weak form refitted")
_REFITTED = (
    "its terms beside the declared ones, all coefficients fitted again as the floor finds its own: two tools in a row"
)


@dataclass(frozen=True)
class Row:
    """What came out: errors (None: no result), names, losses with a sign that feeds the motion, processor seconds.

    seconds: of finding the model; scoring: of its start's fit and the simulation.
    """

    route: str
    dataset: str
    train: float | None
    held_out: float | None
    named: tuple[str, ...] = ()
    alike: tuple[str, ...] = ()
    unphysical: tuple[str, ...] = ()
    seconds: float = 0.0
    scoring: float = 0.0
    remark: str = ""

    def as_json(self) -> dict[str, Any]:
        """For the journal."""
        return asdict(self)


@dataclass(frozen=True)
class Found:
    """model or score: what a route found. names: it gives terms a name."""

    model: Model | None = None
    score: Score | None = None
    names: bool = True
    named: tuple[str, ...] | None = None
    alike: tuple[str, ...] = ()
    remark: str = ""


@dataclass(frozen=True)
class Route:
    """One row of the table. package: what it imports, loaded before the clock starts."""

    name: str
    run: Callable[[Task], Found]
    settings: str
    package: str | None = None


def processor_s() -> float:
    """Of this process and of those it waited for."""
    t = os.times()
    return t.user + t.system + t.children_user + t.children_system


@dataclass(frozen=True)
class Boxes:
    """Time boxes of the rows that end by the clock, s."""

    network: float = 120.0
    formula: float = 30.0
    refit: float = 120.0


SHOT_BOXES = Boxes(15.0, 10.0, 60.0)


def routes(boxes: Boxes) -> tuple[Route, ...]:
    """In the order of the tables."""

    def network(task: Task) -> Found:
        model, steps = neural.neural_rest(task, boxes.network)
        return Found(model, names=False, remark=f"{steps} steps")

    def formula(task: Task) -> Found:
        model, text = operon.residual_formula(task, boxes.formula)
        return Found(model, remark=text)

    def diagnosis(task: Task) -> Found:
        s = ours.diagnosed(task)
        return Found(s.model, named=s.named, alike=s.alike, remark="; ".join(filter(None, (s.verdict, s.remark))))

    def of(fit: Callable[[Task], Model]) -> Callable[[Task], Found]:
        return lambda task: Found(fit(task))

    def refitted(fit: Callable[[Task], Model]) -> Callable[[Task], Found]:
        def run(task: Task) -> Found:
            named = [n for n, c in fit(task).terms.items() if c != 0.0 and n not in ("sine", *task.declared)]
            return Found(viscous.fit_declared(task, named, boxes.refit))

        return run

    return (
        Route(FLOOR, of(viscous.fit_declared), viscous.SETTINGS),
        Route(TRUE, of(viscous.fit_true), "the same with the hidden torque, known: the noise of the shot is left over"),
        Route("PySINDy as shipped", of(sindy.as_shipped), sindy.SHIPPED, "pysindy"),
        Route("PySINDy unit rms", of(sindy.unit_rms), sindy.UNIT_RMS, "pysindy"),
        Route("PySINDy physical columns", of(sindy.unit_rms_physical), sindy.UNIT_RMS_PHYSICAL, "pysindy"),
        Route("weak form", of(weak_form.energy_balance), weak_form.SETTINGS, "pysindy"),
        Route(REFITTED[0], refitted(sindy.unit_rms_physical), _REFITTED, "pysindy"),
        Route(REFITTED[1], refitted(weak_form.energy_balance), _REFITTED, "pysindy"),
        Route("pyoperon", formula, operon.SETTINGS, "pyoperon.sklearn"),
        Route(
            "sysidentpy NAR",
            lambda task: Found(score=narmax.free_run(task), names=False),
            narmax.SETTINGS,
            "sysidentpy.model_structure_selection",
        ),
        Route("UDE (jax)", network, neural.SETTINGS, "optax"),
        Route(OURS, diagnosis, ours.SETTINGS),
    )


def measure(route: Route, task: Task) -> Row:
    """One row on one dataset; what fails says so."""
    if route.package is not None:
        importlib.import_module(route.package)
    began = processor_s()
    wall = time.monotonic()
    try:
        found = route.run(task)
        seconds, began = processor_s() - began, processor_s()
        result = found.score if found.model is None else score(found.model, task)
    except Exception as error:  # a peer may end in any way; the table goes on
        why = f"{type(error).__name__}: {error}".splitlines()[0][:160]
        return Row(route.name, task.name, None, None, seconds=time.monotonic() - wall, remark=why)
    named = found.named
    unphysical: tuple[str, ...] = ()
    if found.model is not None and found.names:
        unphysical = found.model.unphysical()
        named = effects_named(found.model.terms, task.declared) if named is None else named
    return Row(
        route.name, task.name, None if result is None else result.train, None if result is None else result.held_out,
        named or (), found.alike, unphysical, seconds, processor_s() - began, found.remark,
    )  # fmt: skip
