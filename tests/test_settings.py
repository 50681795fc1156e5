import json
from pathlib import Path

import pytest

import config
from drivers.errors import ConfigError
from platform_daemon.app import check_config
from platform_daemon.settings import apply_override, load_platform, load_sequence, load_specimen, locate


@pytest.mark.parametrize("kind", ["platforms", "resonators", "sequences"])
def test_every_shipped_file_is_valid(kind, tmp_path):
    somewhere = {"host": "127.0.0.1", "port": 1, "command_port": 1, "data_port": 2}
    device = somewhere | {"vendor_id": 1, "product_id": 2, "serial": "A1"}
    endpoints = tmp_path / "endpoints.json"
    endpoints.write_text(json.dumps(
        {"io_cards": [somewhere] * 2, "serial": {"switch": "a", "lna": "b"}, "usb": {"amplifier": device}}
    ))  # fmt: skip

    def platform(name):
        return load_platform(name, endpoints=endpoints)

    load = {"platforms": platform, "resonators": load_specimen, "sequences": load_sequence}[kind]
    folder = locate("resonators", "thread").parent.parent / kind
    names = [p.stem for p in folder.glob("*.toml")]
    assert names
    for name in names:
        load(name)


def test_config_check_recognises_each_kind():
    for kind, name, word in (("platforms", "simulated", "platform"), ("resonators", "jewel", "resonator")):
        assert f"{word} '" in check_config(locate(kind, name))
    assert "sequence is valid" in check_config(locate("sequences", "jewel"))


def test_an_unknown_name_lists_what_ships():
    with pytest.raises(ConfigError, match="jewel, thread"):
        load_specimen("spring")


def test_a_name_cannot_lead_out_of_the_folder():
    with pytest.raises(ConfigError):
        locate("resonators", "../platforms/simulated")


@pytest.fixture
def broken(tmp_path):
    def write(old: str, new: str):
        text = locate("platforms", "simulated").read_text()
        assert old in text
        path = tmp_path / "broken.toml"
        path.write_text(text.replace(old, new, 1))
        return path

    return write


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ("[limits]", "[limit]", "limits"),
        ("max_field_t =", "max_field_ut =", "max_field_t"),
        ("max_field_t =", 'max_field_t = "1 mT" #', "max_field_t"),
        ("max_field_t =", "max_field_t = nan #", "max_field_t"),
        ("max_tx_duty =", "max_tx_duty = 2.0 #", "max_tx_duty"),
        ('backend = "simulated"', 'backend = "simulate"', "simulate"),
        ("seed =", 'seed = "x" #', "seed"),
        ("decimation =", "decimation = -1 #", "decimation"),
        ("[lna]", "[lnaa]", "lna"),
    ],
)
def test_a_broken_platform_file_is_refused_naming_file_and_key(broken, old, new, key):
    path = broken(old, new)
    with pytest.raises(Exception, match=key) as caught:
        check_config(path)
    assert caught.value.remedy


def test_what_is_not_toml_is_said_with_its_line(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("a = [")
    with pytest.raises(ConfigError, match="not TOML"):
        check_config(path)


def test_a_file_of_no_known_kind_is_said(tmp_path):
    path = tmp_path / "x.toml"
    path.write_text("a = 1")
    with pytest.raises(ConfigError, match="neither"):
        check_config(path)


def test_overrides_reach_nested_keys_and_are_kept_in_the_text():
    file = load_platform("simulated", ["backends.simulated.seed=12"])
    assert file.section.backends["simulated"]["seed"] == 12
    assert "# override: backends.simulated.seed=12" in file.text


@pytest.mark.parametrize("text", ["seed", "a=", "a=b", "a.b.c=1"])
def test_an_override_that_is_no_key_and_value_is_refused(text):
    with pytest.raises(ConfigError):
        apply_override({"a": {"b": 1}}, text)


def test_the_emulated_platform_is_one_file_under_both_its_names():
    folder = Path(config.__file__).parent
    assert (folder / "emulated.toml").samefile(folder / "platforms" / "emulated.toml")
