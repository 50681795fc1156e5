"""Finds back ends by entry point and builds a platform from its configuration.

A third party adds a device by publishing an entry point in the group `platform_daemon.backends`:

    [project.entry-points."platform_daemon.backends"]
    mycard = "my_package:MyBackend"

and naming it in the platform's TOML: `[io_card]` with `backend = "mycard"`.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Annotated, Any, Protocol

from pydantic import BaseModel, ConfigDict, Field

from drivers import entry_points
from drivers.calibration import ReceiveCalibration, TransmitCalibration
from drivers.clock import SystemClock
from drivers.errors import ConfigError, PlatformError
from drivers.platform import Backend, Platform
from drivers.thermometer import RetriedThermometer
from drivers.wiring_proof import prove_lines


class DeviceSection(BaseModel):
    """A device table: which back end, and whatever that back end wants to know."""

    model_config = ConfigDict(extra="allow", frozen=True)

    backend: Annotated[str, Field(min_length=1, strict=True)]

    def options(self) -> dict[str, Any]:
        """The device's own keys."""
        return dict(self.__pydantic_extra__ or {})


class AmplifierSection(DeviceSection):
    """`[power_amplifier]`: turn_off_s: how long it may put out power after its gate has fallen, whatever it is."""

    turn_off_s: Annotated[float, Field(ge=0, allow_inf_nan=False, strict=True)] = 0.0


class GuardSection(BaseModel):
    """`[guard]`: lease_s: how long the owner of the devices may give no sign of life while power may be on, s.

    One that is shorter than the longest answer of a device ends shots that are well.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    lease_s: Annotated[float, Field(gt=0, allow_inf_nan=False, strict=True)] = 6.0


class PlatformSection(BaseModel):
    """The part of a platform file that this room reads: name, device tables, options per back end."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    name: Annotated[str, Field(min_length=1, strict=True)]
    io_card: DeviceSection
    tx_rx_switch: DeviceSection
    power_amplifier: AmplifierSection
    lna: DeviceSection
    thermometer: DeviceSection | None = None
    coils: DeviceSection
    calibration: DeviceSection | None = None
    reference_dipole: DeviceSection | None = None
    field_probe: DeviceSection | None = None
    backends: dict[str, dict[str, Any]] = Field(default_factory=dict)
    guard: GuardSection = GuardSection()

    def used_backends(self) -> tuple[str, ...]:
        """Names of the back ends that the device tables refer to, each once, in order of appearance."""
        tables = (self.io_card, self.tx_rx_switch, self.power_amplifier, self.lna, self.thermometer,
                  self.coils, self.calibration, self.reference_dipole, self.field_probe)  # fmt: skip
        return tuple(dict.fromkeys(t.backend for t in tables if t is not None))


def load_backend(name: str, options: Mapping[str, Any]) -> Backend:
    """Import and construct one back end.  Raises ConfigError if no such back end is installed."""
    backend: Backend = entry_points.load(entry_points.BACKENDS, name, "back end")(options)
    return backend


def outputs_outlive_process(section: PlatformSection) -> bool:
    """Whether an output of this platform can stay on when the process that owns it has ended.

    Nothing is opened.  Raises ConfigError if a back end is not installed.
    """
    outputs = (section.io_card, section.power_amplifier, section.tx_rx_switch)
    kinds: list[type[Backend]] = [_backend_class(name) for name in {table.backend for table in outputs}]
    return not all(kind.in_process for kind in kinds)


def _backend_class(name: str) -> type[Backend]:
    kind: type[Backend] = entry_points.load(entry_points.BACKENDS, name, "back end")
    return kind


class Emulator(Protocol):
    """Devices that exist only as wires, constructed as `Emulator(tables, folder)`: the tables of its TOML file, and the
    folder that paths in it count from.  Raises ConfigError; nothing listens then."""

    def endpoints(self) -> dict[str, Any]:
        """Where everything listens, plain JSON types: `io_cards`, `serial`, `usb`."""

    def close(self) -> None:
        """Stop listening and remove whatever was made."""


