import json

import pytest

from drivers.errors import InputError
from platform_daemon.core.recordings.evidence import file_digests
from platform_daemon.core.schemas.base import to_json
from platform_daemon.core.schemas.fits import FileDigest
from platform_daemon.features.diagnose.adoption import AdoptionRefused, model_from_diagnosis
from platform_daemon.features.models.library import Library, UnknownModel
from platform_daemon.features.models.resolve import label_of, model_of, resolve
from tests.kit.diagnosis_json import diagnosed, effect


@pytest.fixture
def library(tmp_path):
    return Library(tmp_path / "models")


def adopted(library, said=None, name="quiet", **options):
    said = diagnosed(effect("coulomb_friction", 30.0)) if said is None else said
    return library.add(
        model_from_diagnosis(
            said, name, "me", library, recordings=[FileDigest(file="a.h5", size_bytes=1, sha256="0")], **options
        )
    )


def test_a_model_gets_the_next_version_and_old_versions_stay_as_they_were(library):
    first = adopted(library)
    before = (library.folder / "quiet@1.json").read_bytes()
    second = adopted(library, diagnosed(effect("coulomb_friction", 35.0)))
    assert (first.label, second.label) == ("quiet@1", "quiet@2")
    assert (library.folder / "quiet@1.json").read_bytes() == before
    assert library.get("quiet") == second
    assert library.get("quiet@1") == first
    assert [m.label for m in library.all()[0]] == ["quiet@1", "quiet@2"]
    assert not list(library.folder.glob(".*"))


def test_a_held_strength_is_knowledge_of_the_model_and_a_free_one_is_not(library):
    held = adopted(library).model
    free = adopted(library, free=["coulomb_friction"]).model
    name = held.terms[-1].coefficients[0].name
    assert held.parameters[name].fixed == 30.0
    assert free.parameters[name].fixed is None
    assert [t.name for t in held.terms] == [t.name for t in free.terms]


def test_a_retired_version_is_left_out_by_name_but_found_by_its_number(library):
    adopted(library)
    adopted(library)
    library.retire("quiet@2", "me", "worn bearing")
    assert library.get("quiet").label == "quiet@1"
    assert library.get("quiet@2").retired.reason == "worn bearing"
    with pytest.raises(InputError, match="retired already"):
        library.retire("quiet@2", "me", "again")
    with pytest.raises(InputError, match="version"):
        library.retire("quiet", "me", "which?")
    library.retire("quiet@1", "me", "too")
    with pytest.raises(UnknownModel, match="retired"):
        library.get("quiet")
    assert adopted(library).label == "quiet@3"


def test_a_file_changed_by_hand_is_not_used(library):
    adopted(library)
    path = library.folder / "quiet@1.json"
    record = json.loads(path.read_text())
    record["terms"][0]["values"] = dict.fromkeys(record["terms"][0]["values"], 31.0)
    path.write_text(json.dumps(record))
    with pytest.raises(InputError, match="digest"):
        library.get("quiet")


@pytest.mark.parametrize("text", ["{", pytest.param("[" * 100_000, id="deep"), "[]", '{"format": 1}', "\udcff"])
def test_a_damaged_file_is_told_beside_the_models_that_can_be_used(library, text):
    good = adopted(library)
    path = library.folder / "loud@1.json"
    path.write_bytes(text.encode(errors="surrogateescape"))
    models, broken = library.all()
    assert ([m.label for m in models], [b.id for b in broken]) == ([good.label], ["loud@1"])
    assert "loud@1.json" in str(broken[0].error)
    assert resolve("quiet", library).label == good.label
    with pytest.raises(InputError, match="loud@1"):
        library.get("loud")
    with pytest.raises(UnknownModel, match="quiet@1"):
        library.get("nobody")


@pytest.mark.parametrize("name", ["Quiet", "thread", "a@1", "../a", "", "a" * 65])
def test_a_name_that_is_no_good_is_refused(library, name):
    with pytest.raises(InputError):
        adopted(library, name=name)
    assert not library.folder.exists()


@pytest.mark.parametrize("text", ["nothing", "quiet@9", "../quiet@1", "quiet@x", "quiet@"])
def test_a_name_that_nobody_knows_is_answered_with_those_there_are(library, text):
    adopted(library)
    with pytest.raises(InputError, match="quiet@1"):
        resolve(text, library)


def test_names_of_declared_models_stay_what_they_are(library):
    assert resolve("thread", library) == "thread"
    assert resolve("thread+bias_torque", None) == "thread+bias_torque"
    assert label_of(resolve("thread", library)) == "thread"
    assert resolve(None, library) is None


