"""Typed warnings about a calibration that is used outside what it was made for."""

from __future__ import annotations

from dataclasses import dataclass

from drivers.calibration import ReceiveCalibration

FREQUENCY, TEMPERATURE, GAIN = "calibration_frequency", "calibration_temperature", "calibration_gain"
"""Types of the warnings: each text begins with its type and a colon."""


@dataclass(frozen=True)
class ShotConditions:
    """How a shot was taken, as far as known: temperature deg C, LNA gain V/V."""

    temperature_c: float | None = None
    lna_gain: float | None = None


def out_of_validity(
    calibration: ReceiveCalibration | None, f_nat_hz: float | None, shot: ShotConditions
) -> tuple[str, ...]:
    """What is said of a fit with this calibration: its frequencies are f_nat and 2 f_nat (eq:projection).

    A calibration that does not say what it holds for gives no warning.
    """
    if calibration is None:
        return ()
    said = []
    if calibration.valid_hz is not None and f_nat_hz is not None:
        low, high = calibration.valid_hz
        if f_nat_hz < low or 2 * f_nat_hz > high:
            signal = f"the signal is at {f_nat_hz:.4g} and {2 * f_nat_hz:.4g} Hz"
            said.append(f"{FREQUENCY}: {signal}, the calibration holds from {low:g} to {high:g} Hz")
    if calibration.valid_c is not None and shot.temperature_c is not None:
        low, high = calibration.valid_c
        if not low <= shot.temperature_c <= high:
            measured = f"measured at {shot.temperature_c:.2f} deg C"
            said.append(f"{TEMPERATURE}: {measured}, the calibration holds from {low:.2f} to {high:.2f} deg C")
    if calibration.lna_gain is not None and shot.lna_gain is not None and calibration.lna_gain != shot.lna_gain:
        gains = f"measured at an LNA gain of {shot.lna_gain:g}, calibrated at {calibration.lna_gain:g}"
        said.append(f"{GAIN}: {gains}; moments are wrong by the ratio")
    return tuple(said)