def load_emulator(name: str, tables: Mapping[str, Any], folder: Path) -> Emulator:
    """Import and start an emulator.  Raises ConfigError if none of that name is installed."""
    emulator: Emulator = entry_points.load(entry_points.EMULATORS, name, "emulator")(tables, folder)
    return emulator


def build_platform(
    section: PlatformSection,
    calibration: ReceiveCalibration | None = None,
    transmit_calibration: TransmitCalibration | None = None,
) -> Platform:
    """Build every device of a platform.  Outputs are off when it returns.

    `calibration` replaces the one a back end would supply (a file, say), `transmit_calibration` what it declares of
    field and inductance of the coils.  Raises ConfigError and DeviceError, both with `nothing_moved`;
    devices already opened are closed again.
    """
    unused = set(section.backends) - set(section.used_backends())
    if unused:
        raise ConfigError(
            f"options for back ends that no device uses: {', '.join(sorted(unused))}",
            where="backends",
            remedy="remove the table, or name the back end in a device table",
        )
    backends = {name: load_backend(name, section.backends.get(name, {})) for name in section.used_backends()}
    if calibration is None:
        if section.calibration is None:
            raise ConfigError("the platform has no calibration", where="calibration", remedy="add [calibration]")
        calibration = backends[section.calibration.backend].receive_calibration(section.calibration.options())
    transmit = backends[section.coils.backend].transmit_channels(section.coils.options())
    if transmit_calibration is not None:
        transmit = transmit_calibration.applied(transmit)
    opened: list[Any] = []

    def device(kind: str) -> Any:
        table: DeviceSection = getattr(section, kind)
        opened.append(getattr(backends[table.backend], kind)(table.options()))
        return opened[-1]

    def thermometer(table: DeviceSection) -> RetriedThermometer:
        opened.append(RetriedThermometer(lambda: backends[table.backend].thermometer(table.options())))
        return opened[-1]

    try:
        platform = Platform(
            name=section.name,
            card=device("io_card"),
            switch=device("tx_rx_switch"),
            amplifier=device("power_amplifier"),
            lna=device("lna"),
            thermometer=thermometer(section.thermometer) if section.thermometer else None,
            transmit=transmit,
            calibration=calibration,
            clock=_clock(backends),
            backends=backends,
            reference=_instrument(section, backends, "reference_dipole"),
            probe=_instrument(section, backends, "field_probe"),
            transmit_calibration=transmit_calibration,
            amplifier_off_s=section.power_amplifier.turn_off_s,
        )
        check_gain(platform.calibration, platform.lna.gain())
        prove_lines(platform)
        return platform
    except Exception as error:
        if isinstance(error, PlatformError):
            error.nothing_moved = True
        for each in reversed(opened):
            with suppress(Exception):  # the first error is the one to report, and every device must get its close
                each.close()
        raise


def _instrument(section: PlatformSection, backends: Mapping[str, Backend], kind: str) -> Any:
    """What calibrates the platform; None: the platform has none."""
    table: DeviceSection | None = getattr(section, kind)
    return None if table is None else getattr(backends[table.backend], kind)(table.options())


def check_gain(calibration: ReceiveCalibration, is_set: float) -> None:
    """Raises ConfigError if it was made at another gain: it would scale every moment by the ratio, in silence."""
    made_at = calibration.lna_gain
    if made_at is not None and made_at != is_set:
        raise ConfigError(
            f"the calibration holds for an LNA gain of {made_at:g}, set is {is_set:g}",
            where="lna.gain",
            why=f"it is {calibration.identifier!r}",
            remedy="set the gain the calibration was made at, or name another calibration",
        )


def _clock(backends: Mapping[str, Backend]) -> Any:
    """The one clock that is not the system's, if there is one: simulated time must win over real time."""
    clocks = [b.clock() for b in backends.values()]
    return next((c for c in clocks if not isinstance(c, SystemClock)), SystemClock())