def test_a_second_diagnosis_adds_to_the_model_it_started_from(library):
    adopted(library)
    further = diagnosed(effect("bias_torque", 800.0), effect("crosstalk", 0.01, start="x", end="y"), model="quiet@1")
    made = adopted(library, further, name="quieter")
    assert made.base == "thread"
    assert [t.term for t in made.terms] == ["coulomb_friction", "bias_torque"]
    assert [(r.id, r.source, r.target) for r in made.receiver] == [("crosstalk", "x", "y")]
    assert model_of(made).name == "quieter@1"


def test_published_strengths_become_coefficients_of_the_terms(library):
    drift = adopted(library, diagnosed(effect("frequency_drift", 0.5, "Hz/s"), f_nat_hz=250.0))
    assert drift.terms[0].values == {"frequency_drift_per_s": 0.5 / 250.0}
    slow = effect("stribeck_friction", 0.3, stribeck_speed_rad_per_s=20.0)
    stribeck = adopted(library, diagnosed(slow, model="jewel", tf_over_i_rad_per_s2=40.0))
    assert stribeck.terms[0].values == {"stribeck_rad_per_s2": 0.3 * 40.0, "stribeck_speed_rad_per_s": 20.0}


@pytest.mark.parametrize(
    ("said", "options", "why"),
    [
        (diagnosed(verdict="nothing_missing"), {}, "nothing to adopt"),
        (diagnosed(verdict="unexplained"), {"force": "I want it"}, "nothing to adopt"),
        (diagnosed(effect("coulomb_friction", 30.0), verdict="unexplained"), {}, "does not explain"),
        (diagnosed(effect("mains_interference", 1e-3)), {}, "belongs to the data of one measurement.*Remedy"),
        (diagnosed(effect("switch_transient", 1e-3), effect("bias_torque", 1.0)), {}, "by name: bias_torque"),
        (diagnosed(effect("frequency_fluctuation", 0.2)), {}, "no model can hold"),
        (diagnosed(effect("clock_gap", 3.0)), {}, "cannot be adopted"),
        (diagnosed(effect("bias_torque", 1.0)), {"effects": ["crosstalk"]}, "does not name crosstalk"),
        (diagnosed(effect("channel_gain", 0.1, axis="x")), {"free": ["channel_gain"]}, "cannot be free"),
    ],
)
def test_what_cannot_be_adopted_is_refused_with_a_remedy(library, said, options, why):
    with pytest.raises(AdoptionRefused, match=why) as refused:
        adopted(library, said, **options)
    assert refused.value.remedy
    assert not library.folder.exists()


def test_a_forced_adoption_keeps_the_reason(library):
    said = diagnosed(effect("coulomb_friction", 30.0), verdict="unexplained")
    made = adopted(library, said, force="bearing known to be dirty")
    assert library.get(made.label).evidence.forced == "bearing known to be dirty"


@pytest.mark.parametrize(
    "said",
    [
        diagnosed(effect("bias_torque", float("nan"))),
        diagnosed(effect("frequency_drift", 1.0), f_nat_hz=None),
        diagnosed(effect("stribeck_friction", 0.3), model="jewel", tf_over_i_rad_per_s2=40.0),
    ],
)
def test_a_number_that_is_missing_is_named(library, said):
    with pytest.raises(InputError, match=r"diagnosis: .*missing.*diagnose again"):
        adopted(library, said)


def test_evidence_of_another_version_of_this_software_stays_as_it_is(library):
    adopted(library)
    path = library.folder / "quiet@1.json"
    record = json.loads(path.read_text())
    record["evidence"]["diagnosis"] = {"verdict": "explained", "later": [1, 2]}
    path.write_text(json.dumps(record))
    kept = library.get("quiet")
    assert kept.summary().adopted_by == "me"
    assert json.loads(to_json(kept.record())) == record


def test_the_evidence_holds_the_diagnosis_and_the_digests_of_its_data(library, tmp_path):
    data = tmp_path / "a.h5"
    data.write_bytes(b"abc")
    said = diagnosed(effect("bias_torque", 1.0))
    made = library.add(
        model_from_diagnosis(said, "quiet", "me", library, recordings=file_digests([data, tmp_path / "gone.h5"]))
    )
    kept = library.get(made.label).evidence
    assert kept.diagnosis == said
    assert kept.adopted_by == "me"
    assert kept.recordings[0].model_dump() == {
        "file": "a.h5", "size_bytes": 3, "sha256": "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
    }  # fmt: skip
    assert kept.recordings[1].sha256 is None
