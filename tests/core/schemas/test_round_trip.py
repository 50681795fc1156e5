"""Real output of the daemon from before its results had types comes out of the schemas as it went in."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import pytest

from platform_daemon.core.schemas.base import Root, Schema, to_json
from platform_daemon.core.schemas.fits import LedgerLine
from tests.kit.schema_samples import CLI, FOLDER, REORDERED, REST, STORED, text_of


def indented(model: Any) -> str:
    return to_json(model, indent=1)


def as_fastapi(model: Any) -> str:
    return str(model.model_dump_json())


CASES = [
    *(("cli", name, kind, indented) for name, kind in CLI.items()),
    *(("stored", name, kind, indented) for name, kind in STORED.items()),
    *(("rest", name, kind, as_fastapi) for name, kind in REST.items()),
]


@pytest.mark.parametrize(("folder", "name", "kind", "write"), CASES, ids=[f"{c[0]}/{c[1]}" for c in CASES])
def test_byte_for_byte(folder: str, name: str, kind: type[Schema | Root], write: Callable[[Any], str]) -> None:
    text = text_of(folder, name)
    written = write(kind.model_validate_json(text))
    if f"{folder}/{name}" in REORDERED:
        assert written != text
        assert json.loads(written) == json.loads(text)
    else:
        assert written == text


def test_every_line_of_a_ledger() -> None:
    lines = (FOLDER / "cli" / "ledger.jsonl").read_text(encoding="utf-8").splitlines()
    assert len(lines) == 3
    assert [to_json(LedgerLine.model_validate_json(line)) for line in lines] == lines
    assert sorted("error" in json.loads(line) for line in lines) == [False, False, True]


def test_no_sample_is_left_out() -> None:
    there = {f"{p.parent.name}/{p.stem}" for p in FOLDER.rglob("*.json")}
    assert there == {f"{folder}/{name}" for folder, name, _, _ in CASES}


@pytest.mark.parametrize("folder", ["cli", "rest"])
def test_python_objects_are_taken_as_well_as_text(folder: str) -> None:
    """Producers hand over lists and dictionaries: no schema may hold for JSON text only."""
    for name, kind in (CLI if folder == "cli" else REST).items():
        text = text_of(folder, name)
        assert kind.model_validate(json.loads(text)) == kind.model_validate_json(text), name
