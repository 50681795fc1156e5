"""What may be asked: bounds, what is refused, and what a request says when it is kept."""

from __future__ import annotations

import json
from typing import Any

import pytest
from pydantic import ValidationError

from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.requests import AcquisitionRequest, SequencePatch, SequencePreset
from platform_daemon.core.settings import load_sequence, shipped
from platform_daemon.features.diagnose.request_schema import DiagnosisRequest
from platform_daemon.features.fit.request_schema import PredictionRequest, RecordingFitRequest
from platform_daemon.features.schedules.schema import ScheduleRequest
from sequences.request import SequenceRequest

BOUNDS = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum", "type")


def bounds(model: type[Any]) -> dict[str, dict[str, Any]]:
    properties = model.model_json_schema()["properties"]
    return {key: {b: p[b] for b in BOUNDS if b in p} for key, p in properties.items()}


def test_a_patch_has_the_keys_and_bounds_of_a_sequence() -> None:
    whole = bounds(SequenceRequest)
    assert bounds(SequencePreset) == whole
    assert bounds(SequencePatch) == {k: b for k, b in whole.items() if k not in ("repetitions", "blank_shots")}


def test_presets_are_presets() -> None:
    for name in shipped("sequences"):
        preset = load_sequence(name).model_dump()
        assert json.loads(to_json(SequencePreset(**preset))) == preset


def test_keys_that_were_not_given_are_not_told() -> None:
    request = AcquisitionRequest.model_validate({"resonator": "thread", "sequence": {"axis": [0, 1, 1], "rx_s": 2}})
    assert request.sequence.changes() == {"axis": (0.0, 1.0, 1.0), "rx_s": 2.0}
    assert json.loads(to_json(request)) == {
        **{"resonator": "thread", "shots": 1, "blank_shots": 0, "sequence": {"axis": [0.0, 1.0, 1.0], "rx_s": 2.0}},
        **{"window": "d30", "variant": None, "sample": "", "operator": "", "comment": ""},
    }
    assert AcquisitionRequest.model_validate_json(to_json(request)) == request


@pytest.mark.parametrize(
    ("sequence", "complaint"),
    [
        ({"rx": 2.0}, "Extra inputs"),
        ({"rx_s": 0.0}, "greater than 0"),
        ({"rx_s": "2"}, "valid number"),
        ({"field_t": 490.0}, "less than or equal to 1"),
        ({"axis": "w"}, "'x', 'y' or 'z'"),
        ({"axis": [0, 0, 0]}, "must not be zero"),
        ({"axis": [1, 0]}, "at least 3 items"),
        ({"repetitions": 3}, "give the counts as `shots` and `blank_shots`"),
        ({"tx_periods": 1.5}, "valid integer"),
    ],
)
def test_what_no_sequence_can_be(sequence: dict[str, Any], complaint: str) -> None:
    with pytest.raises(ValidationError, match=complaint):
        AcquisitionRequest.model_validate({"resonator": "thread", "sequence": sequence})


def test_a_priority_is_one_of_a_schedule_and_not_told_where_it_is_the_usual_one() -> None:
    assert bounds(AcquisitionRequest)["priority"] == bounds(ScheduleRequest)["priority"]
    assert "priority" not in AcquisitionRequest(resonator="thread").model_dump()
    assert AcquisitionRequest(resonator="thread", priority=-100).model_dump()["priority"] == -100
    for wrong in (-101, 101, 1.5, "5", True, None):
        with pytest.raises(ValidationError):
            AcquisitionRequest.model_validate({"resonator": "thread", "priority": wrong})


def test_windows() -> None:
    assert RecordingFitRequest(recording="a", window=1).window == 1.0
    for wrong in ("n51", 0.0, float("nan"), -1.0):
        with pytest.raises(ValidationError):
            RecordingFitRequest.model_validate({"recording": "a", "window": wrong})


def test_an_id_is_no_path() -> None:
    for wrong in ("../a", "", "a/b", ".hidden"):
        with pytest.raises(ValidationError):
            RecordingFitRequest(recording=wrong)


def test_parts_of_a_diagnosis() -> None:
    asked = DiagnosisRequest.model_validate({"recordings": ["a", {"recording": "b", "frames": [0, 2]}]})
    assert [(p.recording, p.frames) for p in asked.parts()] == [("a", None), ("b", [0, 2])]


def test_a_prediction_has_the_noise_of_the_paper() -> None:
    assert PredictionRequest(resonator="jewel").noise_am2_per_s == (0.014, 0.021, 0.055)
    with pytest.raises(ValidationError, match="at least 3 items"):
        PredictionRequest(resonator="jewel", noise_am2_per_s=(0.1, 0.2))


@pytest.mark.parametrize("key", ["sample", "operator", "comment"])
@pytest.mark.parametrize("character", ["\0", "\x1b", "\x7f", "\x9b", "\u2028", "\u202e"])
def test_no_text_holds_what_a_terminal_would_obey(key: str, character: str) -> None:
    with pytest.raises(ValidationError, match="holds the control character"):
        AcquisitionRequest.model_validate({"resonator": "thread", key: f"a{character}b"})


def test_names_are_one_line_and_comments_may_have_several() -> None:
    assert AcquisitionRequest(resonator="thread", comment="a\r\n\tb", sample="Łódź 7 µT").comment == "a\r\n\tb"
    for wrong in ({"sample": "a\nb"}, {"operator": "a\tb"}):
        with pytest.raises(ValidationError, match="one line"):
            AcquisitionRequest.model_validate({"resonator": "thread", **wrong})
    work = {"kind": "self_test", "request": {}}
    with pytest.raises(ValidationError, match="one line"):
        ScheduleRequest.model_validate({"name": "a\x1b[2Jb", "trigger": {"every_s": 60.0}, "work": work})


@pytest.mark.parametrize(
    ("model", "keys", "same"),
    [
        (AcquisitionRequest, {"resonator": "jewel", "shots": 3.0}, {"resonator": "jewel", "shots": 3}),
        (
            AcquisitionRequest,
            {"resonator": "jewel", "sequence": {"tx_periods": 9.0, "rx_s": 1.0}},
            {"resonator": "jewel", "sequence": {"tx_periods": 9, "rx_s": 1.0}},
        ),
        (RecordingFitRequest, {"recording": "a", "frames": [0.0, 2.0]}, {"recording": "a", "frames": [0, 2]}),
    ],
)
def test_a_whole_number_may_be_written_with_a_fraction_of_zero(
    model: type[Any], keys: dict[str, Any], same: dict[str, Any]
) -> None:
    """Case 11: 3.0 where a whole number is asked for."""
    assert model.model_validate_json(json.dumps(keys)) == model.model_validate(same)
    assert model.model_validate(keys) == model.model_validate(same)


@pytest.mark.parametrize("shots", [3.5, 1e300, True, "3"])
def test_what_is_no_whole_number_stays_none(shots: Any) -> None:
    with pytest.raises(ValidationError):
        AcquisitionRequest.model_validate({"resonator": "jewel", "shots": shots})
