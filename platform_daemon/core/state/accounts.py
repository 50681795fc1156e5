"""Files of an account that another one has made: root must not lock a service out of its own folders."""

from __future__ import annotations

import os
from pathlib import Path


def give_to_owner_of_parent(path: Path) -> None:
    """Give what root has made in the folder of another account to that account, which could not use it otherwise.

    Nothing is done as another account than root.  Raises OSError.
    """
    account = path.parent.stat()
    if os.geteuid() == 0 and account.st_uid != 0 and path.lstat().st_uid == 0:
        os.chown(path, account.st_uid, account.st_gid, follow_symlinks=False)
