"""Temporary result folders, which last as long as what refers to them, and travel in pickles."""

from __future__ import annotations

import io
import shutil
import tarfile
import tempfile
import weakref
from pathlib import Path
from typing import Any


class TemporaryFolder:
    """A folder that is removed with the last reference to it. A pickle holds its files, which are unpacked into another one."""

    def __init__(self) -> None:
        self.path = Path(tempfile.mkdtemp(prefix="tegula-"))
        self._remove = weakref.finalize(self, shutil.rmtree, self.path, ignore_errors=True)

    def __copy__(self) -> TemporaryFolder:
        return self

    def __deepcopy__(self, memo: object) -> TemporaryFolder:
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        packed = io.BytesIO()
        with tarfile.open(fileobj=packed, mode="w") as archive:
            archive.add(self.path, arcname=".")
        return _unpacked, (packed.getvalue(),)


def _unpacked(packed: bytes) -> TemporaryFolder:
    """Folder with the files of a pickle."""
    folder = TemporaryFolder()
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder.path, filter="data")
    return folder
