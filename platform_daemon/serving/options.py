"""What a daemon is asked to be, as its parent hands it to the other processes."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict


class ServeOptions(BaseModel):
    """The options of `serve`; paths as given, all processes have the parent's working directory.

    platform: a platform file or the name of one that ships; overrides: KEY=VALUE; endpoints: file of addresses;
    data: data folder; resonators: folder of further resonator files; host: address that the web process listens on;
    allowed_hosts: further names of it; tls_cert, tls_key: PEM files; insecure_network: listen without TLS where others
    can read along; forget_queue: cancel what waited when the daemon ended;
    worker_limits: KIND:NUMBERMB or KIND:NUMBERs; alarm_command, alarm_url: run, or posted to, for each alarm;
    alarm_idle_h: one is raised when nothing has begun for so many hours, None: none is;
    again: of a process that is started anew, see `anew.py`; tokens_before: the file of tokens as it was at the start.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    platform: str
    overrides: tuple[str, ...] = ()
    endpoints: Path | None = None
    data: Path = Path("data")
    resonators: Path | None = None
    host: str = "127.0.0.1"
    allowed_hosts: tuple[str, ...] = ()
    tls_cert: Path | None = None
    tls_key: Path | None = None
    insecure_network: bool = False
    forget_queue: bool = False
    worker_limits: tuple[str, ...] = ()
    alarm_command: str | None = None
    alarm_url: str | None = None
    alarm_idle_h: float | None = None
    again: bool = False
    tokens_before: Path | None = None
