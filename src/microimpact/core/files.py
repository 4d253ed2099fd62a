"""Files written in one step, so that no reader meets half of one."""

from __future__ import annotations

import errno
import hashlib
import os
import tempfile
from pathlib import Path


def write_file(path: Path | str, content: str | bytes) -> None:
    """Write a file: to a temporary one beside it, which then takes its name.

    A killed writer leaves the file as it was, and at most a hidden temporary one.

    Parameters
    ----------
    path
        The file; missing folders are made.
    content
        Bytes, or text, which is written in UTF-8 with its line ends as they are.

    Raises
    ------
    OSError
        Naming the file, as for a full disk or a folder that is read-only.
    """
    target = Path(path)
    data = content.encode() if isinstance(content, str) else content
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        _replace(target, data)
    except OSError as error:
        # As raised it names the temporary file, or, where the disk is full, none at all.
        raise OSError(error.errno, f"cannot be written: {error.strerror}", str(target)) from error


def require_writable(path: Path | str) -> None:
    """Refuse a file that cannot be written, before its content is computed.

    Parameters
    ----------
    path
        The file; it may be there, and folders may be missing.

    Raises
    ------
    OSError
        Naming the file, if it is a folder, or no folder above it can be written.
    """
    target = Path(path).absolute()
    above = next(folder for folder in target.parents if folder.exists())
    if target.is_dir():
        code = errno.EISDIR
    elif not above.is_dir():
        code = errno.ENOTDIR
    else:
        code = 0 if os.access(above, os.W_OK | os.X_OK) else errno.EACCES
    if code:
        raise OSError(code, f"cannot be written: {os.strerror(code)}", str(path))


def _replace(target: Path, data: bytes) -> None:
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            # Some file systems tell only now that the disk is full.
            os.fsync(handle)
        temporary.chmod(0o644)
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise


def sha256(path: Path) -> str:
    """SHA-256 of a file, as ``sha256sum`` prints it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
