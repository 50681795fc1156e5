"""The options of a daemon, as its parent passes them to the other processes."""

from __future__ import annotations

from pathlib import Path

from pydantic import BaseModel, ConfigDict


class ServeOptions(BaseModel):
    """The options of `serve`; paths as given, all processes have the parent's working directory.

    platform: a platform file or the name of one that ships; overrides: KEY=VALUE; endpoints: file of addresses;
    data: data folder; resonators: folder of further resonator files; host: address that the web process listens on;
    port, stop_port: that the web process and the stop process listen on, 0: not known;
    allowed_hosts: further names of it; tls_cert, tls_key: PEM files; insecure_network: listen without TLS where others
    can read along; forget_queue: cancel what waited when the daemon ended;
    worker_limits: KIND:NUMBERMB or KIND:NUMBERs; alarm_command, alarm_url: run, or posted to, for each alarm;
    alarm_idle_h: one is raised when nothing has begun for so many hours, None: none is;
    root_path: below which a proxy serves it, as /mmr; "": below none;
    respawned: of a process that is started again, see `respawn.py`; initial_tokens: the file of tokens as it was when
    the daemon started.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    platform: str
    overrides: tuple[str, ...] = ()
    endpoints: Path | None = None
    data: Path = Path("data")
    resonators: Path | None = None
    host: str = "127.0.0.1"
    port: int = 0
    stop_port: int = 0
    allowed_hosts: tuple[str, ...] = ()
    tls_cert: Path | None = None
    tls_key: Path | None = None
    insecure_network: bool = False
    forget_queue: bool = False
    worker_limits: tuple[str, ...] = ()
    alarm_command: str | None = None
    alarm_url: str | None = None
    alarm_idle_h: float | None = None
    root_path: str = ""
    respawned: bool = False
    initial_tokens: Path | None = None
