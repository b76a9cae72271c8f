"""Files that another file names: they may not lie outside its folder, whatever links say."""

from __future__ import annotations

import os
import stat
from collections.abc import Sequence
from pathlib import Path

from aomc_sky.formats.bad_value import BadValueError, quoted


def referenced_file(given: str, owner: str | Path, allow_paths: Sequence[str | Path] = ()) -> tuple[str, str]:
    """Find the file that a description names.

    Parameters
    ----------
    given : str
        Path as the file has it, relative to the folder of that file.
    owner : str or Path
        The file that names it.
    allow_paths : sequence of str or Path
        Folders below which a file may lie too.

    Returns
    -------
    shown, real : str
        The path for messages, and the path to open, all links followed.

    Raises
    ------
    BadValueError
        E402: the file lies elsewhere, is missing, no regular file, or the file that names it.
    """
    folder = os.path.dirname(os.fspath(owner))
    shown = os.path.join(folder, given)
    try:
        real = os.path.realpath(shown)
        roots = [os.path.realpath(root) for root in (folder or ".", *allow_paths)]
        if not any(os.path.commonpath((root, real)) == root for root in roots):
            advice = "move the file there, or give --allow-path DIR"
            raise BadValueError("E402", f"{quoted(given)} does not lie below the folder of this file", advice=advice)
        status = os.stat(real)
    except FileNotFoundError:
        raise BadValueError(
            "E402", f"there is no file {quoted(given)}", advice="paths count from the folder of this file"
        ) from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise BadValueError(
            "E402", f"{quoted(given)} cannot be read: {reason}", advice="name a readable file"
        ) from None
    if not stat.S_ISREG(status.st_mode):
        kind = "a folder" if stat.S_ISDIR(status.st_mode) else "not a regular file"
        raise BadValueError("E402", f"{quoted(given)} is {kind}", advice="name a table of wavelength and value")
    if os.path.samefile(real, owner):
        raise BadValueError(
            "E402", f"{quoted(given)} is this file itself", advice="name a table of wavelength and value"
        )
    return shown, real
