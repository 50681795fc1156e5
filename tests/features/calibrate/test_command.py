"""`platform-daemon calibrate`, from the command line to a platform that takes what it wrote."""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from platform_daemon.cli.main import main
from platform_daemon.core.hardware.engine import Engine
from platform_daemon.core.recordings.calibrations import read_transmit_calibration
from platform_daemon.core.recordings.reader import read_calibration
from platform_daemon.core.state.audit import audit_log_in


@pytest.fixture
def run(monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    """A command in this process; its exit code."""

    def command(*arguments: str) -> int:
        monkeypatch.setattr(sys, "argv", ["platform-daemon", *arguments])
        with pytest.raises(SystemExit) as ended:
            main()
        return int(ended.value.code or 0)

    return command


def test_both_calibrations_are_written_and_a_platform_takes_them(
    run: Callable[..., int], engine_with: Callable[..., Engine], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    folder = tmp_path / "calibrations"
    (tmp_path / ".lock").touch()  # a daemon has worked there
    few = ("--frequency-hz", "212", "--frequency-hz", "424", "--repetitions", "1", "--out", str(folder))
    named = []
    for kind, table in (("receive", "calibration"), ("transmit", "transmit_calibration")):
        assert run("calibrate", kind, *few, "--json", str(tmp_path / "made.json"), "--force") == 0
        made = json.loads((tmp_path / "made.json").read_text())
        assert f'[{table}] file = "{folder / made["file"]}"' in capsys.readouterr().out.replace("\n", "")
        named.append(f'{table}={{file="{folder / made["file"]}"}}')
    platform = engine_with(*named).platform
    receive, transmit = (tmp_path / made.partition('"')[2].rpartition('"')[0] for made in named)
    assert platform.calibration.identifier == read_calibration(receive).identifier
    assert platform.transmit_calibration is not None
    assert platform.transmit_calibration.identifier == read_transmit_calibration(transmit).identifier
    audited = audit_log_in(tmp_path).entries()
    assert [(e.what, e.address, e.request.partition(":")[0]) for e in audited] == [
        ("start_calibration", "command line", kind) for kind in ("receive", "transmit")
    ]


def test_an_output_that_cannot_feed_a_dipole_is_an_error_of_one_line(
    run: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert run("calibrate", "receive", "--set", "reference_dipole.output=1", "--out", str(tmp_path)) == 2
    (line,) = capsys.readouterr().err.strip().splitlines()
    assert line.startswith("error:")
    assert "reference_dipole" in line
    assert list(tmp_path.iterdir()) == []
