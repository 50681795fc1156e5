"""A serial port that carries lines of ASCII."""

from __future__ import annotations

import contextlib
import errno
import termios

import serial

from drivers.errors import DeviceDenied, DeviceLost, DeviceNotFound, DeviceProtocolError, DeviceTimeout

LONGEST_LINE = 1000


class SerialWire:
    """See drivers.exchange.Wire; opened exclusively.  One thread at a time.  `end` ends a line in both directions."""

    def __init__(self, port: str, baud: int, timeout_s: float, end: str = "\n") -> None:
        """Raises DeviceNotFound, DeviceDenied."""
        self._port_name = port
        self._timeout_s = timeout_s
        self._end = end.encode("ascii")
        try:
            self._port = serial.Serial(port, baud, timeout=timeout_s, write_timeout=timeout_s, exclusive=True)
            self._port.reset_input_buffer()
        except (serial.SerialException, OSError, ValueError) as error:
            raise opening_failed(port, error) from None

    def send(self, text: str) -> None:
        """See Wire."""
        try:
            self._port.reset_input_buffer()  # late answers to earlier questions
            self._port.write(text.encode("ascii") + self._end)
        except serial.SerialTimeoutException:
            raise DeviceTimeout("the serial line takes no data", where=self._port_name) from None
        except (serial.SerialException, OSError, termios.error) as error:
            raise self._lost(error) from None

    def receive(self) -> str:
        """See Wire."""
        try:
            raw = self._port.read_until(self._end[-1:], LONGEST_LINE)
        except (serial.SerialException, OSError, TypeError, termios.error) as error:
            raise self._lost(error) from None
        if not raw.endswith(self._end[-1:]):
            if raw:
                raise DeviceProtocolError(
                    "the answer has no end",
                    where=self._port_name,
                    why=f"it begins {raw[:40]!r}",
                    remedy="see baud rate",
                )
            raise DeviceTimeout(
                "no answer", where=self._port_name, why=f"none within {self._timeout_s:g} s", remedy="check the device"
            )
        text = raw.decode("ascii", "replace").strip()
        if not text or not text.isprintable() or "\ufffd" in text:
            raise DeviceProtocolError("the answer is garbage", where=self._port_name, why=f"it is {raw[:40]!r}")
        return text

    def close(self) -> None:
        """See Wire."""
        with contextlib.suppress(serial.SerialException, OSError, termios.error):
            self._port.close()

    def _lost(self, error: Exception) -> DeviceLost:
        return DeviceLost(
            "the serial line broke", where=self._port_name, why=str(error), remedy="check cable and power of the device"
        )


def opening_failed(port: str, error: Exception) -> DeviceNotFound | DeviceDenied:
    """What it means that a port cannot be opened."""
    number = getattr(error, "errno", None)
    text = str(error)
    if number in (errno.EACCES, errno.EPERM) or "Permission denied" in text:
        remedy = (
            "add your user to the group that owns the port (dialout), or install the udev rule of "
            "docs/reference/wiring.md"
        )
        return DeviceDenied("the serial port may not be opened", where=port, why="permission denied", remedy=remedy)
    if number in (errno.EBUSY, errno.EAGAIN) or "exclusively lock" in text:
        remedy = "stop the other program"
        return DeviceDenied("another program uses the serial port", where=port, why=text, remedy=remedy)
    return DeviceNotFound("there is no such serial port", where=port, why=text, remedy="check the cable and the name")
