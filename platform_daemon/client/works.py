"""Requests of the client's methods, and the works of schedules, which are the same requests at a later time."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from pydantic import BaseModel

from drivers.errors import InputError
from platform_daemon.core.schemas.requests import AcquisitionRequest, CalibrationRequest
from platform_daemon.features.characterise.schema import CharacteriseRequest
from platform_daemon.features.ramp.schema import RampRequest
from platform_daemon.features.self_test.schema import SelfTestRequest
from platform_daemon.features.sweep.schema import SweepRequest
from platform_daemon.features.tune.schema import TuneRequest

from .requests import axes, request_from

PROCEDURES: dict[str, type[BaseModel]] = {
    "sweep": SweepRequest,
    "tune": TuneRequest,
    "ramp": RampRequest,
    "characterise": CharacteriseRequest,
}
_WORKS: dict[str, tuple[str, type[BaseModel]]] = {
    "measure": ("acquisition", AcquisitionRequest),
    "calibrate": ("calibration", CalibrationRequest),
    "self_test": ("self_test", SelfTestRequest),
    **{name: ("procedure", model) for name, model in PROCEDURES.items()},
}


def procedure_request(kind: str, values: Mapping[str, Any]) -> BaseModel:
    """The request of a procedure of that kind.  Raises InputError."""
    given = dict(values)
    if "over" in given:
        given["over"] = axes(given["over"])
    return request_from(PROCEDURES[kind], {"kind": kind, **given}, kind)


def work_of(works: Mapping[str, Mapping[str, Any] | None]) -> dict[str, Any]:
    """The work of a schedule, from the one method whose arguments are given.  Raises InputError."""
    given = {name: values for name, values in works.items() if values is not None}
    if len(given) != 1:
        remedy = f"give the arguments of one of {', '.join(works)}, as measure={{'resonator': 'jewel', 'shots': 20}}"
        why = f"there are {', '.join(given)}" if given else "there is none"
        raise InputError("a schedule starts one kind of work", where="schedules", why=why, remedy=remedy)
    ((name, values),) = given.items()
    if name == "work":
        return dict(values)
    kind, model = _WORKS[name]
    request = procedure_request(name, values) if kind == "procedure" else request_from(model, values, name)
    return {"kind": kind, "request": request.model_dump()}
