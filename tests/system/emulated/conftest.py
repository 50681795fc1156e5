"""Emulated labs: one for all tests that leave it as it was, and labs of a test's own."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import pytest

from tests.kit.emulated_lab import Lab


@pytest.fixture(scope="session")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """One for all tests that leave it as it was."""
    made = Lab(tmp_path_factory.mktemp("lab"))
    yield made
    made.emulator.close()


@pytest.fixture(scope="class")
def lab_of_its_own(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[..., Lab]]:
    """Labs with overrides of the emulator file."""
    made: list[Lab] = []

    def make(*overrides: str) -> Lab:
        made.append(Lab(tmp_path_factory.mktemp("lab"), *overrides))
        return made[-1]

    yield make
    for each in made:
        each.emulator.close()
