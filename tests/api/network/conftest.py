"""A daemon on the simulated platform whose data folder holds a token of every role; one per test module."""

from dataclasses import dataclass
from pathlib import Path

import pytest
from starlette.testclient import TestClient

from platform_daemon.api.network.callers import Gate
from platform_daemon.api.network.policy import Network
from platform_daemon.api.server import create_api
from platform_daemon.api.stop_server import create_stop_api
from platform_daemon.app import start_engine
from platform_daemon.engine import Engine
from platform_daemon.engine.catalogue import open_catalogue
from platform_daemon.engine.job_records import JobRecords
from platform_daemon.schemas.access import Role
from platform_daemon.settings import load_platform
from platform_daemon.store.audit import AuditLog
from platform_daemon.store.data_folder import open_data_folder
from platform_daemon.store.tokens import TokenFile
from tests.kit.linked_api import linked_context


@dataclass
class Secured:
    """Its client and that of its port for stop, the files of its data folder, headers by role."""

    client: TestClient
    stopping: TestClient
    tokens: TokenFile
    audit: AuditLog
    folder: Path
    engine: Engine
    headers: dict[Role | None, dict[str, str]]


@pytest.fixture(scope="module")
def secured(tmp_path_factory):
    folder = open_data_folder(tmp_path_factory.mktemp("data"))
    tokens, audit = TokenFile(folder.tokens), AuditLog(folder.audit)
    headers = {role: {"Authorization": f"Bearer {tokens.add(f'the-{role}', role)}"} for role in Role}
    catalogue = open_catalogue(folder.resonators, folder.sequences)
    engine = start_engine(load_platform("simulated"), JobRecords(folder.jobs), catalogue=catalogue)
    context, network = linked_context(engine, folder), Network(Gate(tokens), audit=audit)
    base = "http://127.0.0.1"
    with (
        TestClient(create_api(context, network), raise_server_exceptions=False, base_url=base) as client,
        TestClient(
            create_stop_api(context.hardware.outputs_off, network), raise_server_exceptions=False, base_url=base
        ) as stopping,
    ):
        yield Secured(client, stopping, tokens, audit, folder.tokens.parent, engine, {None: {}, **headers})
    engine.close()
