"""What the schemas say of themselves: descriptions, units, examples."""

from __future__ import annotations

import ast
import importlib
import inspect
import json
import pkgutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import platform_daemon
from platform_daemon.core import schemas
from platform_daemon.core.jobs.kinds import job_type
from platform_daemon.core.schemas.base import Request, Root, Schema, attribute_docstrings, to_json
from platform_daemon.core.schemas.problems import Problem
from platform_daemon.diagnosis.report_schema import EffectDetail
from tests.kit.schema_samples import CLI, REST

FEATURES = Path(platform_daemon.__file__).parent / "features"
CORE = [f"{schemas.__name__}.{m.name}" for m in pkgutil.iter_modules(schemas.__path__)]
OF_FEATURES = [
    ".".join(("platform_daemon.features", *file.relative_to(FEATURES).with_suffix("").parts))
    for file in sorted(FEATURES.rglob("*schema.py"))
]
NAMES = [*CORE, *OF_FEATURES, "platform_daemon.diagnosis.report_schema"]
MODULES = [importlib.import_module(name) for name in NAMES]
MODELS = [
    value
    for module in MODULES
    for name, value in vars(module).items()
    if inspect.isclass(value) and value.__module__ == module.__name__ and not name.startswith("_")
    if "[" not in value.__name__
    if issubclass(value, Schema | Root)
]
TOP = sorted({*CLI.values(), *REST.values()}, key=lambda m: m.__name__)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.__name__)
def test_every_field_is_described(model: type[Schema]) -> None:
    assert (model.__doc__ or "").strip()
    if issubclass(model, Schema):
        missing = set(model.model_fields) - set(attribute_docstrings(model))
        assert not missing


@pytest.mark.parametrize("model", [m for m in MODELS if issubclass(m, Schema)], ids=lambda m: m.__name__)
def test_the_key_of_an_id_is_id(model: type[Schema]) -> None:
    keys = {text for name, info in model.model_fields.items() for text in (name, info.alias, info.serialization_alias)}
    assert "identifier" not in keys


def test_descriptions_reach_the_json_schema() -> None:
    found = job_type("fit").model_json_schema(mode="serialization")
    assert found["properties"]["created"]["description"] == "When it was requested, ISO 8601."
    frame = found["$defs"]["FrameFit"]["properties"]
    assert frame["nrmse"]["description"].startswith("Root mean square of the residual over that of the signal")
    assert EffectDetail.model_json_schema()["properties"]["from"]["description"].startswith("Of crosstalk")


def test_a_key_that_may_be_missing_is_never_null() -> None:
    found = Problem.model_json_schema(mode="serialization")
    assert found["required"] == ["type", "title", "status"]
    assert found["properties"]["where"]["type"] == "string"
    assert "default" not in found["properties"]["where"]


@pytest.mark.parametrize("model", TOP, ids=lambda m: m.__name__)
def test_every_answer_has_an_example_that_is_one(model: type[Any]) -> None:
    examples = model.model_json_schema(mode="serialization")["examples"]
    assert examples
    for example in examples:
        made = model.model_validate_json(json.dumps(example))
        assert json.loads(to_json(made)) == example


@pytest.mark.parametrize("model", [m for m in MODELS if issubclass(m, Request)], ids=lambda m: m.__name__)
def test_examples_of_requests(model: type[Any]) -> None:
    for example in model.model_json_schema().get("examples", []):
        assert model.model_validate(example)


def test_every_schema_stands_where_these_tests_look() -> None:
    """Also those that other modules make of them for a kind of job, and those of modules that are imported here."""
    todo, found = [Schema, Root], set()
    while todo:
        model = todo.pop()
        todo.extend(model.__subclasses__())
        found.add(model.__module__)
    assert {name for name in found if name.startswith("platform_daemon")} <= {*NAMES, job_type.__module__}


@pytest.mark.parametrize(
    ("names", "drivers"), [(CORE, set()), (OF_FEATURES, {"drivers", "drivers.errors"})], ids=["core", "features"]
)
def test_schemas_need_pydantic_and_nothing_else(names: list[str], drivers: set[str]) -> None:
    """What a process that owns hardware imports must stay small; the folder of a feature knows the base of errors."""
    heavy = "numpy", "numba", "matplotlib", "fastapi", "scipy", "h5py", "sequences"
    code = f"import sys, {', '.join(names)}; print([m for m in sys.modules if m.partition('.')[0] in {heavy!r}])"
    code += "; print([m for m in sys.modules if m.partition('.')[0] == 'drivers'])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    found, of_drivers = done.stdout.splitlines()
    assert found == "[]"
    assert set(ast.literal_eval(of_drivers)) == drivers
