"""Folders that only this user can change: caches, whose content is run as code, and consents to run a user's code."""

import atexit
import os
import shutil
import stat
import tempfile
from contextlib import suppress
from pathlib import Path

CACHES = ("entries", "reads", "kernels")
"""Folders of the cache: artefacts, what they depend on, and compiled kernels."""


def make_private(folder: Path) -> Path:
    """Create `folder` for this user alone, or check that it is.

    One that others could read is closed to them; one that others could write to is refused while anything is in it,
    since they may have put it there.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    found = folder.stat()
    if found.st_uid != os.getuid() or folder.lstat().st_uid != os.getuid():
        raise PermissionError(f"{folder} belongs to another user")
    if stat.S_IMODE(found.st_mode) & 0o077:
        folder.chmod(0o700)
        if found.st_mode & 0o022 and any(folder.iterdir()):
            folder.chmod(stat.S_IMODE(found.st_mode))
            raise PermissionError(f"{folder} has files that other users could write; remove it")
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} cannot be written to")
    return folder


def _others_can_replace(folder: Path) -> bool:
    """Whether another user may rename what is in `folder`."""
    found = folder.stat()
    open_to_others = found.st_mode & 0o022 and not found.st_mode & stat.S_ISVTX
    return bool(open_to_others) or found.st_uid not in (os.getuid(), 0)


def user_folder(variable: str, default: str) -> Path | None:
    """A folder of the user by the XDG base directory specification; None where there is no home folder."""
    if os.environ.get(variable):
        return Path(os.environ[variable]) / "stagecad"
    try:
        return Path.home() / default / "stagecad"
    except RuntimeError:
        return None


def cache_root() -> Path:
    """Folder of the caches: `STAGECAD_CACHE`, else the user's cache folder, else a temporary one for this run.

    One that other users can change, or that cannot be written to, is not used.
    """
    own = os.environ.get("STAGECAD_CACHE")
    for root in (Path(own) if own else None, user_folder("XDG_CACHE_HOME", ".cache")):
        with suppress(OSError):
            if root is not None:
                root.mkdir(mode=0o700, parents=True, exist_ok=True)
                if not _others_can_replace(root):
                    for name in CACHES:
                        make_private(root / name)
                    return root
    folder = tempfile.mkdtemp(prefix="stagecad-cache-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    # Processes that this one starts use the same.
    os.environ["STAGECAD_CACHE"] = folder
    return Path(folder)
