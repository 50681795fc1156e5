"""Fits as the library has them."""

from __future__ import annotations

import operator
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray

from drivers.errors import InputError
from platform_daemon.core.reporting.dataframes import fits_table, signal_array
from platform_daemon.core.schemas.parameters import definition_of
from platform_daemon.estimation.parameters import Estimate
from platform_daemon.estimation.result import FitResult
from platform_daemon.features.fit.fit import fit_frame_of, frame_report
from platform_daemon.features.fit.fit_request import FitRequest, check_fixed
from platform_daemon.features.models.options import variant_named

from .recording import Recording, channel_names, check_recording

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr
    from matplotlib.figure import Figure

    from platform_daemon.uncertainty.budget import Budget

Window = Literal["n50", "d30"] | float


class Fit(Mapping[str, Estimate]):
    """The fit of one frame: `fit["f_nat_hz"].value` and `.std`, by the public names of its parameters.

    Attributes:
        recording, frame: what was fitted; model: as what.
        result: everything that the estimation says.
    """

    def __init__(self, recording: Recording, frame: int, ask: FitRequest, result: FitResult) -> None:
        self.recording, self.frame, self.model, self.result = recording, frame, ask.label, result
        self._ask = ask

    def __getitem__(self, name: str) -> Estimate:
        """Value and standard deviation of a parameter, SI; std None: it was held.

        Raises InputError for a fit that was refused, KeyError for a parameter that the model does not have.
        """
        if not self.good:
            remedy = "look at fit.reason"
            raise InputError("the fit was refused", where=self.recording.name, why=self.reason or "", remedy=remedy)
        if name not in self.result.parameters:
            known = ", ".join(self.result.parameters)
            raise KeyError(f"{name!r} is no parameter of a {self.model}; there are {known}")
        return self.result.parameters[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self.result.parameters)

    def __len__(self) -> int:
        return len(self.result.parameters)

    @property
    def good(self) -> bool:
        """Whether there are parameters."""
        return self.result.verdict == "good"

    @property
    def reason(self) -> str | None:
        """Why it was refused; None: it is good."""
        return self.result.reason

    @property
    def warnings(self) -> tuple[str, ...]:
        """What may make the numbers wrong."""
        return self.result.warnings

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Covariance of the parameters of `covariance_names`, in the products of their units."""
        return self.result.covariance

    @property
    def covariance_names(self) -> tuple[str, ...]:
        """The parameters that were estimated, and not held."""
        return self.result.covariance_names

    def table(self) -> str:
        """One line for each parameter: name, value, standard deviation, unit."""
        if not self.good:
            return f"refused: {self.reason}"
        lines = [f"{'parameter':<24}{'value':>18}{'std':>12}  unit"]
        for name, each in self.items():
            std = "held" if each.std is None else f"{each.std:.2g}"
            lines.append(f"{name:<24}{each.value:>18.9g}{std:>12}  {definition_of(name).unit}".rstrip())
        return "\n".join(lines)

    def budget(self, quantity: str, *, coverage: float = 0.95, uncertainty: str | Path | None = None) -> Budget:
        """The uncertainty budget of a parameter: what contributes, and what is not declared.

        Args:
            quantity: public name of the parameter, as m_r_am2.
            coverage: probability of the interval value ± U.
            uncertainty: TOML file with `[uncertainty]`, in the place of what the recording declares.

        Raises InputError for a fit that was refused, a parameter that it does not have, an expired certificate, or
        correlations that contradict each other.
        """
        from platform_daemon.features.budget.declared import declared_by
        from platform_daemon.features.budget.work import shot_budgets

        declared = None if uncertainty is None else declared_by(Path(uncertainty))
        measurement = self.recording.measurement
        found = shot_budgets(measurement, self.frame, self._ask, fit=self.result, declared=declared, coverage=coverage)
        return found.of(quantity)

    def measurand(
        self,
        calibration: str,
        *,
        folder: str | Path = Path("data", "measurands"),
        coverage: float = 0.95,
        extrapolate: bool = False,
    ) -> Budget:
        """The quantity that the resonator is calibrated as a sensor for, with its budget.

        Args:
            calibration: KEY, of which the newest version counts, or KEY@VERSION, as `measurand list` shows them.
            folder: of the calibrations.
            coverage: probability of the interval value ± U.
            extrapolate: read outside of the range of the calibration, too.

        Raises InputError for a fit that was refused, a calibration that is not there, a value or a temperature outside
        of its range, and a temperature that is needed and was not measured.
        """
        from platform_daemon.features.measurand.library import Measurands
        from platform_daemon.features.measurand.sensor import Sensor
        from platform_daemon.features.measurand.shots import time_of

        f_nat = self["f_nat_hz"].value
        sensor = Sensor.by(Measurands(Path(folder)).get(calibration))
        measurement = self.recording.measurement
        celsius = measurement.conditions(self.frame).temperature_c
        at = time_of(measurement, self.frame)
        return sensor.read(f_nat, celsius, at, coverage=coverage, extrapolate=extrapolate)[0]

    def plot(self, path: str | Path | None = None) -> Figure:
        """Signal, fit, residual and spectrum, also saved at `path`, by its suffix as PNG, PDF or SVG.

        A cell of a notebook that ends with it shows it.
        """
        from platform_daemon.features.fit.plot_data import plot_data_of
        from platform_daemon.features.fit.ring_down_figure import draw

        measurement = self.recording.measurement
        record = measurement.signal(self.frame).record
        figure = draw(plot_data_of(measurement, self.frame, record, self.result))
        _let_notebooks_show(figure)
        if path is not None:
            figure.savefig(path)
        return figure

    def model_signal(self) -> NDArray[np.float64]:
        """The fitted model at the samples of the recording, (channels, n), in the unit of the signal."""
        record = self.recording.measurement.signal(self.frame).record
        return self.result.model_signal(record.samples.shape[1], record.sampling_rate_hz)

    def to_dataframe(self) -> pd.DataFrame:
        """One row with value and standard deviation of each parameter; units in `.attrs["units"]`."""
        return fits_table([frame_report(self.frame, self.result)])

    def to_xarray(self) -> xr.Dataset:
        """Signal, model and residual with the dimensions (channel, time).  Raises InputError without xarray."""
        signal = self.recording.to_xarray(self.frame)
        model = signal_array(
            self.model_signal(),
            float(signal.attrs["sampling_rate_hz"]),
            quantity=str(signal.name),
            channels=channel_names(str(signal.name), signal.sizes["channel"]),
        )
        residual = (signal - model).assign_attrs(units=signal.attrs["units"])
        import xarray as xr

        return xr.Dataset({"signal": signal, "model": model, "residual": residual})

    def __repr__(self) -> str:
        return f"<Fit of {self.recording.name} frame {self.frame} as {self.model}: {self.result.verdict}>"


class Fits(Sequence[Fit]):
    """The fits of several frames of a recording, in order."""

    def __init__(self, fits: Sequence[Fit]) -> None:
        self._fits = tuple(fits)

    def __getitem__(self, index: Any) -> Any:
        return self._fits[index]

    def __len__(self) -> int:
        return len(self._fits)

    def to_dataframe(self) -> pd.DataFrame:
        """One row for each frame."""
        return fits_table([frame_report(each.frame, each.result) for each in self._fits])


def fit(
    recording: Recording,
    model: str | None = None,
    *,
    window: Window = "d30",
    frame: int | None = None,
    terms: Sequence[str] = (),
    fixed: Mapping[str, float] | None = None,
    models: str | Path | None = None,
) -> Fit:
    """Fit one frame of a recording.

    Args:
        recording: what `open`, `from_arrays` or `simulate` return.
        model: thread, jewel or another declared one, or an adopted one; None: what the recording says.
        window: "n50" (the first 0.24 s), "d30" (until 30 % of the maximum is left), or seconds.
        frame: number of the frame, from 0; None: the first that is neither blank nor refused.
        terms: further torque terms, as quadratic_drag, or one of another package.
        fixed: parameters that are held, by public name, SI.
        models: folder of adopted models; None: data/models.

    Raises InputError for a model, term or parameter that is unknown, RecordingError for a frame that cannot be read.  A
    signal that cannot be fitted raises nothing: `good` is False then, and `reason` says why.
    """
    return fit_frames(recording, model, window=window, frames=(frame,), terms=terms, fixed=fixed, models=models)[0]


def fit_frames(
    recording: Recording,
    model: str | None = None,
    *,
    window: Window = "d30",
    frames: Sequence[int | None] | None = None,
    terms: Sequence[str] = (),
    fixed: Mapping[str, float] | None = None,
    models: str | Path | None = None,
) -> Fits:
    """Fit several frames of a recording.

    Args:
        recording: what `open`, `from_arrays` or `simulate` return.
        frames: their numbers, from 0; None: all that are neither blank nor refused.
        model, window, terms, fixed, models: as of `fit`, and so are the errors.
    """
    numbers = _checked(recording, window, frames)
    chosen = variant_named(model, None if models is None else Path(models))
    measurement, used = recording.measurement.under(chosen, terms)
    ask = FitRequest(used, window, fixed, None, measurement.moment_am2(), measurement.weight_over_pull())
    check_fixed(ask, calibrated=measurement.calibration is not None)
    if numbers is None:
        numbers = [k for k in range(measurement.frames) if measurement.excuse(k) is None]
    return Fits([Fit(recording, k, ask, fit_frame_of(measurement, k, ask)) for k in numbers])


def _checked(recording: Recording, window: Window, frames: Sequence[int | None] | None) -> list[int] | None:
    """Numbers of the frames, None for all.  Raises InputError for arguments that are none."""
    check_recording(recording)
    number = isinstance(window, (int, float, np.number)) and not isinstance(window, bool)
    if window not in ("n50", "d30") if isinstance(window, str) else not (number and 0 < window < np.inf):
        remedy = "give n50, d30, or a positive number of seconds"
        raise InputError(f"no window {window!r}", where="window", remedy=remedy)
    try:
        chosen = None if frames is None else [None if k is None else operator.index(k) for k in frames]
    except TypeError:
        what, remedy = f"{frames!r} are no numbers of frames", "give whole numbers, from 0"
        raise InputError(what, where="frames", remedy=remedy) from None
    return None if chosen is None else [recording.usable_frame() if k is None else k for k in chosen]


def _let_notebooks_show(figure: Figure) -> None:
    """IPython draws figures only once pyplot, which this package does without, has been imported."""
    shell: Any = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    if getattr(shell, "kernel", None) is None:
        return
    from IPython.core.pylabtools import select_figure_formats

    try:
        shell.display_formatter.formatters["image/png"].lookup(figure)
    except KeyError:
        select_figure_formats(shell, {"png"})
