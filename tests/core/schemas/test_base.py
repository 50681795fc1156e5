"""Numbers, missing keys, and what is refused."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from platform_daemon.core.schemas.acquisitions import AcquisitionResult
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.fits import FrameFit, ParameterEstimate, unfitted
from platform_daemon.core.schemas.harmonics import HarmonicEstimate, ShotHarmonics
from platform_daemon.diagnosis.report_schema import EffectDetail, NextMeasurement
from tests.kit.schema_samples import text_of


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_floats_are_written_as_python_writes_them(value: float) -> None:
    text = json.dumps({"value": value, "std": None})
    assert to_json(ParameterEstimate(value=value, std=None)) == text
    assert to_json(ParameterEstimate.model_validate_json(text)) == text


def test_floats_of_numpy_are_floats() -> None:
    assert to_json(ParameterEstimate(value=np.float64(1e-5), std=np.float64(-0.0))) == '{"value": 1e-05, "std": -0.0}'


def test_what_json_cannot_hold() -> None:
    estimate = ParameterEstimate(value=math.nan, std=None)
    with pytest.raises(ValueError, match="not JSON compliant"):
        to_json(estimate)
    assert to_json(estimate, allow_nan=True) == '{"value": NaN, "std": null}'
    assert NextMeasurement(what="wait", separates=(), expected_sigma=math.inf).expected_sigma is None


def test_absent_keys_are_absent_and_null_is_written() -> None:
    assert to_json(AcquisitionResult()) == "{}"
    assert to_json(AcquisitionResult(recording="a", shots=0)) == '{"recording": "a", "shots": 0}'
    frame = json.loads(to_json(unfitted(3, "a blank shot")))
    assert frame["r2"] is None
    assert "derived" not in frame


def test_a_result_cannot_be_changed_or_hold_something_unknown() -> None:
    frame = unfitted(0, "why")
    with pytest.raises(ValidationError, match="frozen"):
        frame.frame = 1  # type: ignore[misc]
    with pytest.raises(ValidationError, match="Extra inputs"):
        FrameFit.model_validate_json(to_json(frame)[:-1] + ', "r3": 1.0}')


def test_hidden_scales_of_an_effect_stand_beside_its_place() -> None:
    text = (
        '{"axis": null, "frequency_hz": null, "tau_s": null, "sample": null, "from": "x", "to": "y", '
        '"stribeck_speed_rad_per_s": 20.0}'
    )
    detail = EffectDetail.model_validate_json(text)
    assert to_json(detail) == text
    assert (detail.source, detail.target) == ("x", "y")
    assert detail.hidden_scales() == {"stribeck_speed_rad_per_s": 20.0}


def test_harmonics_are_there_whole_or_not_at_all() -> None:
    assert isinstance(ShotHarmonics.model_validate_json(text_of("rest", "live")).root, HarmonicEstimate)
    with pytest.raises(ValidationError, match="f_nat_hz"):
        ShotHarmonics.model_validate({"verdict": "good", "reason": None, "time_s": 0.1})


def test_good_frames_and_their_values() -> None:
    frame = FrameFit.model_validate(json.loads(text_of("cli", "fit_jewel_n50"))["frames"][0])
    assert frame.good
    assert frame.values["f_nat_hz"] == frame.parameters["f_nat_hz"].value
    assert not unfitted(0, "why").good
