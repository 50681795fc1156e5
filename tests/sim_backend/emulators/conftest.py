from collections.abc import Callable, Iterator
from typing import Any

import pytest

from sim_backend.emulators.emulator import LabEmulator
from tests.kit.emulator_client import Client, connect, lab


@pytest.fixture
def lab_with() -> Iterator[Callable[..., LabEmulator]]:
    """Emulated labs with changes of the world; all are closed."""
    made: list[LabEmulator] = []

    def make(**changes: Any) -> LabEmulator:
        made.append(lab(**changes))
        return made[-1]

    yield make
    for each in made:
        each.close()


@pytest.fixture
def emulator(lab_with: Callable[..., LabEmulator]) -> LabEmulator:
    return lab_with()


@pytest.fixture
def client(emulator: LabEmulator) -> Iterator[Client]:
    one = connect(emulator)
    yield one
    one.close()
