"""What the schemas say of themselves: descriptions, units, examples."""

from __future__ import annotations

import importlib
import inspect
import json
import pkgutil
import subprocess
import sys
from typing import Any

import pytest

from platform_daemon import schemas
from platform_daemon.schemas.base import Request, Root, Schema, attribute_docstrings, to_json
from platform_daemon.schemas.diagnosis import EffectDetail
from platform_daemon.schemas.jobs import FitJob
from platform_daemon.schemas.problems import Problem
from tests.kit.schema_samples import CLI, REST

MODULES = [importlib.import_module(f"{schemas.__name__}.{m.name}") for m in pkgutil.iter_modules(schemas.__path__)]
MODELS = [
    value
    for module in MODULES
    for name, value in vars(module).items()
    if inspect.isclass(value) and value.__module__ == module.__name__ and not name.startswith("_") and "[" not in name
    if issubclass(value, Schema | Root)
]
TOP = sorted({*CLI.values(), *REST.values()}, key=lambda m: m.__name__)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.__name__)
def test_every_field_is_described(model: type[Schema]) -> None:
    assert (model.__doc__ or "").strip()
    if issubclass(model, Schema):
        missing = set(model.model_fields) - set(attribute_docstrings(model))
        assert not missing


def test_descriptions_reach_the_json_schema() -> None:
    found = FitJob.model_json_schema(mode="serialization")
    assert found["properties"]["created"]["description"] == "When it was asked for, ISO 8601."
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


def test_the_room_needs_pydantic_and_nothing_else() -> None:
    """What a process that owns hardware imports must stay small."""
    heavy = "numpy", "numba", "matplotlib", "fastapi", "scipy", "h5py", "drivers", "sequences"
    modules = ", ".join(m.__name__ for m in MODULES)
    code = f"import sys, {modules}; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
