"""`platform-daemon adopt`: the effects of a diagnosis become a model for later fits."""

from __future__ import annotations

import getpass
import json
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import ConfigError, InputError
from drivers.text_files import read_text_file
from platform_daemon.core.command_line.auditing import audit_in
from platform_daemon.core.command_line.options import ModelsOption
from platform_daemon.features.models.options import library

if TYPE_CHECKING:
    from platform_daemon.diagnosis.report_schema import DiagnosisReport


def adopt(
    diagnosis: Annotated[Path, typer.Argument(help="JSON that diagnose --json wrote.")],
    name: Annotated[str, typer.Option(help="Name of the model; a name that exists gets a new version.")],
    by: Annotated[str, typer.Option(help="Who adopts it; default: the user.")] = "",
    effect: Annotated[list[str] | None, typer.Option(help="Adopt this effect only; may be repeated.")] = None,
    free: Annotated[list[str] | None, typer.Option(help="Let fits estimate this torque effect's strength.")] = None,
    recording: Annotated[list[Path] | None, typer.Option(help="Data of the diagnosis; default: what it names.")] = None,
    force: Annotated[str, typer.Option(metavar="REASON", help="Adopt although the data are not explained.")] = "",
    models: ModelsOption = None,
) -> None:
    """Adopt the effects of a diagnosis: a named, versioned model for fits, with the evidence for it."""
    from platform_daemon.core.recordings.evidence import file_digests
    from platform_daemon.features.diagnose.adoption import model_from_diagnosis

    shelf = library(models)
    data = file_digests(recording) if recording else None
    found, who = _read(diagnosis), by or getpass.getuser()
    model = model_from_diagnosis(found, name, who, shelf, data, effects=effect or (), free=free or (), force=force)
    made = shelf.add(model)
    audit_in(shelf.folder, "adopt_model", f"{made.label} by {who}")
    print(f"{made.label} in {shelf.folder}: use it with --variant {made.label}")


def _read(path: Path) -> DiagnosisReport:
    """The diagnosis in a file.  Raises InputError."""
    from drivers.validation import validated
    from platform_daemon.diagnosis.report_schema import DiagnosisReport

    remedy = "name a file of diagnose --json"
    try:
        found = json.loads(read_text_file(path), parse_constant=_refuse)
    except OSError as error:
        what, why = "cannot be read", error.strerror or str(error)
        raise InputError(what, where=str(path), why=why, remedy=remedy) from None
    except (ValueError, RecursionError) as error:
        raise InputError("is not JSON", where=str(path), why=str(error), remedy=remedy) from None
    try:
        return validated(DiagnosisReport, found if isinstance(found, dict) else {}, "diagnosis")
    except ConfigError as error:
        raise InputError("is no diagnosis", where=str(path), why=error.what, remedy=remedy) from None


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is no number of JSON")
