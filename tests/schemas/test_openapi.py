"""What the schemas say of themselves: descriptions, units, examples."""

from __future__ import annotations

import inspect
import json
import subprocess
import sys
from typing import Any

import pytest

from platform_daemon import schemas
from platform_daemon.schemas.base import Root, Schema, attribute_docstrings, to_json

from .samples import CLI, REST

MODELS = [
    value
    for name in schemas.__all__
    if inspect.isclass(value := getattr(schemas, name)) and issubclass(value, Schema | Root) and name != "Root"
]
TOP = sorted({*CLI.values(), *REST.values()}, key=lambda m: m.__name__)


@pytest.mark.parametrize("model", MODELS, ids=lambda m: m.__name__)
def test_every_field_is_described(model: type[Schema]) -> None:
    assert (model.__doc__ or "").strip()
    if issubclass(model, Schema):
        missing = set(model.model_fields) - set(attribute_docstrings(model))
        assert not missing


def test_descriptions_reach_the_json_schema() -> None:
    found = schemas.FitJob.model_json_schema(mode="serialization")
    assert found["properties"]["created"]["description"] == "When it was asked for, ISO 8601."
    frame = found["$defs"]["FrameFit"]["properties"]
    assert frame["nrmse"]["description"].startswith("Root mean square of the residual")
    assert schemas.EffectDetail.model_json_schema()["properties"]["from"]["description"].startswith("Of crosstalk")


def test_a_key_that_may_be_missing_is_never_null() -> None:
    found = schemas.Problem.model_json_schema(mode="serialization")
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


@pytest.mark.parametrize("model", [m for m in MODELS if issubclass(m, schemas.Request)], ids=lambda m: m.__name__)
def test_examples_of_requests(model: type[Any]) -> None:
    for example in model.model_json_schema().get("examples", []):
        assert model.model_validate(example)


def test_the_room_needs_pydantic_and_nothing_else() -> None:
    """What a process that owns hardware imports must stay small."""
    heavy = "numpy", "numba", "matplotlib", "fastapi", "scipy", "h5py", "drivers", "sequences"
    code = f"import sys, platform_daemon.schemas; print([m for m in {heavy!r} if m in sys.modules])"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
