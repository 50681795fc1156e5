import json
from pathlib import Path

import pytest

import config
from drivers.errors import ConfigError, InputError
from platform_daemon.core.settings import (
    apply_override,
    load_platform,
    load_sequence,
    load_specimen,
    locate,
    real_time_overrides,
)


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


def test_an_unknown_name_lists_what_ships():
    with pytest.raises(ConfigError, match="jewel, jewel_imperfect, jewel_published, thread, thread_imperfect"):
        load_specimen("spring")


def test_a_name_cannot_lead_out_of_the_folder():
    with pytest.raises(ConfigError):
        locate("resonators", "../platforms/simulated")


def test_overrides_reach_nested_keys_and_are_kept_in_the_text():
    file = load_platform("simulated", ["backends.simulated.seed=12"])
    assert file.section.backends["simulated"]["seed"] == 12
    assert "# override: backends.simulated.seed=12" in file.text


@pytest.mark.parametrize("text", ["seed", "a=", "a=b", "a.b.c=1", pytest.param("a=" + "[" * 50_000, id="deep")])
def test_an_override_that_is_no_key_and_value_is_refused(text):
    with pytest.raises(ConfigError):
        apply_override({"a": {"b": 1}}, text)


def test_the_emulated_platform_is_one_file_under_both_its_names():
    folder = Path(config.__file__).parent
    assert (folder / "emulated.toml").samefile(folder / "platforms" / "emulated.toml")


def test_simulated_time_passes_as_the_computers_if_that_is_said():
    changed = load_platform("simulated", real_time_overrides("simulated"))
    assert changed.section.backends["simulated"]["clock"]["mode"] == "realtime"


def test_real_devices_have_no_simulated_time():
    with pytest.raises(InputError, match="platform lab has no simulated time") as refused:
        real_time_overrides("lab")
    assert refused.value.where == "--real-time"
    assert "leave --real-time out" in refused.value.remedy
