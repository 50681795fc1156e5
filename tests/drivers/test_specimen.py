import tomllib

import pytest
from pydantic import ValidationError

from drivers.specimen import Measured, Specimen
from tests.kit.data import CONFIG


def with_tables(name, **tables):
    shipped = tomllib.loads((CONFIG / "resonators" / f"{name}.toml").read_text())
    return Specimen.model_validate({**shipped, **tables})


RIGID = {"model": "rigid_body"}


@pytest.mark.parametrize(
    ("name", "tables", "words"),
    [
        ("thread", {"defects": {"stator_tilt_rad": 0.01}}, r"\[defects\]: a single_axis rotor has no side modes"),
        (
            "thread",
            {"rotor": {"model": "single_axis", "side_damping_per_s": 2.0}},
            "rotor.side_damping_per_s: a single_axis rotor",
        ),
        ("thread", {"rotor": RIGID, "defects": {"jewel_tilt_rad": 0.01}}, "leave defects.jewel_tilt_rad out"),
        ("jewel", {"rotor": RIGID, "defects": {"rotor_tilt_rad": 0.01}}, "leave defects.rotor_tilt_rad out"),
        ("jewel", {"rotor": RIGID, "defects": {"stator_tilt_rad": 1.0}}, "less than or equal to 0.6"),
        ("jewel", {"rotor": RIGID, "defects": {"stator_tilt_deg": 1.0}}, "Extra inputs are not permitted"),
        ("jewel", {"rotor": {"model": "double_pendulum"}}, "'single_axis' or 'rigid_body'"),
    ],
)
def test_what_cannot_be_is_refused_with_what_to_do(name, tables, words):
    with pytest.raises(ValidationError, match=words):
        with_tables(name, **tables)


def test_a_specimen_of_before_moves_about_a_single_axis_and_survives_a_round_trip():
    tables = tomllib.loads((CONFIG / "resonators" / "thread.toml").read_text())
    del tables["rotor"]
    old = Specimen.model_validate(tables)
    assert old.rotor.model == "single_axis"
    assert Specimen.model_validate(old.model_dump()) == old


@pytest.mark.parametrize("name", ["thread", "jewel"])
@pytest.mark.parametrize("tables", [{"measured": {}}, {}])
def test_of_a_new_specimen_nothing_has_been_measured(name, tables):
    shipped = tomllib.loads((CONFIG / "resonators" / f"{name}.toml").read_text())
    del shipped["measured"]
    assert Specimen.model_validate({**shipped, **tables}).measured == Measured()
