"""The daemon, and the library for those who never start one: recordings, fits, simulated signals, diagnoses.

Example:
    >>> import platform_daemon as pd_
    >>> fit = pd_.fit(pd_.open("first.h5"), model="jewel", window="d30")
    >>> fit["f_nat_hz"].value, fit["f_nat_hz"].std
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from drivers.errors import InputError, PlatformError, RecordingError

    from .estimation.physics.torque_term import Coefficient, TorqueTerm
    from .library.diagnosis import DiagnosisResult, diagnose
    from .library.fit import Fit, Fits, fit, fit_frames
    from .library.predict import predict
    from .library.recording import Recording, from_arrays
    from .library.recording import open_recording as open
    from .library.simulate import simulate
    from .uncertainty.budget import Budget
    from .uncertainty.inputs import InputQuantity, from_observations
    from .uncertainty.monte_carlo import check_law_of_propagation, monte_carlo
    from .uncertainty.propagation import propagate, propagate_jointly

    __version__: str

__all__ = [
    "Budget",
    "Coefficient",
    "DiagnosisResult",
    "Fit",
    "Fits",
    "InputError",
    "InputQuantity",
    "PlatformError",
    "Recording",
    "RecordingError",
    "TorqueTerm",
    "__version__",
    "check_law_of_propagation",
    "diagnose",
    "fit",
    "fit_frames",
    "from_arrays",
    "from_observations",
    "monte_carlo",
    "open",
    "predict",
    "propagate",
    "propagate_jointly",
    "simulate",
]

_PLACES = {
    **dict.fromkeys(("InputError", "PlatformError", "RecordingError"), "drivers.errors"),
    **dict.fromkeys(("Coefficient", "TorqueTerm"), "platform_daemon.estimation.physics.torque_term"),
    **dict.fromkeys(("DiagnosisResult", "diagnose"), "platform_daemon.library.diagnosis"),
    **dict.fromkeys(("Fit", "Fits", "fit", "fit_frames"), "platform_daemon.library.fit"),
    "predict": "platform_daemon.library.predict",
    **dict.fromkeys(("Recording", "from_arrays", "open"), "platform_daemon.library.recording"),
    "simulate": "platform_daemon.library.simulate",
    "Budget": "platform_daemon.uncertainty.budget",
    **dict.fromkeys(("InputQuantity", "from_observations"), "platform_daemon.uncertainty.inputs"),
    **dict.fromkeys(("check_law_of_propagation", "monte_carlo"), "platform_daemon.uncertainty.monte_carlo"),
    **dict.fromkeys(("propagate", "propagate_jointly"), "platform_daemon.uncertainty.propagation"),
}
"""Where a name is defined; each is imported when it is used, because the estimation takes seconds to load."""


def __getattr__(name: str) -> object:
    if name == "__version__":  # `importlib.metadata` takes longer than the rest of `--version`
        from importlib.metadata import version

        return version("platform-daemon")
    if name not in _PLACES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    from importlib import import_module

    return getattr(import_module(_PLACES[name]), "open_recording" if name == "open" else name)


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
