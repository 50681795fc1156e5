"""Where the values of a series come from: what ships, what tune and a ramp have kept, files, the request."""

import hashlib
from dataclasses import replace

import h5py
import pytest

from drivers.errors import InputError, SequenceRejected
from drivers.specimen import SideModeLimit, Specimen
from platform_daemon.core.hardware.catalogue import Shelf, open_catalogue
from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording, read_calibration
from platform_daemon.core.schemas.base import EXAMPLES
from platform_daemon.core.schemas.requests import AcquisitionRequest, SequencePatch
from platform_daemon.core.schemas.value_sources import value_sources_text
from platform_daemon.core.service.bench import Folders, HardwareBench
from platform_daemon.core.settings import load_specimen
from platform_daemon.diagnosis.report_schema import DiagnosisReport
from platform_daemon.features.acquire.series_plan import plan, plan_series
from platform_daemon.features.diagnose.load_shots import load_diagnosis_input
from platform_daemon.features.diagnose.report import summary_text
from platform_daemon.features.fit.fit import fit_measurement
from platform_daemon.features.fit.fit_request import FitRequest
from platform_daemon.features.fit.measurement import open_measurement, open_voltages
from platform_daemon.features.fit.report import fit_table_text
from platform_daemon.features.procedures.bench import ProcedureBench
from platform_daemon.features.procedures.conductor import ProcedureFiles
from platform_daemon.features.procedures.planned import plan_procedure
from platform_daemon.features.ramp.resonator_limits import save_to_catalogue
from platform_daemon.features.ramp.schema import RampOutcome, RampThreshold
from platform_daemon.features.sweep.schema import SweepRequest
from platform_daemon.features.tune.presets import TunedPresets, declaration_sha256
from platform_daemon.features.tune.schema import TunedPreset, TuneOutcome
from tests.kit.acquisitions import acquire
from tests.kit.command_line import here

JOB, DATE = "procedure-20261126T101500-1a2b3c", "2026-11-26T10:15:00+00:00"
FOUND = {"f_tx_hz": 209.03, "tx_periods": 9, "field_t": 480e-6, "axis": "x", "rx_s": 2.4, "pause_s": 3.0}


def keep_preset(folder, digest=None):
    """The preset of a jewel, as tune keeps it in a data folder."""
    nothing = dict.fromkeys(
        ("f_nat_hz", "lambda_per_s", "tf_over_i_rad_per_s2", "swing_rad_per_t", "swing_rad", "d30_s")
    )
    found = TuneOutcome(
        kind="tune", design_f_nat_hz=229.3, shots=2, fields_t=(1e-4,), sequence=SequencePatch(**FOUND), **nothing
    )
    preset = TunedPreset(
        resonator="jewel", declaration_sha256=digest or declaration_sha256(load_specimen("jewel")[0]), date=DATE,
        procedure=JOB, recording="t.h5", found=found,
    )  # fmt: skip
    return TunedPresets(folder / "presets").keep(preset)


@pytest.fixture
def engine(engine_with, tmp_path):
    """On the shipped simulated platform, with the data folder `tmp_path`."""
    made = engine_with()
    made.catalogue = open_catalogue(
        tmp_path / "resonators", tmp_path / "sequences", None, TunedPresets(tmp_path / "presets")
    )
    return made


def planned(engine, resonator="jewel", **keys):
    return plan_series(engine, AcquisitionRequest.model_validate({"resonator": resonator, **keys}))


def sources(made):
    return {each.quantity: each for each in made.value_sources}


def test_a_preset_that_ships_is_said_to_ship_and_a_key_of_the_request_to_be_given(engine):
    found = sources(planned(engine, sequence={"rx_s": 1.0, "waveform": "rectangle"}))
    assert {key: each.source for key, each in found.items()} == {
        "resonator": "shipped", "f_tx_hz": "shipped", "tx_periods": "shipped", "field_t": "shipped", "axis": "shipped",
        "rx_s": "given", "waveform": "given", "pause_s": "shipped",
    }  # fmt: skip
    assert (found["f_tx_hz"].value, found["f_tx_hz"].path) == (212.0, "preset jewel")


def test_a_tuned_preset_is_used_unless_the_shipped_one_is_named_and_says_when_and_by_which_job(engine, tmp_path):
    keep_preset(tmp_path)
    for keys in ({}, {"preset": "tuned"}):
        made = planned(engine, **keys)
        assert (made.sequence.f_tx_hz, made.sequence.rx_s) == (209.03, 2.4)
        found = sources(made)["f_tx_hz"]
        assert (found.source, found.job, found.date, found.path) == ("tuned", JOB, DATE, "jewel@1")
        assert f"f_tx_hz 209.03, tx_periods 9, field_ut 480, axis x, rx_s 2.4, pause_s 3: tuned on 2026-11-26 by {JOB}"\
            in value_sources_text(made.summary().value_sources)  # fmt: skip
    shipped = planned(engine, preset="shipped")
    assert (shipped.sequence.f_tx_hz, shipped.sequence.rx_s) == (212.0, 2.0)
    assert {each.source for each in shipped.value_sources} == {"shipped"}


