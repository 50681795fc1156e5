"""The exception tree of the project.

The number is the HTTP status of the answer over REST (`http_status`), which a subclass elsewhere inherits or replaces.

PlatformError                500  what, where, why and the remedy; one line on the CLI, RFC 9457 over REST
├── InputError               422  the caller's mistake: nothing has moved, nothing was written
│   ├── ConfigError          422  a TOML file or key
│   ├── SequenceRejected     422  a request outside the safety envelope or the abilities of the platform
│   └── RecordingError       422  a file that is no usable recording
├── DeviceError              502  a device refused, failed or did not answer
│   ├── DeviceNotFound       502  nothing at the address, or the back end has no such device
│   ├── DeviceDenied         502  its port cannot be opened: permissions, or another program holds it
│   ├── DeviceLost           502  the connection was lost: unplugged, restarted, or taken over by another client
│   ├── DeviceTimeout        504  no answer in time
│   ├── DeviceProtocolError  502  an answer that makes no sense
│   ├── DeviceFault          502  the device reports a fault (trip, over-temperature, overload)
│   ├── DeviceStateError     409  the command does not fit the state that the device is in
│   └── OutputsUnconfirmed   502  outputs could not be read back as off: power may be on
├── InterlockError           409  the command would connect the receiver to a live amplifier
└── ShotRefused              500  samples are missing, overwritten or corrupted: the shot is not data
"""

from __future__ import annotations

from typing import ClassVar


class PlatformError(Exception):
    """An error that a user can act on.

    `what` happened, `where` (file, key, device, request field), `why`, and the `remedy`; each one short sentence or
    empty.  `str()` gives all of them on one line.  `http_status`: what REST answers; a class has that of its parent
    unless it says otherwise.  `nothing_moved`: nothing had begun yet, so the request is what must change.
    """

    title = "Platform error"
    http_status: ClassVar[int] = 500
    nothing_moved = False

    def __init__(self, what: str, *, where: str = "", why: str = "", remedy: str = "") -> None:
        super().__init__(what)
        self.what = what
        self.where = where
        self.why = why
        self.remedy = remedy

    def __str__(self) -> str:
        head = f"{self.where}: {self.what}" if self.where else self.what
        parts = [head, self.why, f"Remedy: {self.remedy}" if self.remedy else ""]
        return " ".join(_sentence(part) for part in parts if part)


def _sentence(text: str) -> str:
    text = " ".join(text.split())
    return text if text.endswith((".", "!", "?")) else text + "."


class InputError(PlatformError):
    """The caller's mistake; no hardware moved and no file was written."""

    title = "Invalid input"
    http_status: ClassVar[int] = 422
    nothing_moved = True


class ConfigError(InputError):
    """A configuration file or key is missing, unknown or out of range."""

    title = "Invalid configuration"


class SequenceRejected(InputError):
    """The requested sequence leaves the safety envelope or what the platform can do."""

    title = "Sequence rejected"


class RecordingError(InputError):
    """The file is not a usable recording."""

    title = "Unusable recording"


class DeviceError(PlatformError):
    """A device refused, failed or did not answer."""

    title = "Device error"
    http_status: ClassVar[int] = 502


class DeviceNotFound(DeviceError):
    """Nothing answers at the address, or the back end offers no such device."""

    title = "Device not found"


class DeviceDenied(DeviceError):
    """The device is present, but the operating system denies access: permissions, or another program holds it."""

    title = "Device denied"


class DeviceLost(DeviceError):
    """The connection to the device was lost: unplugged, restarted, or taken over by another client."""

    title = "Device lost"


class DeviceTimeout(DeviceError):
    """The device did not answer in time."""

    title = "Device timed out"
    http_status: ClassVar[int] = 504


class DeviceProtocolError(DeviceError):
    """The device answered something that makes no sense."""

    title = "Device protocol error"


class DeviceFault(DeviceError):
    """The device reports a fault of its own."""

    title = "Device fault"


class DeviceStateError(DeviceError):
    """The command does not fit the state the device is in."""

    title = "Wrong device state"
    http_status: ClassVar[int] = 409


class OutputsUnconfirmed(DeviceError):
    """Outputs were switched off, and could not be read back as off: power may be on."""

    title = "Outputs not confirmed off"


class InterlockError(PlatformError):
    """The command would connect the receiver while the power amplifier can put out power."""

    title = "Interlock"
    http_status: ClassVar[int] = 409


class ShotRefused(PlatformError):
    """The samples of a shot are incomplete or flagged; the shot must not be used as data."""

    title = "Shot refused"
