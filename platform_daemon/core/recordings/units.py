"""The unit that ends a name, as data sets carry it: `f_nat_hz` is in Hz, `contact_lost` in 1."""

from __future__ import annotations

import re

_ENDINGS = {  # an ending before those that it ends with
    "_rad_per_s2": "rad/s^2",
    "_rad_per_s": "rad/s",
    "_am2_per_s": "A m^2/s",
    "_per_rad": "1/rad",
    "_per_s": "1/s",
    "_kg_m2": "kg m^2",
    "_am2": "A m^2",
    "_rad": "rad",
    "_deg": "deg",
    "_khz": "kHz",
    "_hz": "Hz",
    "_ms": "ms",
    "_s": "s",
    "_ut": "uT",
    "_mt": "mT",
    "_t": "T",
    "_a": "A",
    "_v": "V",
    "_m": "m",
    "_c": "degC",
}
_POWER = re.compile(r"_(per_)?(s|rad)([2-9])$")  # a power of a second or of a radian


def unit_of(name: str) -> str:
    """Unit of a number by its name, "1" if the name ends in none."""
    if name.rpartition(".")[2].startswith("rodrigues_"):  # named by axis: the components of a rotation vector
        return "rad"
    known = next((unit for ending, unit in _ENDINGS.items() if name.endswith(ending)), None)
    power = _POWER.search(name)
    if known is not None or power is None:
        return known or "1"
    inverse, unit, exponent = power.groups()
    return f"{'1/' if inverse else ''}{unit}^{exponent}"