def test_a_tuned_preset_that_is_not_there_or_is_of_another_declaration_is_not_replaced_by_another(engine, tmp_path):
    with pytest.raises(InputError, match="no tuned preset of jewel") as refused:
        planned(engine, preset="tuned")
    assert refused.value.where == "preset"
    keep_preset(tmp_path, digest="0" * 64)
    with pytest.raises(InputError, match="another declaration"):
        planned(engine, preset="tuned")
    assert sources(planned(engine))["f_tx_hz"].source == "shipped"


def test_a_preset_of_a_file_is_named_by_its_path_and_by_rest_no_path_is_taken(engine, tmp_path):
    keep_preset(tmp_path)
    file = tmp_path / "gentle.toml"
    file.write_text("field_t = 2e-4\n")
    found = sources(planned(engine, preset=str(file)))
    assert (found["field_t"].value, found["field_t"].source, found["field_t"].path) == (2e-4, "file", str(file))
    assert found["f_tx_hz"].source == "tuned"
    engine.catalogue.sequences.add("quiet", SequencePatch(field_t=1e-4))
    found = sources(planned(engine, preset="quiet"))["field_t"]
    assert (found.source, found.path) == ("file", "quiet@1.toml")
    folders = Folders(**dict.fromkeys(Folders.__dataclass_fields__, tmp_path))
    bench = HardwareBench(engine=engine, folders=folders)
    for name, fine in (("quiet", True), ("shipped", True), ("tuned", True), (str(file), False)):
        request = AcquisitionRequest(resonator="jewel", preset=name)
        if fine:
            plan(bench, request)
        else:
            with pytest.raises(InputError, match="no sequence is called"):
                plan(bench, request)
    for taken in ("shipped", "tuned"):
        with pytest.raises(InputError, match="cannot be added"):
            engine.catalogue.sequences.add(taken, SequencePatch(field_t=1e-4))


def ramped(max_t):
    """The outcome of a ramp that has found a threshold."""
    return RampOutcome(
        kind="ramp", visible_am2_per_s=0.4, threshold_t=RampThreshold(value=max_t, low=max_t, high=max_t),
        operating_field_t=0.8 * max_t, max_field_t=max_t, false_stop_rate=0.002, overdose_rate=0.25, steps=(), lines=(),
        lines_hz=(), overshoot_t=0.0, drive_saturated=False,
    )  # fmt: skip


def test_a_limit_of_a_ramp_holds_by_name_says_its_job_and_leaves_the_tuned_preset_in_use(engine, tmp_path):
    keep_preset(tmp_path)
    assert save_to_catalogue(engine.catalogue, "jewel")(ramped(485e-6), JOB) == "jewel@1.toml"
    made = planned(engine)
    limit = sources(made)["max_field_t"]
    assert (limit.value, limit.source, limit.job, limit.path) == (485e-6, "ramp", JOB, "jewel@1.toml")
    assert f"max_field_ut 485: limit from ramp {JOB} on 20" in value_sources_text(made.value_sources)
    assert made.sequence.f_tx_hz == 209.03
    assert made.warnings == planned(engine, preset="tuned").warnings
    with pytest.raises(SequenceRejected, match="side modes"):
        planned(engine, preset="shipped")


def test_a_preset_that_an_earlier_version_has_kept_with_a_limit_is_still_used(engine, tmp_path):
    limit = SideModeLimit(max_field_t=6e-4, operating_field_t=4.8e-4, found=DATE, evidence="ramp x: threshold 600 uT")
    limited = load_specimen("jewel")[0].model_copy(update={"side_modes": limit})
    engine.catalogue.resonators.add("jewel", limited, in_its_place=True)
    old_text = limited.model_dump_json().replace(',"job":null}', "}")
    keep_preset(tmp_path, digest=hashlib.sha256(old_text.encode()).hexdigest())
    assert sources(planned(engine))["f_tx_hz"].source == "tuned"
    assert sources(planned(engine))["max_field_t"].job is None


def test_the_recording_stores_every_source_and_its_description_shows_them(engine, tmp_path):
    keep_preset(tmp_path)
    sequence = SequencePatch.model_validate({"rx_s": 0.3, "axis": [1.0, 0.0, 0.25]})
    acquire(engine, tmp_path / "m.h5", sequence=sequence, window=None)
    with h5py.File(tmp_path / "m.h5") as h5:
        kept = h5["entry/value_sources"]
        assert (kept["f_tx_hz"][()], kept["f_tx_hz"].attrs["units"]) == (209.03, "Hz")
        said = {name: kept["f_tx_hz"].attrs[name] for name in ("source", "job", "date", "path")}
        assert said == {"source": "tuned", "job": JOB, "date": DATE, "path": "jewel@1"}
        assert "job" not in kept["rx_s"].attrs
    info = describe(open_recording(tmp_path / "m.h5"))
    found = {each.quantity: each for each in info.value_sources}
    assert (found["tx_periods"].value, found["tx_periods"].job) == (9, JOB)
    assert (found["rx_s"].value, found["rx_s"].source) == (0.3, "given")
    assert (found["axis"].value, found["axis"].source) == ("1,0,0.25", "given")


