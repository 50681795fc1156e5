"""The command `platform-daemon`: its commands by name, its exit codes, and how errors are shown.

`commands()` names the module of every command and its line in `platform-daemon --help`.  A module is imported when its
command is called, so that help and short commands do not wait for libraries that they do not use.
"""

from __future__ import annotations

import logging
import sys
from dataclasses import dataclass
from functools import wraps
from importlib import import_module
from typing import Annotated, Any

import typer

from drivers.errors import InputError, PlatformError
from platform_daemon.core.command_line.interrupts import INTERRUPTED, no_interrupt_lost
from platform_daemon.core.command_line.terminal import plain_text_only, tolerant_streams
from platform_daemon.core.registry import features


@dataclass(frozen=True, kw_only=True)
class Entry:
    """Where a command is defined, and what the list of commands says of it."""

    module: str
    """Full name of the module."""
    attribute: str
    """The function of the command there, or a `typer.Typer` for a group or a command of its own class."""
    help: str
    """The first paragraph of the command's own help."""


_OWN = {
    "devices": Entry(
        module="platform_daemon.cli.devices",
        attribute="devices",
        help="List the devices with identity, state and error.  Exit code 1 if one is missing.",
    ),
    "reset-amplifier": Entry(
        module="platform_daemon.cli.devices",
        attribute="reset_amplifier",
        help="Clear the amplifier's latched fault after a trip; no power goes out.  Find the cause first.",
    ),
    "outputs-off": Entry(
        module="platform_daemon.cli.safety",
        attribute="outputs_off",
        help="Switch all outputs off and prove it, all devices at once; exit code 0 only if it is proved.",
    ),
    "reset-fault": Entry(
        module="platform_daemon.cli.safety",
        attribute="reset_fault",
        help="Reset the fault latch, so that power may go out again; all outputs are proved off first.",
    ),
    "doctor": Entry(
        module="platform_daemon.cli.doctor",
        attribute="doctor",
        help="Check devices, disk, memory, clock, ports and service.  Exit code 1 if something must be corrected.",
    ),
    "emulate": Entry(
        module="platform_daemon.cli.emulate",
        attribute="emulate",
        help="Emulate I/O cards, serial devices and the USB amplifier until SIGTERM or Ctrl-C.",
    ),
    "serve": Entry(
        module="platform_daemon.cli.serve",
        attribute="serve",
        help="Run the daemon until SIGTERM or Ctrl-C; outputs go off first.",
    ),
    "openapi": Entry(
        module="platform_daemon.cli.openapi",
        attribute="openapi",
        help="Print the OpenAPI schema of the REST interface, for generators of clients; no server has to run.",
    ),
    "retention": Entry(
        module="platform_daemon.cli.retention",
        attribute="retention",
        help="List the recordings that may be removed; --archive or --delete removes them.",
    ),
    "config": Entry(module="platform_daemon.cli.devices", attribute="config_app", help="Configuration files."),
    "bench": Entry(
        module="platform_daemon.cli.bench", attribute="bench_app", help="Benchmarks; compare ratios, not milliseconds."
    ),
    "token": Entry(
        module="platform_daemon.cli.tokens",
        attribute="token_app",
        help="Tokens for the REST interface: add, list, revoke.",
    ),
}


def commands() -> dict[str, Entry]:
    """Every command and group of commands by name: those that belong to no feature, and those of the features."""
    found = dict(_OWN)
    for feature in features():
        for each in feature.commands:
            module = f"{feature.package}{each.module}"
            found[each.name] = Entry(module=module, attribute=each.attribute, help=each.help)
    return dict(sorted(found.items()))


DIAGNOSE_LIVE = "diagnose --live"
"""`diagnose` has other options with --live, so that it is another command: listed nowhere, and found by this name."""
UNLISTED = {
    DIAGNOSE_LIVE: Entry(
        module="platform_daemon.features.diagnose.live_command",
        attribute="diagnose_live",
        help="Diagnose on the platform: measure, diagnose, run the next measurement, until explained or out of budget.",
    )
}


def load(name: str) -> Any:
    """The click command of this name; its module is imported.

    Log events are configured when the command runs, not for its help: structlog takes as long as all of the help.
    """
    entry = (commands() | UNLISTED)[name]
    found = getattr(import_module(entry.module), entry.attribute)
    around = typer.Typer(add_completion=False, pretty_exceptions_enable=False, callback=lambda: None)
    if isinstance(found, typer.Typer):
        around.add_typer(found, name=name)
    else:
        around.command(name)(found)
    command = typer.main.get_group(around).commands[name]
    for each in getattr(command, "commands", {"": command}).values():
        each.callback = _logging(each.callback)
        each.parse_args = _each_option_once(each)
    return command


