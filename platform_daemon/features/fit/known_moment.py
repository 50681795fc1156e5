"""What is known of a resonator's moment apart from the fits, and the warning of a fit that disagrees."""

from __future__ import annotations

import tomllib

from pydantic import ValidationError

from drivers.specimen import Specimen
from platform_daemon.core.recordings.recording import Recording
from platform_daemon.design.equations import expected_moment
from platform_daemon.estimation.result import FitResult

_UNLIKE = 1.2  # times: further apart than magnets of one batch, or the turns and the gain of a chain that is right


def declared_specimen(recording: Recording) -> Specimen | None:
    """The resonator whose file the recording carries; None without one, or if it cannot be read."""
    try:
        return Specimen.model_validate(tomllib.loads(recording.resonator_toml()))
    except (tomllib.TOMLDecodeError, ValidationError):
        return None


def known_moment_am2(recording: Recording) -> float | None:
    """Measured, else by design, of the resonator whose file the recording carries, A m^2; None without one."""
    specimen = declared_specimen(recording)
    return None if specimen is None else expected_moment(specimen)


def implausible_moment(fit: FitResult, known_am2: float | None) -> tuple[str, ...]:
    """A warning if the moment of a good fit is not that of the resonator; none if it was held, or if nothing is known.

    A wrong sensitivity or gain scales dm/dt as a whole, which the fit takes for another moment: nothing else shows it.
    """
    found = fit.parameters.get("m_r_am2")
    if found is None or found.std is None or not known_am2 or 1 / _UNLIKE <= found.value / known_am2 <= _UNLIKE:
        return ()
    return (
        f"moment_implausible: m_r is {1e3 * found.value:.4g} mAm², {found.value / known_am2:.3g} times the "
        f"{1e3 * known_am2:.4g} mAm² that are known of this resonator; check the calibration, the gain of the LNA, and "
        "which resonator is mounted",
    )
