"""What features offer by name is there, and a new kind of job needs a folder and a line of the registry."""

import ast
import inspect
import json
import subprocess
import sys
from pathlib import Path

import pytest

import platform_daemon
from platform_daemon.core.registry import features, job_features, kinds, procedures
from platform_daemon.core.schemas.base import QueuedRequest, Request, Root, Schema

JOBS = list(job_features())


@pytest.mark.parametrize("feature", JOBS, ids=lambda feature: feature.kind.name)
def test_what_a_kind_of_job_names_is_there(feature):
    kind = feature.kind
    assert [*inspect.signature(feature.load(kind.plan)).parameters] == ["bench", "request"]
    assert issubclass(feature.load(kind.result), Schema | Root)
    assert bool(kind.dry_run) == bool(kind.summary)
    if kind.dry_run:
        assert [*inspect.signature(feature.load(kind.dry_run)).parameters] == ["bench", "request"]
        assert issubclass(feature.load(kind.summary), Schema)
    if kind.scheduled:
        assert issubclass(feature.load(kind.scheduled), Schema)
    if inspect.isclass(feature.request_type):
        assert issubclass(feature.request_type, QueuedRequest if kind.needs_hardware else Request)


@pytest.mark.parametrize("feature", features(), ids=lambda feature: feature.package.rpartition(".")[2])
def test_the_modules_that_a_feature_names_are_there(feature):
    for place in feature.routes:
        assert feature.load(f"{place}:router").routes
    for place in feature.errors:
        assert inspect.ismodule(feature.load(place))
    if feature.service:
        assert inspect.isclass(feature.load(feature.service))


def test_names_are_used_once():
    assert len({each.kind.name for each in JOBS}) == len({each.kind.plural for each in JOBS}) == len(JOBS)
    found = [procedure.name for _, procedure in procedures()]
    assert len(set(found)) == len(found)
    assert kinds(on_hardware=True).isdisjoint(kinds(on_hardware=False))
    assert kinds(on_hardware=True) | kinds(on_hardware=False) == {each.kind.name for each in JOBS}


NOT_THE_KIND = {
    "command_line/request_fields.py": {"tune"},  # key of a CharacteriseRequest
    "hardware/calibration_in_use.py": {"calibration"},  # key of a request that names the calibration in use
    "hardware/engine.py": {"calibration"},  # the same key
    "service/local.py": {"calibration"},  # the same key
    "hardware/live_estimate.py": {"acquisition"},  # key of a harmonic estimate
    "jobs/job_registry.py": {"fit"},  # key of results that hold fits
    "jobs/shot_log.py": {"fit"},  # key of a shot
    "recordings/calibrations.py": {"calibration"},  # name of a file in memory
    "recordings/dmdt_bytes.py": {"calibration"},  # key of the header of dm/dt
    "recordings/reader.py": {"calibration"},  # group of a calibration file
    "recordings/recording.py": {"calibration"},  # source of a calibration
    "schemas/events.py": {"fit"},  # kind of an event: a shot has been fitted
    "schemas/requests.py": {"calibration"},  # key of an example of an ActivationRequest
    "schemas/value_sources.py": {"procedure", "ramp"},  # sources of a value
    "settings.py": {"calibration", "self_test"},  # key and table of a platform file
}
"""Words in core that are spelt like a kind of job or procedure and mean something else, by file."""


def words_of(path: Path) -> set[str]:
    """The texts in a file, without its docstrings."""
    tree, documented = ast.parse(path.read_text()), (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)
    first = [node.body[0] for node in ast.walk(tree) if isinstance(node, documented) and node.body]
    docstrings = {id(each.value) for each in first if isinstance(each, ast.Expr)}
    constants = [node for node in ast.walk(tree) if isinstance(node, ast.Constant) and id(node) not in docstrings]
    return {node.value for node in constants if isinstance(node.value, str)}


def test_core_names_no_kind_of_job_and_no_procedure():
    """What core decides by the kind of a job is data of the registry."""
    names = {each.kind.name for each in JOBS} | {procedure.name for _, procedure in procedures()}
    core = Path(platform_daemon.__file__).parent / "core"
    named = {str(path.relative_to(core)): words_of(path) & names for path in core.rglob("*.py")}
    assert {path: found for path, found in named.items() if found} == NOT_THE_KIND


PLANS = """
import sys
from platform_daemon.core.registry import features, job_features
features()
print([name for name in sys.modules if name.startswith("platform_daemon.features.") and name.count(".") > 2])
for each in job_features():
    if each.kind.needs_hardware:
        each.load(each.kind.plan)
heavy = {"numba", "matplotlib", "fastapi", "uvicorn"}
apart = ("routes", "command", "report")
print([name for name in sys.modules if name.partition(".")[0] in heavy])
print([n for n in sys.modules if n.startswith("platform_daemon.features.") and n.rpartition(".")[2] in apart])
"""