def _each_option_once(command: Any) -> Any:
    """The parser of a command, which refuses an option that is given twice and has one value: the last one would
    decide, and nothing would say so."""
    parse = command.parse_args

    def parse_once(context: Any, arguments: list[str]) -> Any:
        if not context.resilient_parsing:
            _, _, given = command.make_parser(context).parse_args(args=list(arguments))
            for each in (each for k, each in enumerate(given) if each in given[:k]):
                if isinstance(each, typer.core.TyperOption) and not (each.multiple or each.is_flag or each.count):
                    raise InputError("is given twice, and has one value", where=each.opts[0], remedy="give it once")
        return parse(context, arguments)

    return parse_once


def _logging(callback: Any) -> Any:
    """The callback of a command, run after warnings have a way to the terminal, and compiled kernels a place."""

    @wraps(callback)
    def run(*arguments: Any, **options: Any) -> Any:
        from platform_daemon.core.state.kernel_cache import choose_font_cache, choose_kernel_cache
        from platform_daemon.core.state.logs import log_from

        log_from(logging.WARNING)
        choose_font_cache()
        if (warning := choose_kernel_cache()) is not None:
            print(f"warning: {warning}.", file=sys.stderr)
        return callback(*arguments, **options)

    return run


class LazyGroup(typer.core.TyperGroup):
    """A group that knows its commands by name and help, and imports the one that is called."""

    def __init__(self, **settings: Any) -> None:
        listed = {name: typer.core.TyperCommand(name, help=entry.help) for name, entry in commands().items()}
        super().__init__(**settings | {"commands": listed})

    def resolve_command(self, ctx: Any, args: list[str]) -> Any:
        """The name, the command with its options, and its arguments."""
        name, command, rest = super().resolve_command(ctx, args)
        if name == "diagnose" and "--live" in rest:
            name, rest = DIAGNOSE_LIVE, [argument for argument in rest if argument != "--live"]
        return name, command if name is None else load(name), rest


app = typer.Typer(cls=LazyGroup, add_completion=False, pretty_exceptions_enable=False)


def main() -> None:
    """Entry point; every expected error is one line on stderr."""
    with tolerant_streams(), plain_text_only():
        sys.exit(_run())


def _run() -> int | None:
    """The exit code."""
    try:
        with no_interrupt_lost():
            code: int | None = app(standalone_mode=False)
        if code == INTERRUPTED:  # of a command that was interrupted anywhere, and said nothing
            print("interrupted; outputs are off", file=sys.stderr)
        return code
    except typer.TyperException as error:
        message = " ".join(getattr(error, "format_message", error.__str__)().split()).rstrip(".")
        print(f"error: {message}. Remedy: {_remedy(error)}", file=sys.stderr)
        return 2
    except PlatformError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2 if error.nothing_moved else 1
    except OSError as error:
        print(f"error: {error.filename or ''}: {error.strerror or error}", file=sys.stderr)
        return 1
    except (KeyboardInterrupt, typer.Abort):
        print("interrupted; outputs are off", file=sys.stderr)
        return INTERRUPTED


def _remedy(error: typer.TyperException) -> str:
    """Of wrong arguments.  Where an option is not there that another command has, the epilog says where it belongs."""
    context: Any = getattr(error, "ctx", None)
    option = getattr(error, "option_name", None)
    if option is not None and type(error).__name__ == "BadOptionUsage":  # which comes without its command
        return f"write {option} alone." if "does not take" in str(error) else f"write {option} VALUE."
    if context is None:
        return "see platform-daemon --help."
    epilog: str | None = context.command.epilog
    if epilog and type(error).__name__ == "NoSuchOption":  # typer keeps the class to itself
        return epilog[0].lower() + epilog[1:]
    command = context.command_path.removeprefix(context.find_root().info_name or "")
    return f"see platform-daemon{command} --help."


@app.callback(invoke_without_command=True)
def _root(
    context: typer.Context,
    version: Annotated[bool, typer.Option("--version", help="Print the version and stop.")] = False,
) -> None:
    """Run the 3D Helmholtz-coil platform that reads magneto-mechanical resonators.

    Exit codes: 0 done; 1 a device or the program failed; 2 bad input, or a device is not what the platform file says;
    3 nothing to fit or diagnose; 130 interrupted.
    """
    if version:
        from platform_daemon import __version__

        print(__version__)
        raise typer.Exit
    if context.invoked_subcommand is None:
        print(context.get_help())
        raise typer.Exit(2)