def test_the_steps_of_a_procedure_say_their_sources_and_the_recording_those_of_the_last(engine, tmp_path):
    keep_preset(tmp_path)
    request = SweepRequest.model_validate(
        {"kind": "sweep", "acquisition": {"resonator": "jewel", "sequence": {"rx_s": 0.3}, "window": None},
         "over": [{"key": "field_ut", "values": [100, 200]}]}
    )  # fmt: skip
    files = ProcedureFiles(tmp_path, tmp_path, tmp_path / "s.h5", tmp_path / "s.json")
    work = plan_procedure(ProcedureBench(engine=engine, files=files), request)
    assert {s.quantity: s.value for s in work.summary().value_sources}["field_t"] == pytest.approx(2e-4)
    job = engine.submit(work)
    assert job.ended.wait(timeout=120)
    by_step = [{s.quantity: s for s in step.value_sources} for step in job.result.steps]
    assert [step["field_t"].value for step in by_step] == pytest.approx([1e-4, 2e-4])
    assert {step["f_tx_hz"].source for step in by_step} == {"tuned"}
    said = open_recording(tmp_path / "s.h5").provenance
    assert said.sources_step == 2
    assert {s.quantity: s.value for s in said.value_sources}["field_t"] == pytest.approx(2e-4)
    measured = open_voltages(tmp_path / "s.h5")
    of_step = [{s.quantity: s for s in measured.value_sources([frame])} for frame in range(2)]
    assert (set(of_step[0]), "field_t" in of_step[1]) == ({"calibration"}, True)


def test_fits_and_diagnoses_say_the_sources_of_their_files_and_of_the_calibration(engine, tmp_path):
    keep_preset(tmp_path)
    acquire(engine, tmp_path / "m.h5", sequence=SequencePatch.model_validate({"rx_s": 0.3}), window=None)
    tuned, own = f"tuned on 2026-11-26 by {JOB} (jewel@1)", "calibration simulated-exact-1: of the recording"
    report = fit_measurement(open_measurement(tmp_path / "m.h5"), FitRequest("jewel", "n50"))
    assert {each.quantity for each in report.value_sources} >= {"f_tx_hz", "rx_s", "calibration"}
    assert tuned in fit_table_text(report)
    assert own in fit_table_text(report)
    other = tmp_path / "other.h5"
    other.write_bytes((tmp_path / "m.h5").read_bytes())
    named = (read_calibration(other), str(other))
    report = fit_measurement(open_measurement(tmp_path / "m.h5", named), FitRequest("jewel", "n50"))
    assert (report.value_sources[-1].source, report.value_sources[-1].path) == ("file", str(other))
    (found,) = load_diagnosis_input([tmp_path / "m.h5"]).recorded_sources(lambda path: path.name)
    assert found.file == "m.h5"
    text = summary_text(example_report(value_sources=(found,)))
    assert f"m.h5: {own}" in text
    assert f"m.h5: f_tx_hz 209.03, field_ut 480, pause_s 3, tx_periods 9: {tuned}" in text.replace("axis x, ", "")


def example_report(**changes):
    """The example of a diagnosis, with other values of some keys."""
    text = (EXAMPLES / "diagnosis_report.json").read_text(encoding="utf-8")
    return DiagnosisReport.model_validate_json(text).model_copy(update=changes)


def test_on_the_command_line_presets_and_limits_are_those_of_the_data_folder(tmp_path):
    keep_preset(tmp_path / "lab")
    shelf = Shelf("resonators", Specimen, None, tmp_path / "lab" / "resonators")
    save_to_catalogue(replace(open_catalogue(tmp_path, tmp_path), resonators=shelf), "jewel")(ramped(482e-6), JOB)
    words = ("characterise", "--resonator", "jewel", "--no-tune", "--no-ramp", "--shots", "1", "--dry-run")
    done = here(*words, "--data", tmp_path / "lab")
    assert done.returncode == 0, done.stderr
    assert f"tuned on 2026-11-26 by {JOB} (jewel@1)" in done.stdout
    assert f"field_ut 385.6: from ramp {JOB}" in done.stdout
    assert f"max_field_ut 482: limit from ramp {JOB}" in done.stdout
    done = here("measure", "--resonator", "jewel", "--data", tmp_path / "lab", "--preset", "shipped", "--dry-run")
    assert done.returncode == 2
    assert "side modes" in done.stderr
    done = here("measure", "--resonator", "jewel", "--data", tmp_path / "other", "--dry-run")
    assert "f_tx_hz 212" in done.stdout
