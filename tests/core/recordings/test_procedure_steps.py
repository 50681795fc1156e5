"""The steps of a procedure's recording, and which of them an analysis takes."""

from dataclasses import replace

import pytest

from drivers.errors import InputError
from platform_daemon.core.recordings.procedure_steps import chosen_step, refuse_mixture, steps_of_procedure
from platform_daemon.core.recordings.reader import open_recording
from platform_daemon.core.recordings.recording import StepLabel
from platform_daemon.core.recordings.series_writer import SeriesWriter
from tests.kit.recording_files import header, shot

CHARACTERISE = [
    StepLabel(1, {"f_tx_hz": 229.3}, "tune"),
    StepLabel(2, {"f_tx_hz": 213.1}, "tune"),
    StepLabel(3, {"field_ut": 240.0}, "ramp"),
    *[StepLabel(4, {}, "series")] * 3,
]


def written(folder, labels, title="jewel, characterise", refused=()):
    """A recording with a shot per label; those of these numbers, from 0, are refused."""
    path = folder / "c.h5"
    with SeriesWriter.create(path, header(title=title, planned_shots=len(labels))) as writer:
        for k, label in enumerate(labels):
            bad = {"verdict": "refused", "reason": "lost steps"} if k in refused else {}
            writer.add_shot(replace(shot(k + 1), step=label, **bad))
        writer.finish()
    return open_recording(path)


def test_the_last_step_is_taken_and_the_sentence_says_so(tmp_path):
    recording = written(tmp_path, CHARACTERISE)
    taken, said = chosen_step(recording, None)
    assert (taken.number, taken.name, taken.frames) == (4, "series", (3, 4, 5))
    assert said == "c.h5: step 4 (series) of 4 is taken, frames 3 to 5; the other steps are left out"


def test_a_step_is_named_by_number_or_by_name_and_of_several_of_a_name_the_last_is_meant(tmp_path):
    recording = written(tmp_path, CHARACTERISE)
    assert chosen_step(recording, "3")[0].frames == (2,)
    assert chosen_step(recording, "tune")[0].number == 2
    assert chosen_step(recording, "all") is None
    with pytest.raises(InputError, match=r"no step is 'sweep'.*from 1 to 4; names: tune, ramp, series"):
        chosen_step(recording, "sweep")


def test_of_a_procedure_that_was_cut_off_the_last_step_with_an_excited_shot_is_taken(tmp_path):
    recording = written(tmp_path, CHARACTERISE[:3], refused=(2,))
    assert chosen_step(recording, None)[0].number == 2


def test_frames_of_several_steps_are_refused(tmp_path):
    recording = written(tmp_path, CHARACTERISE)
    refuse_mixture(recording, (3, 5))
    with pytest.raises(InputError, match=r"2 steps.*step 3 \(ramp, field_ut = 240\), step 4 \(series\)"):
        refuse_mixture(recording, (2, 3))


def test_files_of_earlier_versions_have_steps_without_names(tmp_path):
    old = [replace(label, name="") for label in CHARACTERISE]
    recording = written(tmp_path, old)
    assert chosen_step(recording, None)[1].startswith("c.h5: step 4 of 4 is taken")
    assert chosen_step(recording, "2")[0].values == {"f_tx_hz": 213.1}


def test_a_series_whose_shots_differ_is_of_no_procedure(tmp_path):
    labels = [StepLabel(k, {"field_t": 1e-4 * k}) for k in (1, 2, 3)]
    recording = written(tmp_path, labels, title="jewel, 3 shots")
    assert steps_of_procedure(recording) == ()
    assert chosen_step(recording, None) is None
    refuse_mixture(recording, (0, 1, 2))
    with pytest.raises(InputError, match="not of a procedure"):
        chosen_step(recording, "1")
