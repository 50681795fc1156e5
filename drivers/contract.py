"""The old name of `drivers.conformance`, for the certificates of third parties; it goes with the next version."""

import warnings

from drivers.conformance import *  # noqa: F403 an alias offers what the other does
from drivers.conformance import __all__ as __all__

warnings.warn(
    "drivers.contract is now called drivers.conformance and goes with the next version: import from there",
    DeprecationWarning,
    stacklevel=2,
)
