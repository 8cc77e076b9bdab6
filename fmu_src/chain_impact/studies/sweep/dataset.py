"""The folder of a sweep, to which rows are written as they are computed, in files of some runs each.

The manifest, a JSON file, identifies the sweep and lists the columns and the runs in each file. A file of
runs is written under a temporary name; when it is complete, it is renamed and then listed in the manifest.
Files that the manifest does not list do not belong to the sweep. So a sweep that was interrupted continues
after the last complete file.
"""

from __future__ import annotations

import hashlib
import json
import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from pathlib import Path
from shutil import rmtree
from typing import Any

import numpy as np

from chain_impact.compilation.sources import fingerprint
from chain_impact.extras import require
from chain_impact.progress import log
from chain_impact.scene.reading import SceneError
from chain_impact.scene.scene import Scene, scene_to_dict
from chain_impact.studies.sweep.batches import missing
from chain_impact.studies.sweep.computation import CHUNK, PARQUET, Columns, Span, columns_of, file_name
from chain_impact.studies.sweep.design import Design
from chain_impact.studies.sweep.job import Job
from chain_impact.system import remove_lock, written_whole

# the name of the manifest begins with _, because readers of Parquet ignore files whose names begin with _ or
# .
MANIFEST = "_manifest.json"
LOCK = ".lock"
# regular expressions for the names of complete files, which ``file_name`` gives, and of incomplete files
OWN = re.compile(rf"runs-\d{{15}}{re.escape(PARQUET)}|\.runs-.*")
FORMAT = 2  # version of the folder's format; it increases when the format changes


