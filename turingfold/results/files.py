"""Files that are whole or absent: written under a temporary name, synced, then renamed; with checksums."""

from __future__ import annotations

import errno
import hashlib
import io
import json
import os
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

CHECKSUM = "sha256"
GO_ON = "Everything written before is complete; {}, then go on with resume=True (--resume)"
ROOM = GO_ON.format("free some space")
OPEN = "make this place writable or choose another"
REMEDIES = {
    errno.ENOSPC: ROOM,
    errno.EDQUOT: ROOM,
    errno.EFBIG: GO_ON.format("raise the limit on the size of files (ulimit -f)"),
    errno.EACCES: OPEN,
    errno.EPERM: OPEN,
    errno.EROFS: OPEN,
    errno.ENOENT: "its folder is not there; was it moved or removed? Choose one that exists",
    errno.ENOTDIR: "a part of this path is a file; choose another folder",
    errno.EEXIST: "a part of this path is a file; choose another folder",
    errno.EISDIR: "this is a folder; choose another name",
    errno.ENAMETOOLONG: "choose a shorter name",
}
OTHERWISE = GO_ON.format("see to the disk")


class OutputError(OSError):
    """A result that could not be written; what was written before is complete."""


class CorruptFileError(ValueError):
    """A stored file that is damaged: unreadable, or its checksum does not match."""


@contextmanager
def writing(path: Path) -> Iterator[None]:
    """Turn a failure to write `path` inside the block into an OutputError that says what to do."""
    try:
        yield
    except OutputError:
        raise
    except OSError as error:
        remedy = REMEDIES.get(error.errno or 0, OTHERWISE)
        message = f"could not write {path}: {error.strerror or error}. {remedy[0].upper()}{remedy[1:]}."
        raise OutputError(error.errno, message) from error


def write_whole(path: Path, content: bytes) -> None:
    """Write a file so that at any moment either the old or the new content is there.

    Raises OutputError where the disk is full or the folder cannot be written.
    """
    temporary = path.with_name(f".{path.name}.part")
    try:
        with writing(path):
            path.parent.mkdir(parents=True, exist_ok=True)
            with temporary.open("wb") as file:
                file.write(content)
                file.flush()
                os.fsync(file.fileno())
            temporary.replace(path)
    except OutputError:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def write_json(path: Path, value: Any) -> None:
    """Write JSON for people to read; numbers that are not finite become null."""
    text = json.dumps(_plain(value), indent=2, ensure_ascii=False, allow_nan=False)
    write_whole(path, f"{text}\n".encode())


def read_json(path: Path) -> Any:
    """Return the content of a JSON file; raises CorruptFileError where it is none."""
    try:
        return json.loads(path.read_text(encoding="utf-8"))
    except ValueError as error:
        raise CorruptFileError(f"{path} is not JSON ({error}); it is damaged or not ours.") from error


def write_arrays(path: Path, arrays: Mapping[str, NDArray[Any]]) -> None:
    """Write arrays as NPZ with the checksum of their names, shapes and bytes."""
    buffer = io.BytesIO()
    named: dict[str, Any] = {**arrays, CHECKSUM: np.array(digest(arrays))}
    np.savez(buffer, **named)
    write_whole(path, buffer.getvalue())


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file made by `write_arrays`; raises CorruptFileError where it is damaged."""
    content = io.BytesIO(path.read_bytes())  # from here on no error is the disk's
    try:
        stored = np.load(content, allow_pickle=False)
        if not isinstance(stored, np.lib.npyio.NpzFile):
            raise ValueError("it holds a single array")
        with stored:
            arrays = {name: stored[name] for name in stored.files}
    except (ValueError, EOFError, KeyError, zipfile.BadZipFile, zlib.error, RuntimeError) as error:
        raise CorruptFileError(f"{path} is damaged ({error}); it cannot be used.") from error
    if str(arrays.pop(CHECKSUM, "")) != digest(arrays):
        raise CorruptFileError(f"{path} is damaged: its checksum does not match; it cannot be used.")
    return arrays


def digest(arrays: Mapping[str, NDArray[Any]]) -> str:
    """Return the SHA-256 of names, types, shapes and bytes of arrays, whatever their order."""
    total = hashlib.sha256()
    for name in sorted(arrays):
        array = np.asarray(arrays[name])
        total.update(f"{name}|{array.dtype.str}|{array.shape}|".encode())
        total.update(array.tobytes())
    return total.hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(item) for item in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not np.isfinite(value) else value
