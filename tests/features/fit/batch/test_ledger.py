import os

import numpy as np
import pytest

from drivers.calibration import ReceiveCalibration
from drivers.errors import InputError
from platform_daemon.core.schemas.fits import LedgerLine, unfitted
from platform_daemon.features.fit.batch.ledger import Ledger
from platform_daemon.features.fit.fit import file_report
from platform_daemon.features.fit.fit_request import FitRequest, FitSettings
from tests.kit.frame_fits import good_frame

SETTINGS = FitSettings(window="n50", fixed={"lambda_per_s": 0.25})
REPORT = file_report("a.h5", FitRequest("jewel", "n50"), [good_frame(0), unfitted(1, "why")], None)


@pytest.fixture
def recording(tmp_path):
    path = tmp_path / "a.h5"
    path.write_bytes(b"content")
    return path


@pytest.fixture
def kept(tmp_path, recording):
    path = tmp_path / "r.jsonl"
    with Ledger(path, SETTINGS, resume=False) as ledger:
        ledger.add(recording, REPORT)
    return path


def finished(kept, recording, settings=SETTINGS):
    with Ledger(kept, settings, resume=True) as ledger:
        return ledger.finished(recording)


def test_a_finished_file_is_known_again(kept, recording):
    assert finished(kept, recording) == REPORT.model_copy(update={"file": str(recording)})


@pytest.mark.parametrize(
    "settings",
    [
        FitSettings(window="d30", fixed={"lambda_per_s": 0.25}),
        FitSettings(window="n50", fixed={"lambda_per_s": 0.26}),
        FitSettings("jewel", "n50", {"lambda_per_s": 0.25}),
        FitSettings(None, "n50", {"lambda_per_s": 0.25}, (ReceiveCalibration(np.eye(3)), "c.h5")),
        FitSettings(None, "n50", {"lambda_per_s": 0.25}, derived=True),
        FitSettings(None, "n50", {"lambda_per_s": 0.25}, frames=(0,)),
    ],
)
def test_other_settings_make_it_unknown(kept, recording, settings):
    assert finished(kept, recording, settings) is None


def test_a_changed_file_is_unknown(kept, recording):
    recording.write_bytes(b"CONTENT")
    os.utime(recording, ns=(1, 1))
    assert finished(kept, recording) is None


def test_a_file_that_failed_is_tried_again(tmp_path, recording):
    with Ledger(tmp_path / "r.jsonl", SETTINGS, resume=False) as ledger:
        ledger.add(recording, InputError("cannot be read", where="a.h5"))
    assert finished(tmp_path / "r.jsonl", recording) is None


@pytest.mark.parametrize("left", [1, 10, 40])
def test_a_line_cut_off_by_a_kill_is_removed_and_the_next_one_is_whole(kept, recording, left):
    whole = kept.read_bytes()
    kept.write_bytes(whole + whole[:left])
    assert finished(kept, recording)
    with Ledger(kept, SETTINGS, resume=True) as ledger:
        ledger.add(recording, REPORT)
    lines = kept.read_text().splitlines()
    assert [LedgerLine.model_validate_json(line).report for line in lines] == [REPORT, REPORT]


@pytest.mark.parametrize("text", ["not json\n", "[1]\n", '{"a": 1}\n', "a line without end", '{"a": 1'])
def test_a_file_that_is_something_else_is_refused_and_left_alone(tmp_path, text):
    other = tmp_path / "notes.jsonl"
    other.write_text(text)
    with pytest.raises(InputError, match="line 1"):
        Ledger(other, SETTINGS, resume=True)
    assert other.read_text() == text


def test_two_runs_never_write_the_same_file(kept):
    with Ledger(kept, SETTINGS, resume=True), pytest.raises(InputError, match="another run"):
        Ledger(kept, SETTINGS, resume=True)


def test_without_resume_it_begins_anew(kept, recording):
    with Ledger(kept, SETTINGS, resume=False):
        pass
    assert kept.read_bytes() == b""


@pytest.mark.parametrize(
    "told", [{"relative_std": 0.01}, {"sensitivity_std": 0.01 * np.eye(3)}, {"p_std": np.full((3, 3, 1), 0.01)}]
)
def test_a_calibration_that_tells_another_uncertainty_makes_it_unknown(tmp_path, recording, told):
    path = tmp_path / "r.jsonl"
    plain, sure = (FitSettings(calibration=(ReceiveCalibration(np.eye(3), **says), "c.h5")) for says in ({}, told))
    with Ledger(path, plain, resume=False) as ledger:
        ledger.add(recording, REPORT)
    assert finished(path, recording, plain) is not None
    assert finished(path, recording, sure) is None
