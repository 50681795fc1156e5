"""Walks the documents: every block of the pages in order, in one shell, on a fresh copy of the checkout.

    python -m tests.system.walk [--full] [--into FOLDER] [PAGE ...]

The shell ends at the first command that fails. `sh` blocks run as printed, except for the ports (free ones) and for the
marks of tests/kit/pages.py; `--full` does what is printed in place of the shorter versions, and installs from nothing.
Blocks with the mark `file` are written; other `toml` blocks must be TOML."""

from __future__ import annotations

import argparse
import os
import re
import shutil
import signal
import socket
import subprocess
import sys
import sysconfig
import tempfile
import time
import tomllib
import venv
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from tests.kit.pages import ROOT, Block, blocks, shows

PAGES = (
    "README.md",
    "docs/tutorial/using-it.md",
    "docs/explanation/design-and-paper.md",
    "docs/howto/page.md",
    "docs/howto/rest-and-network.md",
    "docs/howto/client.md",
    "docs/howto/library.md",
    "docs/howto/nights-and-schedules.md",
    "docs/reference/configuration.md",
    "docs/howto/calibration.md",
    "docs/howto/uncertainty.md",
    "docs/explanation/diagnosis.md",
    "docs/reference/emulator.md",
    "docs/howto/adding-a-driver.md",
    "docs/howto/adding-a-feature.md",
)
PORTS = ("8212", "8786")  # of the daemon and of Dask, as the pages print them
BLOCK_S = 600.0  # no block takes longer; ...
FULL_S = 3600.0  # ... nor `make test`, which --full does not leave out
GOODBYE_S = 15.0  # nor does the end of what the last blocks have stopped
# What the shell does with a block: run it in itself, so that variables stay, and say how it ended.
STEP = "source '{step}.sh' > '{step}.out' 2>&1; echo $? > '{step}.code.new'; mv '{step}.code.new' '{step}.code'\n"
START = """set -eE -o pipefail -m
trap 'echo "$BASH_COMMAND" > "$WALK/failed"' ERR
"""


class StumbleError(Exception):
    """A block that does not do what its page says; the text is page, line, command and output."""


@dataclass
class Shell:
    """One bash process in `folder` with its own session; what the blocks print is kept in `notes`."""

    folder: Path
    notes: Path
    patience_s: float = BLOCK_S
    process: subprocess.Popen[str] = field(init=False)
    steps: int = 0

    def __post_init__(self) -> None:
        self.notes.mkdir()
        (self.notes / ".curlrc").write_text("fail-with-body\n")  # a refused request is a command that failed
        environment = {name: value for name, value in os.environ.items() if not name.startswith(("PYTEST", "COV_"))}
        environment |= {"WALK": str(self.notes), "CURL_HOME": str(self.notes), "COLUMNS": "120", "USER": "reader"}
        environment |= {"PIP_DISABLE_PIP_VERSION_CHECK": "1"}
        self.process = subprocess.Popen(
            ["bash", "--noprofile", "--norc"],
            cwd=self.folder,
            env=environment,
            stdin=subprocess.PIPE,
            stderr=subprocess.DEVNULL,  # where it tells of jobs that ended; what blocks print goes to their files
            text=True,
            start_new_session=True,
        )
        self._type(START)

    def run(self, block: Block, text: str) -> str:
        """Run a block; returns what it printed.  Raises StumbleError if it fails or never ends."""
        self.steps += 1
        step = self.notes / f"{self.steps:03}"
        expected = int(block.mark("ends with") or 0)
        step.with_suffix(".sh").write_text(text)
        self._type(("set +e\n" if expected else "set -e\n") + STEP.format(step=step))
        deadline = time.monotonic() + self.patience_s
        code = step.with_suffix(".code")
        while not code.exists() and self.process.poll() is None and time.monotonic() < deadline:
            time.sleep(0.02)
        output = step.with_suffix(".out").read_text(errors="replace")
        if not code.exists():
            failed = self.notes / "failed"
            why = (
                f"failed: {failed.read_text().strip()}"
                if failed.exists()
                else f"did not end within {self.patience_s:g} s"
            )
            raise StumbleError(f"{block.place}: {why}\n{_end(output)}")
        if int(code.read_text()) != expected:
            raise StumbleError(f"{block.place}: ended with {code.read_text().strip()}, not {expected}\n{_end(output)}")
        return output

    def worked_s(self) -> float:
        """Processor time of all that the shell has waited for."""
        numbers = Path(f"/proc/{self.process.pid}/stat").read_text().rpartition(")")[2].split()
        return (int(numbers[13]) + int(numbers[14])) / os.sysconf("SC_CLK_TCK")

    def leave(self) -> list[str]:
        """End the shell; returns the processes that the blocks left running, and kills them."""
        if self.process.stdin is not None:
            self.process.stdin.close()
        try:
            self.process.wait(5)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
        deadline = time.monotonic() + GOODBYE_S
        while (left := dict(_session(self.process.pid))) and time.monotonic() < deadline:
            time.sleep(0.1)
        for pid in left:
            os.kill(pid, signal.SIGKILL)
        return list(left.values())

    def _type(self, text: str) -> None:
        assert self.process.stdin is not None
        self.process.stdin.write(text)
        self.process.stdin.flush()


def _end(output: str) -> str:
    return "\n".join(output.splitlines()[-40:])


