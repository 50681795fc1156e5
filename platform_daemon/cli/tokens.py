"""`platform-daemon token add | list | revoke`: who may use the REST interface of a data folder, and as what."""

from __future__ import annotations

import re
from datetime import UTC, datetime, timedelta
from pathlib import Path
from typing import Annotated

import typer

from drivers.errors import InputError
from platform_daemon.core.command_line.auditing import audit_done
from platform_daemon.core.command_line.options import ForceOption, JsonOption
from platform_daemon.core.command_line.output import must_not_exist, write_json
from platform_daemon.core.command_line.terminal import print_kept_nowhere
from platform_daemon.core.schemas.roles import Role

token_app = typer.Typer(help="Tokens for the REST interface: add, list, revoke.", no_args_is_help=True)
DataOption = Annotated[Path, typer.Option(help="Data folder of the server.")]
NameArgument = Annotated[str, typer.Argument(help="Name of its holder, as the audit log has it.")]
RoleOption = Annotated[
    Role, typer.Option(help="viewer: look, and stop; operator: measure, fit, calibrate; admin: adopt and retire.")
]
ExpiresOption = Annotated[
    str | None, typer.Option(help="Until when it is valid: 90d, 12h, or a date as 2027-01-31; default: for ever.")
]


@token_app.command("add")
def add(name: NameArgument, role: RoleOption, expires: ExpiresOption = None, data: DataOption = Path("data")) -> None:
    """Create a token and print it, this once: only its SHA-256 is stored."""
    from platform_daemon.core.state.tokens import tokens_in

    until = None if expires is None else _moment(expires)
    token = tokens_in(data).add(name, role, until)
    print_kept_nowhere(token)  # first: the audit log may fail
    period = "for ever" if until is None else f"until {until.isoformat()}"
    audit_done(data, "token_add", f"{name}: {role}, {period}")


@token_app.command("list")
def list_tokens(data: DataOption = Path("data"), json_file: JsonOption = None, force: ForceOption = False) -> None:
    """List the tokens by name, with role and last day."""
    from platform_daemon.core.schemas.access import TokenRecords
    from platform_daemon.core.state.tokens import has_expired, tokens_in

    must_not_exist(json_file, force, ".json")
    found = tokens_in(data).records()
    write_json(json_file, TokenRecords(tokens=found))
    for each in found:
        until = "for ever" if each.expires is None else f"until {each.expires}"
        print(f"{each.name:20} {each.role:9} made {each.created}, {until}{' (expired)' if has_expired(each) else ''}")
    if not found:
        print("no tokens")


@token_app.command("revoke")
def revoke(name: NameArgument, data: DataOption = Path("data")) -> None:
    """Take a token back; a server that runs refuses it from now on."""
    from platform_daemon.core.state.tokens import tokens_in

    revoked = tokens_in(data).revoke(name)
    audit_done(data, "token_revoke", f"{name}: {revoked.role}")
    print(f"{name} is revoked")


def _moment(text: str) -> datetime:
    """Raises InputError."""
    if found := re.fullmatch(r"(\d{1,5})([dh])", text):
        amount = int(found[1])
        return datetime.now(UTC) + (timedelta(days=amount) if found[2] == "d" else timedelta(hours=amount))
    try:
        return datetime.fromisoformat(text).astimezone(UTC)
    except (ValueError, OverflowError):  # the latter at the ends of the calendar
        remedy = "write 90d, 12h, or a date as 2027-01-31"
        raise InputError(f"{text!r} is no moment", where="--expires", remedy=remedy) from None
