"""Files that are whole or absent: written under a temporary name, synced, then renamed; with checksums.

Nothing is written through a link: a temporary file is new under a name that nobody can foresee, and takes the
place of a link instead of following it.
"""

from __future__ import annotations

import errno
import hashlib
import io
import json
import os
import secrets
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .plain import as_plain

FilePath = str | os.PathLike[str]

CHECKSUM = "sha256"
HEAD = 512  # bytes
GO_ON = "Everything written before is complete; {}, then go on with resume=True (--resume)"
FREE_SPACE = GO_ON.format("free some space")
OPEN = "make this place writable or choose another"
REMEDIES = {
    errno.ENOSPC: FREE_SPACE,
    errno.EDQUOT: FREE_SPACE,
    errno.EFBIG: GO_ON.format("raise the limit on the size of files (ulimit -f)"),
    errno.EACCES: OPEN,
    errno.EPERM: OPEN,
    errno.EROFS: OPEN,
    errno.ENOENT: "its folder is not there; was it moved or removed? Choose one that exists",
    errno.ENOTDIR: "a part of this path is a file; choose another folder",
    errno.EEXIST: "a part of this path is a file; choose another folder",
    errno.EISDIR: "this is a folder; choose another name",
    errno.ELOOP: "this is a link, and nothing is written through links; put a folder or file in its place",
    errno.ENAMETOOLONG: "choose a shorter name",
}
NO_LINK = getattr(os, "O_NOFOLLOW", 0)
# what damage to an archive raises when it is read; a MemoryError by a shape that is not to be believed
DAMAGE = (
    ValueError, EOFError, KeyError, TypeError, RuntimeError, MemoryError, OverflowError, zipfile.BadZipFile,
    zlib.error, SyntaxError,
)  # fmt: skip
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


@contextmanager
def reading(path: Path) -> Iterator[None]:
    """Turn what shows inside the block that `path` is no file into a CorruptFileError."""
    try:
        yield
    except (FileNotFoundError, NotADirectoryError):
        raise CorruptFileError(f"{path} is missing.") from None
    except IsADirectoryError:
        raise CorruptFileError(f"{path} is a folder; it should be a file.") from None


def open_unlinked(path: Path, flags: int) -> int:
    """Return the descriptor of a file that is opened for writing, unless it is a link."""
    return os.open(path, os.O_WRONLY | flags | NO_LINK | getattr(os, "O_BINARY", 0), 0o666)


def write_whole(path: Path, content: bytes, *, make_folder: bool = True, lasting: bool = True) -> None:
    """Write a file so that at any moment either the old or the new content is there.

    make_folder: whether to make the folder that is to hold it.  lasting: whether it is to be on the disk, in
    case that the power fails, before this returns; what is soon written anew need not be.
    Raises OutputError where the disk is full or the folder cannot be written.
    """
    temporary = path.with_name(f".{secrets.token_hex(8)}.part")
    try:
        with writing(path):
            if make_folder:
                path.parent.mkdir(parents=True, exist_ok=True)
            with os.fdopen(open_unlinked(temporary, os.O_CREAT | os.O_EXCL), "wb") as file:
                file.write(content)
                if lasting:
                    file.flush()
                    os.fsync(file.fileno())
            temporary.replace(path)
    except OutputError:
        with suppress(OSError):
            temporary.unlink(missing_ok=True)
        raise


def json_content(value: Mapping[str, Any], *, signed: bool) -> bytes:
    """Return a table as JSON for people to read; numbers that are not finite become null.

    signed: whether its checksum is added.
    """
    plain = as_plain(dict(value))
    if signed:
        plain[CHECKSUM] = _signature(plain)
    return f"{json.dumps(plain, indent=2, ensure_ascii=False, allow_nan=False)}\n".encode()


def _signature(plain: Mapping[str, Any]) -> str:
    return hashlib.sha256(json.dumps(plain, sort_keys=True).encode()).hexdigest()


def read_bytes(path: Path) -> bytes:
    """Return the content of a stored file; raises CorruptFileError where it is missing or a folder."""
    with reading(path):
        return path.read_bytes()


def read_head(path: Path) -> bytes:
    """Return the first bytes of a stored file; raises as `read_bytes`."""
    with reading(path), path.open("rb") as file:
        return file.read(HEAD)


def read_json(path: Path) -> dict[str, Any]:
    """Return the table in a JSON file; raises CorruptFileError where there is none."""
    content = read_bytes(path)
    try:
        table = json.loads(content)
        json.dumps(table)  # what is nested deeply may be read, and then fail wherever it is used
    except (ValueError, RecursionError) as error:
        raise CorruptFileError(f"{path} is not JSON ({error}); it is damaged or not ours.") from error
    if not isinstance(table, dict):
        raise CorruptFileError(f"{path} holds a {type(table).__name__}, no table; it is damaged or not ours.")
    return table


def unsigned(table: dict[str, Any], path: Path) -> dict[str, Any]:
    """Return a table without its checksum; raises CorruptFileError where that does not match."""
    plain = {name: value for name, value in table.items() if name != CHECKSUM}
    if table.get(CHECKSUM) != _signature(plain):
        raise CorruptFileError(f"{path} was changed after it was written: its checksum does not match.")
    return plain


def arrays_content(arrays: Mapping[str, NDArray[Any]]) -> bytes:
    """Return arrays as NPZ with the checksum of their names, shapes and bytes."""
    buffer = io.BytesIO()
    named: dict[str, Any] = {**arrays, CHECKSUM: np.array(digest(arrays))}
    np.savez(buffer, **named)
    return buffer.getvalue()


def read_arrays(path: Path) -> dict[str, NDArray[Any]]:
    """Return the arrays of a file made of `arrays_content`; raises CorruptFileError where it is damaged."""
    content = io.BytesIO(read_bytes(path))  # from here on no error is the disk's
    try:
        stored = np.load(content, allow_pickle=False)
        if not isinstance(stored, np.lib.npyio.NpzFile):
            raise ValueError("it holds a single array")
        with stored:
            arrays = {name: stored[name] for name in stored.files}
    except DAMAGE as error:
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
