"""A lock on a folder, held by one process; the operating system takes it back when that process ends."""

from __future__ import annotations

import os
import platform
import sys
import time
import warnings
from contextlib import suppress
from pathlib import Path

from .callers import level_outside
from .files import NO_LINK

NAME = ".lock"
PATIENCE = 0.5  # s; a reader holds the lock for a moment when it looks whether somebody writes
PAUSE = 0.05  # s
FAR = 1 << 20  # place of the byte that Windows locks, beyond the text: that stays readable

if sys.platform == "win32":
    import msvcrt

    def _hold(descriptor: int, *, shared: bool) -> None:
        os.lseek(descriptor, FAR, os.SEEK_SET)
        msvcrt.locking(descriptor, msvcrt.LK_NBLCK, 1)
else:
    import fcntl

    def _hold(descriptor: int, *, shared: bool) -> None:
        fcntl.flock(descriptor, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)


class FolderLock:
    """The lock of a folder, taken when it is made; raises ValueError where another process holds it."""

    def __init__(self, folder: Path) -> None:
        self._file = folder / NAME
        self._descriptor: int | None = None
        until = time.monotonic() + PATIENCE
        while not self._taken():
            if time.monotonic() > until:
                raise ValueError(
                    f"{folder} is being written by {writer(folder) or 'another process'}; choose another "
                    "folder, or wait until that run has ended."
                )
            time.sleep(PAUSE)

    def _taken(self) -> bool:
        descriptor = os.open(self._file, os.O_RDWR | os.O_CREAT | NO_LINK, 0o666)
        try:
            _hold(descriptor, shared=False)
        except (BlockingIOError, PermissionError):
            os.close(descriptor)
            return False
        except OSError as error:  # some network drives know no locks
            warnings.warn(
                f"{self._file.parent} cannot be locked ({error.strerror}); run one scene at a time in it.",
                stacklevel=level_outside(),
            )
        self._descriptor = descriptor
        if not self._own():  # its last holder has removed the file in between
            self.release()
            return False
        try:
            os.ftruncate(descriptor, 0)
            os.lseek(descriptor, 0, os.SEEK_SET)
            os.write(descriptor, f"process {os.getpid()} on {platform.node()}".encode())
        except OSError:  # such as of a full disk
            self.release()
            raise
        return True

    def _own(self) -> bool:
        """Return whether the file that is locked is the one in the folder."""
        assert self._descriptor is not None
        with suppress(OSError):
            return os.path.samestat(os.fstat(self._descriptor), os.lstat(self._file))
        return False

    def release(self) -> None:
        """Give the lock back and remove its file; a second time, do nothing."""
        if self._descriptor is None:
            return
        if self._own():
            with suppress(OSError):  # Windows keeps a file that is open
                self._file.unlink()
        os.close(self._descriptor)
        self._descriptor = None


def writer(folder: Path) -> str:
    """Return which process is writing to a folder, or nothing."""
    try:
        descriptor = os.open(folder / NAME, os.O_RDONLY | NO_LINK)
    except OSError:
        return ""
    try:
        name = os.read(descriptor, 200).decode(errors="replace")
        _hold(descriptor, shared=True)
    except (BlockingIOError, PermissionError):
        return name or "another process"
    except OSError:
        return ""
    finally:
        os.close(descriptor)
    return ""
