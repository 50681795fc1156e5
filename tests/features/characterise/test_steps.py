"""Analyses of a procedure's recording take one step of it and say which: characterise, fit, diagnose, trend."""

import json

import pytest

from drivers.errors import InputError
from platform_daemon.core.jobs.workers.task_executor import InProcessExecutor
from platform_daemon.core.recordings.data_folder import data_paths
from platform_daemon.core.schemas.jobs import JobState
from platform_daemon.core.service.bench import AnalysisBench
from platform_daemon.core.settings import load_platform
from platform_daemon.features.characterise.schema import (
    CharacterisationBatch,
    CharacterisationReport,
    CharacterisationRequest,
    RampSettings,
)
from platform_daemon.features.characterise.tables_work import plan as tables_plan
from platform_daemon.features.diagnose.load_shots import load_diagnosis_input
from platform_daemon.features.diagnose.request_schema import DiagnosisRequest
from platform_daemon.features.diagnose.work import plan as diagnosis_plan
from platform_daemon.features.fit.request_schema import RecordingFitRequest
from platform_daemon.features.fit.work import plan as fit_plan
from platform_daemon.features.trends.indexed import indexed_trend, update_index
from platform_daemon.processes.assembly import start_engine
from tests.kit.command_line import assert_one_line_error, here
from tests.kit.sweeps import swept


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    """A sweep over two fields, two shots each."""
    folder = tmp_path_factory.mktemp("sweep") / "recordings"
    folder.mkdir()
    engine = start_engine(load_platform("simulated"))
    fields = {"key": "field_ut", "values": [150, 400]}
    job = swept(engine, folder, fields, shots=2, window="n50", sequence={"rx_s": 0.6, "pause_s": 5.0}, sample="J-9")
    engine.close()
    assert job.state is JobState.DONE, job.error
    return folder / "s.h5"


def test_the_page_says_where_the_values_come_from(path, tmp_path):
    done = here("characterise", "--from", path, "--html", tmp_path / "c.html")
    assert done.returncode == 0, done.stderr
    assert "axis x, f_tx_hz 212, tx_periods 10: shipped (preset jewel)" in (tmp_path / "c.html").read_text()


def characterised(path, target, *options):
    done = here("characterise", "--from", path, *options, "--json", target)
    assert done.returncode == 0, done.stderr
    return CharacterisationReport.model_validate_json(target.read_text()), done.stdout


def test_characterise_takes_the_last_step_of_a_procedure_unless_another_is_named(path, tmp_path):
    report, said = characterised(path, tmp_path / "last.json")
    assert [frame.frame for frame in report.d30_fits.frames] == [2, 3]
    assert report.excitation.field_t == pytest.approx(400e-6)
    taken = "s.h5: step 2 (sweep, field_ut = 400) of 2 is taken, frames 2 to 3; the other steps are left out"
    assert report.notes[0] == taken
    assert f"note: {taken}" in said
    assert {each.quantity: each.value for each in report.value_sources}["field_t"] == pytest.approx(400e-6)
    report, _ = characterised(path, tmp_path / "first.json", "--step", "1")
    assert [frame.frame for frame in report.d30_fits.frames] == [0, 1]
    # Of the sequence the file keeps the sources of its last step alone.
    assert [each.quantity for each in report.value_sources] == ["calibration"]


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--frames", "1,2"), ("2 steps", "mix", "name the step")),
        (("--step", "3"), ("no step is '3'", "from 1 to 2")),
        (("--step", "all"), ("mix", "name one step")),
        (("--step", "1", "--frames", "0"), ("exclude each other",)),
    ],
)
def test_characterise_refuses_to_mix_steps(path, options, words):
    assert_one_line_error(here("characterise", "--from", path, *options), 2, *words)


def test_several_files_are_characterised_each_by_itself(path, tmp_path):
    other = tmp_path / "other.h5"
    other.write_bytes(path.read_bytes())
    files = ("--from", path, "--from", other)
    done = here("characterise", *files, "--json", tmp_path / "c.json")
    assert done.returncode == 0, done.stderr
    found = CharacterisationBatch.model_validate_json((tmp_path / "c.json").read_text())
    assert [each.file for each in found.files] == [str(path), str(other)]
    assert f"{other}:" in done.stdout
    assert_one_line_error(here("characterise", *files, "--html", tmp_path / "c.html"), 2, "--html", "one recording")
    assert_one_line_error(here("characterise", *files, "--from", tmp_path / "no.h5"), 2, "no such file")


def test_fit_takes_the_last_step_and_says_so_or_all_of_them(path, tmp_path):
    def fitted(*options):
        done = here("fit", path, "--window", "n50", *options, "--json", tmp_path / "f.json", "--force")
        assert done.returncode == 0, done.stderr
        return json.loads((tmp_path / "f.json").read_text())

    last = fitted()
    assert [frame["frame"] for frame in last["frames"]] == [2, 3]
    assert any("step 2 (sweep, field_ut = 400) of 2 is taken" in note for note in last["notes"])
    everything = fitted("--step", "all")
    assert [frame["frame"] for frame in everything["frames"]] == [0, 1, 2, 3]
    assert not any("is taken" in note for note in everything["notes"])
    assert [frame["frame"] for frame in fitted("--frames", "1,2")["frames"]] == [1, 2]


def test_diagnose_takes_the_last_step_and_says_so(path):
    loaded = load_diagnosis_input([path])
    assert len(loaded.shots) == 2
    assert any("step 2 (sweep, field_ut = 400) of 2 is taken" in note for note in loaded.notes)
    assert len(load_diagnosis_input([path], steps={path: "all"}).shots) == 4
    with pytest.raises(InputError, match="no step is 'series'"):
        load_diagnosis_input([path], steps={path: "series"})


def test_a_request_names_the_step_too(path):
    bench = AnalysisBench(executor=InProcessExecutor(), folders=data_paths(path.parent.parent))
    asked = {"recording": "s", "window": "n50"}
    assert fit_plan(bench, RecordingFitRequest.model_validate(asked)).task.frames == (2, 3)
    assert fit_plan(bench, RecordingFitRequest.model_validate({**asked, "step": "1"})).task.frames == (0, 1)
    tables = tables_plan(bench, CharacterisationRequest.model_validate({"recording": "s", "step": "sweep"}))
    assert tables.task.settings.frames == (2, 3)
    assert "step 2" in tables.task.remarks[0]
    for step in ("all", "1"):
        diagnosis_plan(bench, DiagnosisRequest.model_validate({"recordings": [{"recording": "s", "step": step}]}))
    with pytest.raises(InputError, match="no step is 'ramp'"):
        diagnosis_plan(bench, DiagnosisRequest.model_validate({"recordings": [{"recording": "s", "step": "ramp"}]}))


def test_a_trend_takes_the_last_step_of_a_procedure_and_says_so(path):
    update_index(path.parent)
    report = indexed_trend(path.parent, "J-9")
    assert [point.shots for point in report.points] == [2]
    assert report.notes[0] == "of procedures one step is taken, the last: s: step 2 (sweep, field_ut = 400)"


def test_a_ramp_that_begins_above_its_highest_field_is_refused_in_the_request():
    with pytest.raises(ValueError, match="start_t lies above max_t"):
        RampSettings(start_t=1e-3, max_t=1e-4)
