"""The exception tree of the project.

PlatformError                     what, where, why and the remedy; one line on the CLI, RFC 9457 over REST
├── InputError                    the caller's mistake: nothing has moved, nothing was written
│   ├── ConfigError               a TOML file or key
│   ├── SequenceRejected          a request outside the safety envelope or the platform's abilities
│   └── RecordingError            a file that is no usable recording
├── DeviceError                   a device said no, or said nothing
│   ├── DeviceNotFound            nothing at the address, or the back end has no such device
│   ├── DeviceDenied              it is there, but its port is not ours: permissions, or another program holds it
│   ├── DeviceLost                it was there and is gone: unplugged, restarted, or taken by somebody else
│   ├── DeviceTimeout             no answer in time
│   ├── DeviceProtocolError       an answer that makes no sense
│   ├── DeviceFault               the device reports a fault (trip, over-temperature, overload)
│   ├── DeviceStateError          the command does not fit the state the device is in
│   └── OutputsUnconfirmed        outputs could not be read back as off: power may be on
├── InterlockError                the command would connect the receiver to a live amplifier
└── ShotRefused                   samples are missing, overwritten or corrupted: the shot is not data
"""

from __future__ import annotations


class PlatformError(Exception):
    """An error that a user can act on.

    `what` happened, `where` (file, key, device, request field), `why`, and the `remedy`; each one short sentence or
    empty.  `str()` gives all of them on one line.  `nothing_moved`: nothing had begun yet, so what was asked for is
    what must change.
    """

    title = "Platform error"
    nothing_moved = False

    def __init__(self, what: str, *, where: str = "", why: str = "", remedy: str = "") -> None:
        super().__init__(what)
        self.what, self.where, self.why, self.remedy = what, where, why, remedy

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
    """A device refused, failed or stayed silent."""

    title = "Device error"


class DeviceNotFound(DeviceError):
    """Nothing answers at the address, or the back end offers no such device."""

    title = "Device not found"


class DeviceDenied(DeviceError):
    """The device is there, but the operating system keeps us out: permissions, or another program holds it."""

    title = "Device denied"


class DeviceLost(DeviceError):
    """The device was there and is gone: unplugged, restarted, or taken over by another client."""

    title = "Device lost"


class DeviceTimeout(DeviceError):
    """The device did not answer in time."""

    title = "Device timed out"


class DeviceProtocolError(DeviceError):
    """The device answered something that makes no sense."""

    title = "Device protocol error"


class DeviceFault(DeviceError):
    """The device reports a fault of its own."""

    title = "Device fault"


class DeviceStateError(DeviceError):
    """The command does not fit the state the device is in."""

    title = "Wrong device state"


class OutputsUnconfirmed(DeviceError):
    """Outputs were told to go off, and could not be read back as off: power may be on."""

    title = "Outputs not confirmed off"


class InterlockError(PlatformError):
    """The command would connect the receiver while the power amplifier can put out power."""

    title = "Interlock"


class ShotRefused(PlatformError):
    """The samples of a shot are incomplete or flagged; the shot must not be used as data."""

    title = "Shot refused"
