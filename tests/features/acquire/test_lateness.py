"""Each shot of a recording says how late it was."""

import numpy as np
import pytest

from platform_daemon.core.recordings.description import describe
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.schemas.jobs import JobState
from tests.kit.acquisitions import acquire


def late_s(path):
    return [info.late_s for info in open_recording(path).frame_info]


def test_what_holds_a_shot_up_is_its_lateness_and_no_other_ones(engine_with, tmp_path, monkeypatch):
    engine = engine_with()
    program, calls = engine.platform.card.program, []

    def slow(timeline):
        calls.append(0)
        if len(calls) == 2:
            engine.platform.clock.sleep(0.7)
        program(timeline)

    monkeypatch.setattr(engine.platform.card, "program", slow)
    job = acquire(engine, tmp_path / "a.h5", shots=3, sequence={"rx_s": 0.3, "pause_s": 0.4})
    assert job.state is JobState.DONE, job.error
    found = np.array(late_s(tmp_path / "a.h5"))
    np.testing.assert_allclose(found - [0, 0.7, 0], 0, atol=0.02)
    shown = describe(open_recording(tmp_path / "a.h5")).shots
    assert [shot.late_s for shot in shown] == pytest.approx(found)


def test_the_shot_after_a_refused_one_is_due_when_that_has_ended(engine_with, tmp_path):
    engine = engine_with("backends.simulated.faults.dropped_samples=[2]")
    acquire(engine, tmp_path / "a.h5", shots=3, sequence={"rx_s": 0.3, "pause_s": 0.4})
    np.testing.assert_allclose(late_s(tmp_path / "a.h5"), 0, atol=0.35)
