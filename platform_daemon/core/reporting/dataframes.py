"""Fits as pandas tables and signals as xarray arrays, with units."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from drivers.errors import InputError
from platform_daemon.core.schemas.fits import FrameFit
from platform_daemon.core.schemas.parameters import definition_of

if TYPE_CHECKING:
    import numpy as np
    import pandas as pd
    import xarray as xr
    from numpy.typing import NDArray

UNITS = {"dmdt": "A m^2/s", "voltage": "V", "angle": "rad"}
"""Unit of a signal by its quantity."""
_COLUMNS = {"window_s": "s", "r2": "1", "nrmse": "1", "chi2_per_dof": "1"}


def missing_package(name: str) -> InputError:
    """The error for an optional package that is not installed."""
    remedy = "pip install 'platform-daemon[analysis]'"
    return InputError(f"{name} is not installed", where="platform-daemon[analysis]", remedy=remedy)


def fits_table(frames: Iterable[FrameFit]) -> pd.DataFrame:
    """One row for each frame: verdict, value and standard deviation of each parameter, goodness of the fit.

    `.attrs["units"]` has the unit of each column.  Raises InputError without pandas.
    """
    pandas = pandas_module()
    rows: list[dict[str, Any]] = []
    units: dict[str, str] = {}
    for frame in frames:
        row: dict[str, Any] = {"frame": frame.frame, "verdict": frame.verdict, "reason": frame.reason}
        for name, estimate in frame.parameters.items():
            row |= {name: estimate.value, f"{name}_std": estimate.std}
            units |= dict.fromkeys((name, f"{name}_std"), definition_of(name).unit)
        rows.append({**row, **{name: getattr(frame, name) for name in _COLUMNS}})
    parameters = [name for name in dict.fromkeys(name for row in rows for name in row) if name in units]
    columns = ["frame", "verdict", "reason", *parameters, *_COLUMNS]
    table = pandas.DataFrame(rows, columns=columns).set_index("frame")
    table.attrs["units"] = {**units, **_COLUMNS}
    return table


def pandas_module() -> Any:
    """pandas, imported when it is needed.  Raises InputError where it is not installed."""
    try:
        import pandas as pd
    except ImportError:
        raise missing_package("pandas") from None
    return pd


def signal_array(
    samples: NDArray[np.float64],
    rate_hz: float,
    *,
    quantity: str,
    channels: Sequence[str],
    start_s: float = 0.0,
    attributes: dict[str, Any] | None = None,
) -> xr.DataArray:
    """A signal with the dimensions (channel, time), its unit and the time since the first RX sample, s.

    samples: (channels, n); quantity: dmdt, voltage or angle; attributes: what else `.attrs` is to hold.
    Raises InputError without xarray.
    """
    try:
        import xarray as xr
    except ImportError:
        raise missing_package("xarray") from None
    import numpy as np

    time_s = start_s + np.arange(samples.shape[1]) / rate_hz
    found = xr.DataArray(
        samples,
        dims=("channel", "time"),
        coords={"channel": list(channels), "time": ("time", time_s, {"units": "s"})},
        name=quantity,
        attrs={"units": UNITS[quantity], "sampling_rate_hz": rate_hz, **(attributes or {})},
    )
    found["time"].attrs["long_name"] = "time since the first RX sample"
    return found
