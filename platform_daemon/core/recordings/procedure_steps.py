"""The steps of a procedure's recording, and the one that an analysis takes: values of different steps are not mixed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

from drivers.errors import InputError

from .recording import Recording

ALL_STEPS = "all"
"""In the place of a step: every frame, of whatever step."""
_PLAIN_SERIES = re.compile(r", \d+ shots$")  # the title of a series whose shots differ, and which no procedure has made
_MOST_NAMED = 20


@dataclass(frozen=True)
class RecordedStep:
    """One step of a procedure in a recording.

    number: from 1; name: what the step is for (tune, ramp, series, sweep), "": files of earlier versions do not say;
    values: what the step was made with, by key; frames: of the step, from 0, in order; excited: some of them are
    excited shots that no device flagged.
    """

    number: int
    name: str
    values: Mapping[str, float | str]
    frames: tuple[int, ...]
    excited: bool

    def __str__(self) -> str:
        said = [self.name] if self.name else []
        said += [f"{k} = {v if isinstance(v, str) else f'{v:g}'}" for k, v in self.values.items()]
        return f"step {self.number}" + (f" ({', '.join(said)})" if said else "")


def steps_of_procedure(recording: Recording) -> tuple[RecordedStep, ...]:
    """In order; () for a recording that no procedure has made, also if the shots of its series differ."""
    frames: dict[int, list[int]] = {}
    for k, info in enumerate(recording.frame_info):
        if info.step is not None:
            frames.setdefault(info.step.label.number, []).append(k)
    said = recording.provenance
    named = any(info.step is not None and info.step.label.name for info in recording.frame_info)
    if not frames or (not named and said is not None and _PLAIN_SERIES.search(said.title)):
        return ()
    return tuple(_step(recording, number, tuple(frames[number])) for number in sorted(frames))


def _step(recording: Recording, number: int, frames: tuple[int, ...]) -> RecordedStep:
    infos = [recording.frame_info[k] for k in frames]
    first = infos[0].step
    assert first is not None
    excited = any(not info.blank and info.verdict == "good" for info in infos)
    return RecordedStep(number, first.label.name, first.label.values, frames, excited)


def chosen_step(recording: Recording, wanted: str | None) -> tuple[RecordedStep, str] | None:
    """The step of a procedure's recording that is wanted, and a sentence that says which was taken.

    wanted: number or name of a step, of several with that name the last; None: the last one with an excited shot;
    ALL_STEPS: None is returned, as for a recording that no procedure has made.  Raises InputError for a step that does
    not exist, or that the recording cannot have.
    """
    steps = steps_of_procedure(recording)
    if wanted == ALL_STEPS or (wanted is None and not steps):
        return None
    where = str(recording.path)
    if not steps:
        remedy = "leave the step out"
        raise InputError("the recording is not of a procedure and has no steps", where=where, remedy=remedy)
    if wanted is None:
        found = [step for step in steps if step.excited] or list(steps)
    else:
        found = [step for step in steps if wanted in (str(step.number), step.name)]
    if not found:
        names = ", ".join(dict.fromkeys(step.name for step in steps if step.name))
        remedy = f"steps go from {steps[0].number} to {steps[-1].number}" + (f"; names: {names}" if names else "")
        raise InputError(f"no step is {wanted!r}", where=where, remedy=remedy)
    taken = found[-1]
    others = "" if len(steps) == 1 else "; the other steps are left out"
    return taken, f"{recording.path.name}: {taken} of {len(steps)} is taken, frames {_span(taken.frames)}{others}"


def refuse_mixture(recording: Recording, frames: tuple[int, ...]) -> None:
    """Raises InputError for frames of several steps of a procedure."""
    steps = [step for step in steps_of_procedure(recording) if set(step.frames) & set(frames)]
    if len(steps) > 1:
        raise InputError(
            f"the frames belong to {len(steps)} steps of a procedure",
            where=str(recording.path),
            why=f"means would mix {', '.join(map(str, steps[:_MOST_NAMED]))}",
            remedy="choose frames of one step, or name the step",
        )


def _span(frames: tuple[int, ...]) -> str:
    whole = frames[-1] - frames[0] == len(frames) - 1
    return f"{frames[0]} to {frames[-1]}" if whole else ", ".join(map(str, frames))