def test_the_registry_loads_no_feature_and_the_process_of_the_hardware_their_work_only():
    done = subprocess.run([sys.executable, "-c", PLANS], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines() == ["[]"] * 3


COUNT = {
    "__init__.py": '''
"""Counts."""
from platform_daemon.core.registry import Feature, JobKind
FEATURE = Feature(
    job=JobKind(
        name="count", plural="counts", request=".schema:CountRequest", result=".schema:CountReport", plan=".work:plan",
        description="A count.", article="A count",
    ),
    tag=("counts", "Counting"),
)
''',
    "schema.py": '''
"""What may be counted."""
from platform_daemon.core.schemas.base import QueuedRequest, Schema
class CountRequest(QueuedRequest):
    """Count."""
    up_to: int
    """Last number."""
class CountReport(Schema):
    """Counted."""
    numbers: tuple[int, ...]
    """All numbers."""
''',
    "work.py": '''
"""Counting."""
from drivers.errors import InputError
from platform_daemon.core.schemas.base import NoResult
from .schema import CountReport
class CountWork:
    """Counts."""
    kind, unit, no_result, duration_s = "count", "numbers", NoResult(), None
    def __init__(self, request):
        self.request, self.total = request, request.up_to
    def __call__(self, job):
        for number in range(self.total):
            job.at(number + 1, "count")
        job.result = CountReport(numbers=tuple(range(1, self.total + 1)))
def plan(bench, request):
    """Raises InputError."""
    if request.up_to < 1:
        raise InputError("there is nothing to count", where="up_to", remedy="give a number from 1")
    return CountWork(request)
''',
}
TOY = """
import json, sys
from pathlib import Path
import platform_daemon.features
from platform_daemon.features import registry
platform_daemon.features.__path__.append(sys.argv[1])
registry.FEATURES = (*registry.FEATURES, "count")
from starlette.testclient import TestClient
from platform_daemon.core.hardware.catalogue import open_catalogue
from platform_daemon.core.jobs.job_records import JobRecords
from platform_daemon.core.recordings.data_folder import open_data_folder
from platform_daemon.core.settings import load_platform
from platform_daemon.core.web.server import create_api
from platform_daemon.features.schedules.schema import ScheduleRequest
from platform_daemon.processes.assembly import start_engine
from tests.kit.linked_api import linked_context
from tests.kit.rest import finished
data, events = open_data_folder(Path(sys.argv[2])), []
engine = start_engine(
    load_platform("simulated"), JobRecords(data.state), catalogue=open_catalogue(data.resonators, data.sequences),
    tell=events.append,
)
api = create_api(linked_context(engine, data))
with TestClient(api, raise_server_exceptions=False, base_url="http://127.0.0.1") as client:
    found = {"refused": client.post("/counts", json={"up_to": 0}).json()["detail"]}
    found["invalid"] = client.post("/counts", json={"up_to": "three"}).status_code
    answer = client.post("/counts", json={"up_to": 3, "priority": 5})
    job = finished(client, answer.headers["location"])
    found |= {"started": answer.status_code, "state": job["state"], "result": job["result"]}
    found |= {"priority": job["priority"], "progress": job["progress"]["done"]}
    found["listed"] = [each["id"] for each in client.get("/counts").json()["items"]] == [job["id"]]
    found["cancelled"] = client.delete(f"/counts/{job['id']}").json()["state"]
    found["edited"] = client.put(f"/counts/{job['id']}", json={"up_to": 4}).status_code
    found["paths"] = sorted(path for path in api.openapi()["paths"] if "count" in path)
found["events"] = [str(each.state) for each in events if getattr(each, "job", None) == job["id"]]
found["kept"] = JobRecords(data.state).one(job["id"]).result.model_dump()
work = {"kind": "count", "request": {"up_to": 2}}
asked = {"name": "nightly", "trigger": {"every_s": 60.0}, "work": work}
found["scheduled"] = ScheduleRequest.model_validate(asked).work.request.up_to
engine.close()
print(json.dumps(found))
"""


@pytest.mark.long
def test_a_new_kind_of_job_is_a_folder_and_a_line_of_the_registry(tmp_path):
    """It has routes, a place in the queue, records, events and schedules."""
    folder = tmp_path / "features" / "count"
    folder.mkdir(parents=True)
    for name, text in COUNT.items():
        (folder / name).write_text(text.lstrip())
    command = [sys.executable, "-c", TOY, str(folder.parent), str(tmp_path / "data")]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=120)
    assert done.returncode == 0, done.stderr[-3000:]
    found = json.loads(done.stdout.splitlines()[-1])
    assert "there is nothing to count" in found.pop("refused")
    assert found == {
        "invalid": 422,
        "started": 202,
        "state": "done",
        "result": {"numbers": [1, 2, 3]},
        "priority": 5,
        "progress": 3.0,
        "listed": True,
        "cancelled": "done",
        "edited": 409,
        "paths": ["/counts", "/counts/{identifier}"],
        "events": ["queued", "running", "done"],
        "kept": {"numbers": [1, 2, 3]},
        "scheduled": 2,
    }
