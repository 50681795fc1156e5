"""What was wrong, in words: allowed values, units, and what was meant perhaps."""

from __future__ import annotations

from typing import Annotated, Any, Literal

import pytest
from pydantic import BaseModel, ConfigDict, Field

from drivers.errors import ConfigError
from drivers.validation import validated


class Inner(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    rx_s: Annotated[float, Field(gt=0, le=600)] = 1.0
    field_t: Annotated[float, Field(gt=0, le=1)] = 1e-4
    angle_rad: Annotated[float, Field(lt=1.5)] = 0.1
    frames: list[int] | None = None


class Walk(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    kind: Literal["walk"]
    request: Inner


class Nap(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    hours: Annotated[int, Field(ge=1)] = 1


class Rest(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    kind: Literal["rest"]
    request: Nap


class Plan(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    work: Annotated[Walk | Rest, Field(discriminator="kind")]


class Outer(BaseModel):
    model_config = ConfigDict(extra="forbid", strict=True)

    name: Annotated[str, Field(min_length=1, max_length=5)]
    shots: Annotated[int, Field(ge=0)] = 1
    window: Literal["n50", "d30"] | Annotated[float, Field(gt=0)] = "d30"
    inner: Inner = Inner()
    parts: Annotated[list[str | Inner], Field(min_length=1)] = ["a"]
    fixed: dict[str, float] = {}


@pytest.mark.parametrize(
    ("keys", "words"),
    [
        ({"name": None}, "key 'name' must be text, got null"),
        ({"name": "toolong"}, "key 'name' must be text of at most 5 characters, got 'toolong'"),
        ({"shot": 3}, "key 'shot' is unknown (value 3); did you mean 'shots'?"),
        ({"colour": 3}, "key 'colour' is unknown (value 3); there are: name, shots, window, inner, parts, fixed"),
        ({"shots": "3"}, "key 'shots' must be a whole number, got '3'"),
        ({"shots": -1}, "key 'shots' must be at least 0, got -1"),
        ({"window": "n51"}, "key 'window' must be 'n50' or 'd30' or a number, got 'n51'; did you mean 'n50'?"),
        ({"window": -1.0}, "key 'window' must be 'n50' or 'd30' or above 0, got -1.0"),
        ({"inner": {"rx": 1.0}}, "key 'inner.rx' is unknown (value 1.0); did you mean 'rx_s'?"),
        ({"inner": {"rx_s": 0.0}}, "key 'inner.rx_s' must be above 0 s, got 0.0"),
        ({"inner": {"field_t": 490.0}}, "at most 1 T, got 490.0; the unit is T: did you mean 0.00049 (490 uT)?"),
        (
            {"inner": {"angle_rad": 40.0}},
            "below 1.5 rad, got 40.0; the unit is rad: did you mean 0.698132 (40 degrees)?",
        ),
        ({"inner": {"rx_s": 1e9}}, "key 'inner.rx_s' must be at most 600 s, got 1000000000.0."),
        ({"inner": 3}, "key 'inner' must be a table of keys, got 3"),
        ({"inner": {"frames": ["a"]}}, "key 'inner.frames.0' must be a whole number, got 'a'"),
        ({"parts": []}, "key 'parts' must be a list of at least 1, got []"),
        ({"parts": ["a", {"rx_s": "x"}]}, "key 'parts.1.rx_s' must be a number, got 'x'"),
        ({"fixed": {"a": "x"}}, "key 'fixed.a' must be a number, got 'x'"),
    ],
)
def test_what_is_wrong_is_said_in_words(keys: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError) as raised:
        validated(Outer, {"name": "x"} | keys, "a.toml")
    assert words in str(raised.value)
    assert str(raised.value).startswith("a.toml: ")


def test_every_key_is_named_once() -> None:
    with pytest.raises(ConfigError) as raised:
        validated(Outer, {"shot": 1, "window": "x"}, "a.toml")
    assert raised.value.why == "3 keys are wrong"
    assert raised.value.what.count("key '") == 3


def test_long_values_are_shortened() -> None:
    with pytest.raises(ConfigError) as raised:
        validated(Outer, {"name": "x", "shots": "9" * 1000}, "a.toml")
    assert len(str(raised.value)) < 300


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (
            {"kind": "walk", "request": {"rx": 1.0}},
            "'work.request.rx' is unknown (value 1.0); did you mean 'rx_s'?",
        ),
        ({"kind": "walk", "request": {"rx_s": 1e9}}, "key 'work.request.rx_s' must be at most 600 s"),
        (
            {"kind": "rest", "request": {"rx_s": 1.0}},
            "'work.request.rx_s' is unknown (value 1.0); there are: hours",
        ),
        ({"kind": "rest", "request": {"hours": 0}}, "key 'work.request.hours' must be at least 1, got 0"),
        ({"kind": "rest", "request": {}, "rest": 1}, "key 'work.rest' is unknown (value 1)"),
        ({"kind": "wlak"}, "key 'work' has an unknown 'kind', 'wlak'; did you mean 'walk'?"),
        ({"kind": "swim"}, "key 'work' has an unknown 'kind', 'swim'; there are: walk, rest"),
        ({"request": {}}, "key 'work' has no key 'kind', which says what it is"),
    ],
)
def test_of_several_kinds_the_keys_of_the_one_that_was_meant_are_told(work: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError) as raised:
        validated(Plan, {"work": work}, "a.toml")
    assert words in str(raised.value)