@dataclass
class Dataset:
    """The folder of a sweep.

    Attributes:
        path: the folder.
        runs: the number of runs of the sweep.
        dtype: type of the rows as computed: they have no varied values and no word for the status.
        files: name of a complete file → runs in the file.
    """

    path: Path
    runs: int
    dtype: np.dtype
    _head: dict[str, Any]
    files: dict[str, Span] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of runs."""
        return self.runs

    def add(self, batch: Span, file: str) -> None:
        """Add a complete file to the folder, with its final name."""
        name = file_name(batch)
        (self.path / file).replace(self.path / name)
        self.files[name] = batch
        self._list()

    def chunks(self, names: Iterable[str]) -> Iterator[Columns]:
        """Yield some columns in the order of the runs, in parts, so that memory stays small.

        Raises:
            SceneError: when a file is damaged.
        """
        parquet, names = require("pyarrow.parquet", "sweep"), list(names)
        for file in sorted(self.files):
            try:
                with parquet.ParquetFile(self.path / file, page_checksum_verification=True) as opened:
                    for batch in opened.iter_batches(CHUNK, columns=names):
                        yield {name: _array(batch.column(name)) for name in names}
            except (OSError, ValueError) as error:
                raise SceneError(
                    f"{self.path / file} is damaged: remove it, and the same sweep makes its runs anew "
                    f"({error})"
                ) from None

    def tidy(self) -> None:
        """Remove files of runs that do not belong to the sweep or are incomplete.

        If there is no complete file, remove the manifest, too.
        """
        if not self.files:
            (self.path / MANIFEST).unlink(missing_ok=True)
        for path in self.path.iterdir():
            if OWN.fullmatch(path.name) and path.name not in self.files:
                path.unlink()

    def is_complete(self) -> bool:
        """Return whether the folder has all runs of the sweep; if so, use its files. Nothing is written.

        Raises:
            SceneError: when the folder belongs to another sweep.
            OSError: when the manifest cannot be read.
        """
        if not (self.path / MANIFEST).is_file():
            return False
        self.files = self._listed()
        return not missing(list(self.files.values()), self.runs) and not any(map(self._fault, self.files))

    def read(self) -> None:
        """Use the files of an earlier call; begin a new folder if there are none.

        Raises:
            SceneError: when the folder belongs to another sweep, or has files but no manifest.
            OSError: when the folder cannot be read or written.
        """
        # an incomplete manifest is left over from a process that was killed
        for left in self.path.glob(f".{MANIFEST}-*"):
            rmtree(left, ignore_errors=True)
        if (self.path / MANIFEST).exists():
            self.files = self._listed()
        elif any(path.name != LOCK for path in self.path.iterdir()):
            raise SceneError(f"{self.path} has files, but no manifest of a sweep: choose another name")
        for name in list(self.files):
            if fault := self._fault(name):
                if (self.path / name).exists():
                    log.warning("%s is damaged, its runs are made anew (%s)", self.path / name, fault)
                del self.files[name]
        self.tidy()
        self._list()

    def _fault(self, name: str) -> str:
        """Return the fault of a file that a quick check finds; "" if the file is complete."""
        try:
            with require("pyarrow.parquet", "sweep").ParquetFile(self.path / name) as file:
                count = file.metadata.num_rows
        except (OSError, ValueError) as error:
            return str(error)
        first, end = self.files[name]
        return "" if count == end - first else f"{count} runs"

    def _list(self) -> None:
        """Write the manifest, with the present list of files."""
        with written_whole(self.path / MANIFEST) as fresh:
            fresh.write_text(json.dumps(self._head | {"files": self.files}), encoding="utf-8")

    def _listed(self) -> dict[str, Span]:
        """Return the files that the manifest lists; refuse a manifest of another sweep."""
        manifest = self.path / MANIFEST
        wrong = "remove the folder, or choose another name"
        try:
            listed = json.loads(manifest.read_text(encoding="utf-8"))
            differs = [name for name in self._head if listed[name] != self._head[name]]
            files = {name: (int(first), int(end)) for name, (first, end) in listed["files"].items()}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise SceneError(f"{manifest} is not the manifest of a sweep: {wrong}") from None
        if differs:
            raise SceneError(f"{self.path} was left by a sweep that differs in its {differs[0]}: {wrong}")
        for name, batch in files.items():
            if name != file_name(batch) or not 0 <= batch[0] < batch[1] <= self.runs:
                raise SceneError(f"{manifest} lists {name}, which is not a file of the sweep: {wrong}")
        return files


@contextmanager
def locked_dataset(path: Path, job: Job, design: Design) -> Iterator[Dataset]:
    """In this context, lock the folder of a sweep against other sweeps; a complete folder is only read.

    Raises:
        SceneError: when the folder belongs to another sweep, or another sweep writes to it now.
        OSError: when the folder cannot be read or written.
    """
    if path.exists() and not path.is_dir():
        raise SceneError(f"{path} must be a folder: remove the file, or choose another name")
    dataset = Dataset(path, design.runs, job.dtype, known_by(job, design))
    if dataset.is_complete():
        yield dataset
        return
    with _locked(path):
        dataset.read()
        try:
            yield dataset
        finally:
            dataset.tidy()


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Lock a folder against other sweeps, and remove the folder at the end if it is empty.

    Raises:
        SceneError: when another sweep writes to the folder.
        OSError: when the folder cannot be made or written.
    """
    from filelock import FileLock, Timeout

    path.mkdir(exist_ok=True)
    lock = FileLock(path / LOCK)
    try:
        lock.acquire(timeout=0)
    except Timeout:
        raise SceneError(
            f"{path} is being written by another sweep: wait until it has ended, or choose another folder"
        ) from None
    # an error about the lock file would not help the user, who does not know of this file
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        yield
    finally:
        remove_lock(lock)
        with suppress(OSError):  # a folder that is not empty cannot be removed, and stays
            path.rmdir()


def _array(column: Any) -> np.ndarray:
    """Return a column of Arrow as a NumPy array; texts become strings."""
    array = np.asarray(column.to_numpy(zero_copy_only=False))
    return array.astype(str) if array.dtype.kind == "O" else array


def known_by(job: Job, design: Design) -> dict[str, Any]:
    """Return the data that identify a sweep: all data on which its rows depend."""
    values = hashlib.sha256(repr((design.samples, design.sampling, design.seed)).encode())
    for variation in design.variations:
        values.update(
            repr((variation.name, len(variation.values), variation.interval, variation.logarithmic)).encode()
        )
        values.update(variation.values.tobytes())
    return {
        "format": FORMAT,
        "kernel": fingerprint(),
        "scene": _scene_digest(job.scene),
        "varied values": values.hexdigest(),
        "outputs": list(job.outputs),
        "runs": design.runs,
        "columns": list(columns_of(design, np.zeros(1, job.dtype), 0)),
    }


def _scene_digest(scene: Scene) -> str:
    digest = hashlib.sha256(json.dumps(scene_to_dict(scene), sort_keys=True).encode())
    if scene.contact.law_file:
        digest.update(Path(scene.contact.law_file).read_bytes())
    return digest.hexdigest()
