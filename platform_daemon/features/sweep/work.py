"""A sweep: the same acquisition with other values of some keys, all combinations, until a rule ends it."""

from __future__ import annotations

import itertools
from collections.abc import Sequence

from drivers.errors import InputError
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureWork
from platform_daemon.features.procedures.procedure import Step, StepSequence
from platform_daemon.features.procedures.schema import ProcedureResult, SweptValue

from .keys import sweep_key, with_values
from .schema import SweepRequest
from .stop_rule import check_rule, is_met

EVERY_STEP = "every step was made"


class Sweep:
    """See Procedure.  Raises InputError for a key that does not exist or comes twice, a value that cannot be, a rule on
    a result that does not exist or that no fit gives."""

    def __init__(self, request: SweepRequest) -> None:
        self.request = request
        keys = [sweep_key(axis.key) for axis in request.over]
        paths = [key.path for key in keys]
        for axis, path in zip(request.over, paths, strict=True):
            if paths.count(path) > 1:
                what = f"{'.'.join(path)} would be swept twice"
                raise InputError(what, where=axis.key, remedy="name each key once")
        rule = request.stop_when
        if rule is not None:
            check_rule(rule)
            if request.acquisition.window is None and ("window",) not in paths:
                remedy = "ask for a window, or leave stop_when out"
                raise InputError("without on-line fits no result can be looked at", where="stop_when", remedy=remedy)
        self._steps = []
        for k, values in enumerate(itertools.product(*(axis.points for axis in request.over)), start=1):
            named = list(zip(request.over, values, strict=True))
            where = f"step {k} ({', '.join(f'{axis.key} = {value}' for axis, value in named)})"
            made = with_values(request.acquisition, dict(zip(keys, values, strict=True)), where)
            self._steps.append(Step(tuple(SweptValue(key=a.key, value=v) for a, v in named), made, name="sweep"))

    @property
    def title(self) -> str:
        """See Procedure."""
        return f"sweep over {', '.join(axis.key for axis in self.request.over)}"

    @property
    def ends_early(self) -> str | None:
        """See Procedure."""
        return None if self.request.stop_when is None else str(self.request.stop_when)

    @property
    def open_ended(self) -> bool:
        """See Procedure."""
        return False

    @property
    def outcome(self) -> None:
        """See Procedure."""
        return None

    def outline(self) -> Sequence[Step]:
        """See Procedure."""
        return self._steps

    def steps(self) -> StepSequence:
        """See Procedure."""
        rule, without = self.request.stop_when, 0
        for step in self._steps:
            report = yield step
            without += not report.results
            if rule is not None and is_met(rule, report):
                return f"{rule} in step {report.step}"
        if rule is None:
            return EVERY_STEP
        unknown = f" ({without} of {len(self._steps)} steps have no result)" if without else ""
        return f"{EVERY_STEP}; {rule} in none of them{unknown}"

    def conclude(self, job: str, result: ProcedureResult) -> None:
        """See Procedure: all is in the recording."""


def plan(bench: ProcedureBench, request: SweepRequest) -> ProcedureWork:
    """The work of a sweep, every step checked.  Raises InputError."""
    return bench.work(Sweep(request))
