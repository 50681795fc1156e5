"""`platform-daemon adopt | models`: models that a diagnosis has made better."""

from __future__ import annotations

import getpass
import logging
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from platform_daemon.core.command_line.auditing import audit_in
from platform_daemon.core.command_line.csv_table import write_csv
from platform_daemon.core.command_line.options import CsvOption, ForceOption, JsonOption, ModelsOption
from platform_daemon.core.command_line.output import must_not_exist, write_json

from .options import library

if TYPE_CHECKING:
    from .adopted_model import AdoptedModel

models_app = typer.Typer(help="Adopted models: list, show, retire.", invoke_without_command=True)


@models_app.callback()
def list_models(
    context: typer.Context,
    models: ModelsOption = None,
    json_file: JsonOption = None,
    csv_file: CsvOption = None,
    force: ForceOption = False,
) -> None:
    """List all versions of all adopted models."""
    context.obj = models
    if context.invoked_subcommand is None:
        _list(models, json_file, csv_file, force=force)


def _list(models: Path | None, json_file: Path | None, csv_file: Path | None, *, force: bool) -> None:
    """Print one line per version; files that cannot be read are warnings.  Raises InputError."""
    from platform_daemon.core.state.logs import log_from

    from .schema import AdoptedModelListing

    log_from(logging.WARNING)
    must_not_exist(json_file, force, ".json")
    must_not_exist(csv_file, force, ".csv")
    found, broken = library(models).all()
    listing = AdoptedModelListing(items=tuple(m.summary() for m in found))
    write_json(json_file, listing)
    write_csv(csv_file, listing.items)
    for each in broken:
        print(f"warning: {each.error}", file=sys.stderr)
    print("\n".join(_line(m) for m in found) or "no model has been adopted yet")


@models_app.command("show")
def show(context: typer.Context, name: Annotated[str, typer.Argument(help="NAME or NAME@VERSION.")]) -> None:
    """Print a model with its evidence as JSON."""
    from platform_daemon.core.command_line.terminal import print_kept_nowhere
    from platform_daemon.core.schemas.base import to_json

    found = library(context.obj).get(name)
    print_kept_nowhere(to_json(found.report(), indent=1))


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
