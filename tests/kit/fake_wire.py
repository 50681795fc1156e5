"""Wires that end in a function instead of a device."""

from __future__ import annotations

from collections.abc import Callable

from drivers.errors import DeviceTimeout

Device = Callable[[str], str | None]


class FakeWire:
    """Carries lines to a device that answers or says nothing; counts how often it was opened."""

    def __init__(self, device: Device, late: list[str] | None = None) -> None:
        self._device, self._answers = device, late or []
        self.closed = False

    def send(self, text: str) -> None:
        answer = self._device(text)
        if answer is not None:
            self._answers.append(answer)

    def receive(self) -> str:
        if not self._answers:
            raise DeviceTimeout("no answer")
        return self._answers.pop(0)

    def close(self) -> None:
        self.closed = True


class Opener:
    """Opens a new wire to the same device each time; on the next one, `late` answers from before arrive first."""

    def __init__(self, device: Device) -> None:
        self.device = device
        self.wires: list[FakeWire] = []
        self.late: list[str] = []

    def __call__(self) -> FakeWire:
        self.wires.append(FakeWire(self.device, self.late))
        self.late = []
        return self.wires[-1]
