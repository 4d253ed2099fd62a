"""Files written in one step, so that no reader ever meets half of one."""

from __future__ import annotations

import os
import tempfile
from pathlib import Path


def write_file(path: Path | str, content: str | bytes) -> None:
    """Write a file: to a temporary one beside it, which then takes its name.

    Parameters
    ----------
    path
        The file; missing folders are made.
    content
        Bytes, or text, which is written in UTF-8 with its line ends as they are.
    """
    target = Path(path)
    data = content.encode() if isinstance(content, str) else content
    target.parent.mkdir(parents=True, exist_ok=True)
    handle, name = tempfile.mkstemp(dir=target.parent, prefix=f".{target.name}.")
    temporary = Path(name)
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
        temporary.chmod(0o644)
        temporary.replace(target)
    except BaseException:
        temporary.unlink()
        raise
