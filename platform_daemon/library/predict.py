"""What a measurement to come can tell."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from drivers.validation import validated
from platform_daemon.core.schemas.base import Window
from platform_daemon.core.schemas.parameters import PAPER_NOISE_AM2_PER_S
from platform_daemon.core.schemas.requests import SequencePatch
from platform_daemon.core.settings import load_specimen
from platform_daemon.features.fit.precision import planned_model, planned_precision
from platform_daemon.features.fit.prediction_schema import PredictionReport
from platform_daemon.features.models.options import library

from .simulate import RATE_HZ


def predict(
    resonator: str,
    model: str | None = None,
    *,
    windows: Sequence[Window] = ("n50", "d30"),
    phi_max_deg: float | None = None,
    sequence: Mapping[str, Any] | None = None,
    noise: Sequence[float] = PAPER_NOISE_AM2_PER_S,
    sampling_rate_hz: float = RATE_HZ,
    terms: Sequence[str] = (),
    fixed: Sequence[str] = (),
    expected: Mapping[str, float] | None = None,
    estimate_adopted: bool = False,
    models: str | Path | None = None,
) -> PredictionReport:
    """The smallest standard deviations that fits of a planned measurement can have: the Cramer-Rao bound, white noise.

    Args:
        resonator: thread, jewel or the path of a resonator file, whose measured or design values are expected.
        model: that is to be fitted, declared or adopted; None: that of the resonator's bearing.
        windows: "n50", "d30" or seconds.
        phi_max_deg: largest deflection, degrees; None: the paper's.
        sequence: in its place, for an adopted model with a manufacturing error, keys of the drive that differ from the
            resonator's preset, SI, as field_t and rx_s.
        noise: standard deviation of one sample of x, y, z, A m^2/s.
        sampling_rate_hz: samples per second, Hz.
        terms: further torque terms, of which `expected` has the strengths.
        fixed: public names of parameters that are held; expected: values by public name, SI.
        estimate_adopted: strengths that an adopted model holds are estimated; False: held, as fits do.
        models: folder of adopted models; None: data/models.

    Raises InputError, RecordingError for a plan that makes no sense, and ConfigError for a key that is none.
    """
    specimen = load_specimen(resonator)[0]
    return planned_precision(
        specimen,
        windows,
        phi_max_rad=None if phi_max_deg is None else math.radians(phi_max_deg),
        noise_am2_per_s=noise,
        sampling_rate_hz=sampling_rate_hz,
        fixed=tuple(fixed),
        model=planned_model(model, terms, library(None if models is None else Path(models)), specimen),
        estimate_adopted=estimate_adopted,
        expected=expected,
        sequence=validated(SequencePatch, dict(sequence or {}), "sequence"),
    )
