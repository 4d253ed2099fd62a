"""Places where writing fails: folders that are read-only, disks that are full."""

from __future__ import annotations

import os
import shlex
import shutil
from contextlib import contextmanager

import pytest
from tests.shared import execute

# Root may write anywhere, so for root a folder is made read-only by a mount, seen by one process
# and its children alone, and gone with them.
IS_ROOT = os.geteuid() == 0


def may_mount():
    command = ["unshare", "--mount", "mount", "-t", "tmpfs", "none", "/mnt"]
    if not (IS_ROOT and shutil.which("unshare") and shutil.which("mount")):
        return False
    return execute(*command, check=False).returncode == 0


def mounted(*commands):
    """Return what to put before a command, so that it sees mounts of its own."""
    if not may_mount():
        pytest.skip("needs root that may mount (unshare --mount)")
    script = " && ".join([*commands, 'exec "$@"'])
    return ("unshare", "--mount", "sh", "-c", script, "sh")


@contextmanager
def read_only(folder):
    """Make a folder and all below it read-only for commands that begin as the context says."""
    place = shlex.quote(str(folder))
    if IS_ROOT:
        yield mounted(f"mount --bind {place} {place}", f"mount -o remount,bind,ro {place}")
        return
    folders = [folder, *(path for path in folder.rglob("*") if path.is_dir())]
    for path in folders:
        path.chmod(0o555)
    try:
        yield ()
    finally:
        for path in folders:
            path.chmod(0o755)
