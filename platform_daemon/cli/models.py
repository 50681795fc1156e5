"""`platform-daemon adopt | models`: models that a diagnosis has made better."""

from __future__ import annotations

import getpass
import json
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from drivers.errors import ConfigError, InputError
from drivers.validation import validated
from platform_daemon.schemas import AdoptedModelListing, DiagnosisReport, to_json

from .auditing import audit_in
from .options import ForceOption, JsonOption, ModelsOption, library
from .output import must_not_exist, write_json

if TYPE_CHECKING:
    from platform_daemon.analysis import AdoptedModel

models_app = typer.Typer(help="Adopted models: list, show, retire.", invoke_without_command=True)


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
    from platform_daemon.analysis import file_digests, model_from_diagnosis

    shelf = library(models)
    data = file_digests(recording) if recording else None
    found, who = _read(diagnosis), by or getpass.getuser()
    model = model_from_diagnosis(found, name, who, shelf, data, effects=effect or (), free=free or (), force=force)
    made = shelf.add(model)
    audit_in(shelf.folder, "adopt_model", f"{made.label} by {who}")
    print(f"{made.label} in {shelf.folder}: use it with --variant {made.label}")


def _read(path: Path) -> DiagnosisReport:
    """The diagnosis in a file.  Raises InputError."""
    remedy = "name a file of diagnose --json"
    try:
        found = json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except (ValueError, RecursionError) as error:
        raise InputError("is not JSON", where=str(path), why=str(error), remedy=remedy) from None
    try:
        return validated(DiagnosisReport, found if isinstance(found, dict) else {}, "diagnosis")
    except ConfigError as error:
        raise InputError("is no diagnosis", where=str(path), why=error.what, remedy=remedy) from None


def _refuse(constant: str) -> float:
    raise ValueError(f"{constant} is no number of JSON")


@models_app.callback()
def list_models(
    context: typer.Context, models: ModelsOption = None, json_file: JsonOption = None, force: ForceOption = False
) -> None:
    """List all versions of all adopted models."""
    context.obj = models
    if context.invoked_subcommand is not None:
        return
    must_not_exist(json_file, force, ".json")
    found, broken = library(models).all()
    for each in broken:
        print(f"warning: {each.error}", file=sys.stderr)
    print("\n".join(_line(m) for m in found) or "no model has been adopted yet")
    write_json(json_file, AdoptedModelListing(tuple(m.summary() for m in found)))


@models_app.command("show")
def show(context: typer.Context, name: Annotated[str, typer.Argument(help="NAME or NAME@VERSION.")]) -> None:
    """Print a model with its evidence as JSON."""
    found = library(context.obj).get(name)
    print(to_json(found.report(), indent=1))


@models_app.command("retire")
def retire(
    context: typer.Context,
    name: Annotated[str, typer.Argument(help="NAME@VERSION.")],
    reason: Annotated[str, typer.Option(help="Why; is kept.")],
    by: Annotated[str, typer.Option(help="Who; default: the user.")] = "",
) -> None:
    """Take a version out of use; it stays on disk, and results that used it can be repeated by NAME@VERSION."""
    shelf, who = library(context.obj), by or getpass.getuser()
    retired = shelf.retire(name, who, reason)
    audit_in(shelf.folder, "retire_model", f"{name} by {who}: {reason}")
    print(_line(retired))


def _line(model: AdoptedModel) -> str:
    s = model.summary()
    parts = [*s.terms, *(f"{r} undone" for r in s.receiver)]
    retired = f"  retired: {s.retired.reason}" if s.retired else ""
    return f"{s.label:<24} {s.base} + {', '.join(parts)}  adopted {s.adopted_at} by {s.adopted_by}{retired}"
