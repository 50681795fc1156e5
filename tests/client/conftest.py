"""One daemon for all tests of the client, with a series of two shots."""

from __future__ import annotations

import pytest

from platform_daemon.client import Client
from tests.kit.acquisitions import SHORT
from tests.kit.served import served


@pytest.fixture(scope="package")
def running(tmp_path_factory):
    with served(tmp_path_factory.mktemp("client") / "data") as daemon:
        yield daemon


@pytest.fixture(scope="package")
def lab(running):
    with Client(running.address) as client:
        yield client


@pytest.fixture(scope="package")
def series(lab):
    return lab.measure("jewel", shots=2, field_ut=490, window="d30", sample="T-07", **SHORT).wait(timeout_s=120)