def _session(leader: int) -> Iterable[tuple[int, str]]:
    """Process id and command line of the living processes of a session."""
    for entry in Path("/proc").iterdir():
        try:
            state, *numbers = (entry / "stat").read_text().rpartition(")")[2].split()
            command = (entry / "cmdline").read_text().replace("\0", " ").strip()
        except (OSError, ValueError):
            continue
        if state != "Z" and int(numbers[2]) == leader:
            yield int(entry.name), command


def copy_checkout(target: Path) -> None:
    """All files that git tracks or would, as they are now, and numba's cache of them."""
    listed = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT,
        check=True,
        capture_output=True,
        text=True,
    )
    tracked = [ROOT / name for name in listed.stdout.split("\0") if name]
    kernels = [path for room in ("platform_daemon", "sim_backend") for path in (ROOT / room).rglob("*.nb[ci]")]
    for path in (*tracked, *kernels):
        if path.is_file():
            copy = target / path.relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(path, copy)  # with its time, by which numba knows what it has compiled


def installed(target: Path) -> None:
    """A .venv as `make install` leaves it, in two seconds: its own, on top of the one that runs this."""
    home = target / ".venv"
    venv.create(home, symlinks=True)
    packages = home / "lib" / f"python{sys.version_info[0]}.{sys.version_info[1]}" / "site-packages"
    below = sysconfig.get_path("purelib")
    (packages / "walk.pth").write_text(f"{target}\nimport site; site.addsitedir({below!r})\n")
    for script in Path(sysconfig.get_path("scripts")).iterdir():
        first, _, rest = script.read_bytes().partition(b"\n")
        if script.is_file() and not script.is_symlink() and first.startswith(b"#!") and b"python" in first:
            copy = home / "bin" / script.name
            copy.write_bytes(f"#!{home}/bin/python\n".encode() + rest)
            copy.chmod(0o755)
    (home / ".installed").touch()


def walk(pages: Iterable[str], folder: Path, *, full: bool = False, tell: bool = False, warm: bool = True) -> None:
    """Walk the pages in a fresh copy in `folder`; `warm`: its kernels are compiled before, as `make install` does.

    Raises StumbleError at the first thing that is not as the pages say.
    """
    copy = folder / "platform-daemon"
    copy_checkout(copy)
    if not full:
        installed(copy)
    if warm and not full:
        subprocess.run(["make", "--silent", "kernels"], cwd=copy, check=True, stdout=subprocess.DEVNULL)
    ports = {port: str(_free_port()) for port in PORTS}
    shell = Shell(copy, folder / "notes", FULL_S if full else BLOCK_S)
    try:
        if "README.md" not in pages:
            shell.run(Block("walk", 0, "sh", "", ()), "make install\n. .venv/bin/activate\n")
        for page in pages:
            _walk_page(page, shell, ports, full=full, tell=tell)
    finally:
        left = shell.leave()
    if left:
        raise StumbleError(f"left running at the end: {'; '.join(left)}")


def _walk_page(page: str, shell: Shell, ports: dict[str, str], *, full: bool, tell: bool) -> None:
    output = ""
    for block in blocks(page):
        if block.mark("not walked"):
            continue
        if name := block.mark("file"):
            (shell.folder / name).parent.mkdir(parents=True, exist_ok=True)
            (shell.folder / name).write_text(block.text)
        elif block.language == "toml":
            _is_toml(block)
        elif block.language == "text":
            missing = shows(block.text, output, digits=block.mark("digits") is not None)
            if missing is not None:
                raise StumbleError(f"{block.place}: nothing like {missing!r} was printed, but\n{_end(output)}")
        elif block.language in ("sh", "python"):
            began, worked = time.monotonic(), shell.worked_s()
            output = shell.run(block, _typed(block, ports, full=full))
            if tell:
                took, work = time.monotonic() - began, shell.worked_s() - worked
                print(f"{took:6.1f} s, {work:5.1f} s of a core  {block.place}", flush=True)
            for said in (_with_free_ports(mark, ports) for mark in block.says()):
                if said not in output:
                    raise StumbleError(f"{block.place}: {said!r} was not printed, but\n{_end(output)}")


def _typed(block: Block, ports: dict[str, str], *, full: bool) -> str:
    """What the reader types: the block, shortened if marked so, with ports that are free here."""
    text = block.text
    short = block.mark("walked with")
    if short and not full:
        text = subprocess.run(["sed", "-E", short], input=text, capture_output=True, text=True, check=True).stdout
        if text == block.text:
            raise StumbleError(f"{block.place}: {short!r} changes nothing")
    text = _with_free_ports(text, ports)
    return f"python - <<'END OF BLOCK'\n{text}END OF BLOCK\n" if block.language == "python" else text


def _with_free_ports(text: str, ports: dict[str, str]) -> str:
    for printed, free in ports.items():
        text = re.sub(rf"\b{printed}\b", free, text)
    return text


def _is_toml(block: Block) -> None:
    try:
        tomllib.loads(block.text)
    except tomllib.TOMLDecodeError as error:
        raise StumbleError(f"{block.place}: no TOML: {error}") from None


def _free_port() -> int:
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return int(one.getsockname()[1])


def main() -> int:
    """Walk by hand: a line per block with its time."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("pages", nargs="*", default=list(PAGES), metavar="PAGE")
    parser.add_argument("--full", action="store_true", help="as printed, without the shorter versions")
    parser.add_argument("--into", type=Path, help="work here, and leave what came of it")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="walk-") as scratch:
        folder = asked.into or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            walk(asked.pages, folder.resolve(), full=asked.full, tell=True)
        except StumbleError as error:
            print(error, file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
