"""When a procedure ends early: a rule on a result of its last step."""

from __future__ import annotations

import math
import operator

from drivers.errors import InputError, PlatformError
from platform_daemon.core.schemas.parameters import PARAMETERS
from platform_daemon.features.procedures.schema import StepReport
from platform_daemon.features.procedures.step_report import QUALITIES
from platform_daemon.features.sweep.schema import StopRule

_COMPARISONS = {">": operator.gt, "<": operator.lt, ">=": operator.ge, "<=": operator.le}
_DEGREES = "_deg"


def check_rule(rule: StopRule) -> None:
    """Raises InputError that names the results that exist, if none is called so."""
    if _si_name(rule.result) not in (*PARAMETERS, *QUALITIES):
        raise _unknown(InputError, rule, (*PARAMETERS, *QUALITIES))


def is_met(rule: StopRule, report: StepReport) -> bool:
    """Is the result of the step so?  Not if the step has none, because nothing could be fitted.

    Raises PlatformError for a result that the model of the fits does not have.
    """
    if not report.results:
        return False
    found = report.results.get(_si_name(rule.result))
    if found is None:
        raise _unknown(PlatformError, rule, tuple(report.results))
    value = math.degrees(found.median) if rule.result.endswith(_DEGREES) else found.median
    return bool(_COMPARISONS[rule.comparison](value, rule.value))


def _si_name(name: str) -> str:
    return f"{name.removesuffix(_DEGREES)}_rad" if name.endswith(_DEGREES) else name


def _unknown(kind: type[PlatformError], rule: StopRule, known: tuple[str, ...]) -> PlatformError:
    remedy = f"one of: {', '.join(known)}; angles also in degrees, as phi_max_deg"
    return kind(f"no result is called {rule.result!r}", where="stop_when", remedy=remedy)
