"""Files written in one step, so that no reader meets half of one, and their checksums."""

from __future__ import annotations

import errno
import hashlib
import os
import tempfile
from collections.abc import Iterable, Mapping
from pathlib import Path

# Below a results root: for each result a file as `sha256sum --check` reads it.
CHECKSUMS = "checksums"
_RESTS_ON = "# rests on "


class AlteredError(ValueError):
    """Files that are no longer as they were written: one line each."""


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


def write_checksums(root: Path, files: Iterable[Path | str], rests_on: str = "") -> None:
    """Record the SHA-256 of results; ``sha256sum --check`` in the results root reads them.

    Parameters
    ----------
    root
        Results root. The record of ``data/fig17.csv`` is ``checksums/data/fig17.csv.sha256``.
    files
        Files below it, as they were just written.
    rests_on
        A word for the inputs that they were made from, kept in a comment of the record.
    """
    comment = f"{_RESTS_ON}{rests_on}\n" if rests_on else ""
    for file in files:
        path = Path(file)
        name = path.relative_to(root).as_posix()
        write_file(_record(root, path), f"{sha256(path)}  {name}\n{comment}")


def of_other_inputs(root: Path, rests_on: Mapping[str, str]) -> list[str]:
    """Return the results below a root that were made from other inputs than those stated.

    Parameters
    ----------
    root
        Results root.
    rests_on
        The word for the present inputs of each result, by its name below the root. A result that is
        not there, or that was recorded without its inputs, is passed over.
    """
    return [
        name
        for name, word in rests_on.items()
        if (root / name).is_file() and recorded_inputs(root, name) not in {"", word}
    ]


def recorded_inputs(root: Path, name: str) -> str:
    """Return the word for the inputs of a result below a root; empty if none is recorded."""
    record = _record(root, root / name)
    text = record.read_text(encoding="utf-8") if record.is_file() else ""
    return text.partition(_RESTS_ON)[2].strip()


def remove_checksums(root: Path, files: Iterable[Path | str]) -> None:
    """Remove the records of files that are about to be written anew."""
    for file in files:
        _record(root, Path(file)).unlink(missing_ok=True)


def require_unaltered(root: Path, files: Iterable[Path | str]) -> None:
    """Refuse files that have changed since they were recorded; files without record pass.

    Parameters
    ----------
    root
        Results root.
    files
        Any files, also such as are no results.

    Raises
    ------
    AlteredError
        Naming each file that was cut, damaged or edited.
    """
    results = [path for path in map(Path, files) if path.is_relative_to(root)]
    if altered := [path for path in results if _is_altered(root, path)]:
        raise AlteredError(
            "\n".join(
                f"{path}: not as it was written: cut short, damaged or edited; "
                "delete it and run again"
                for path in altered
            )
        )


def _record(root: Path, path: Path) -> Path:
    return root / CHECKSUMS / f"{path.relative_to(root).as_posix()}.sha256"


def _is_altered(root: Path, path: Path) -> bool:
    try:
        recorded = _record(root, path).read_text(encoding="utf-8")
    except FileNotFoundError:
        return False
    return recorded.partition(" ")[0] != sha256(path)


def sha256(path: Path) -> str:
    """SHA-256 of a file, as ``sha256sum`` prints it."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
