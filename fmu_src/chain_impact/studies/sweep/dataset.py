"""The folder of a sweep; each batch of runs that has been computed is written to the folder as one file.

The manifest, a JSON file, identifies the sweep and lists the columns and the runs in each file. A file of
runs is written under a temporary name; when it is complete, it is renamed and then listed in the manifest.
Files that the manifest does not list do not belong to the sweep. So a sweep that was interrupted continues
with the runs that no listed file has.
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
from chain_impact.files import remove_lock, written_atomically
from chain_impact.progress import log
from chain_impact.scene.errors import SceneError
from chain_impact.scene.scene import Scene, scene_to_dict
from chain_impact.studies.sweep.batches import missing_spans
from chain_impact.studies.sweep.computation import PARQUET, Span, file_name
from chain_impact.studies.sweep.job import Job
from chain_impact.study_data.sweep.design import Design
from chain_impact.study_data.sweep.runs import CHUNK, Columns, columns_of

# readers of Parquet folders ignore files whose names begin with _ or with a dot
MANIFEST = "_manifest.json"
LOCK = ".lock"
# matches the final names (``file_name``) and the temporary names (``run_batch``) of files of rows; ``tidy``
# removes no other files, except the manifest
OWN_FILES = re.compile(rf"runs-\d{{15}}{re.escape(PARQUET)}|\.runs-.*")
FORMAT = 2  # version of the folder's format; a folder with another version is not continued


@dataclass
class Dataset:
    """The folder of a sweep, with the rows of the finished batches.

    Attributes:
        path: the folder.
        runs: the number of runs of the complete sweep.
        dtype: ``Job.dtype``: the columns without the varied values and the word for the status.
        _head: the data that identify the sweep (``sweep_identity``).
        files: name of a file that the manifest lists → span of the runs in the file.
    """

    path: Path
    runs: int
    dtype: np.dtype
    _head: dict[str, Any]
    files: dict[str, Span] = field(default_factory=dict)

    def __len__(self) -> int:
        """Return the number of runs of the complete sweep."""
        return self.runs

    def add(self, batch: Span, file: str) -> None:
        """Give the file with the temporary name ``file`` its final name, and list it in the manifest.

        The file must have all rows of ``batch``.
        """
        name = file_name(batch)
        (self.path / file).replace(self.path / name)
        self.files[name] = batch
        self._list()

    def chunks(self, names: Iterable[str]) -> Iterator[Columns]:
        """Yield the columns ``names`` of CHUNK runs or fewer at a time, in the order of runs: name → values.

        Runs that no file has are left out.

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
        """Remove the files of rows that ``files`` does not list, such as incomplete ones.

        If ``files`` is empty, the manifest is removed, too.
        """
        if not self.files:
            (self.path / MANIFEST).unlink(missing_ok=True)
        for path in self.path.iterdir():
            if OWN_FILES.fullmatch(path.name) and path.name not in self.files:
                path.unlink()

    def is_complete(self) -> bool:
        """Return whether the folder, which is only read, has all runs of the sweep in files without a fault.

        If the folder has a manifest, ``files`` gets the files that the manifest lists.

        Raises:
            SceneError: when the folder belongs to another sweep.
            OSError: when the manifest cannot be read.
        """
        if not (self.path / MANIFEST).is_file():
            return False
        self.files = self._listed_chunks()
        return not missing_spans(list(self.files.values()), self.runs) and not any(
            map(self._fault, self.files)
        )

    def read_manifest(self) -> None:
        """Put the complete files of an earlier call into ``files``, and write the manifest.

        Other files of rows are removed. The runs in a damaged file are then computed again.

        Raises:
            SceneError: when the folder belongs to another sweep, or has files but no manifest.
            OSError: when the folder cannot be read or written.
        """
        # left: a temporary folder in which a killed process has left an incomplete manifest
        for left_file in self.path.glob(f".{MANIFEST}-*"):
            rmtree(left_file, ignore_errors=True)
        if (self.path / MANIFEST).exists():
            self.files = self._listed_chunks()
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
        """Return words for the fault of a file; "" if its metadata can be read and count the listed runs."""
        try:
            with require("pyarrow.parquet", "sweep").ParquetFile(self.path / name) as file:
                count = file.metadata.num_rows
        except (OSError, ValueError) as error:
            return str(error)
        first, end = self.files[name]
        return "" if count == end - first else f"{count} runs"

    def _list(self) -> None:
        """Write the manifest, which lists ``files``."""
        with written_atomically(self.path / MANIFEST) as new_file:
            new_file.write_text(json.dumps(self._head | {"files": self.files}), encoding="utf-8")

    def _listed_chunks(self) -> dict[str, Span]:
        """Return the files that the manifest on the disk lists: name → span of runs.

        Raises:
            SceneError: when the file is not the manifest of this sweep.
            OSError: when the manifest cannot be read.
        """
        manifest = self.path / MANIFEST
        advice = "remove the folder, or choose another name"
        try:
            manifest_data = json.loads(manifest.read_text(encoding="utf-8"))
            different_names = [name for name in self._head if manifest_data[name] != self._head[name]]
            files = {name: (int(first), int(end)) for name, (first, end) in manifest_data["files"].items()}
        except (ValueError, KeyError, TypeError, AttributeError):
            raise SceneError(f"{manifest} is not the manifest of a sweep: {advice}") from None
        if different_names:
            raise SceneError(
                f"{self.path} was left by a sweep that differs in its {different_names[0]}: {advice}"
            )
        for name, batch in files.items():
            if name != file_name(batch) or not 0 <= batch[0] < batch[1] <= self.runs:
                raise SceneError(f"{manifest} lists {name}, which is not a file of the sweep: {advice}")
        return files


@contextmanager
def locked_dataset(path: Path, job: Job, design: Design) -> Iterator[Dataset]:
    """Give a ``with`` block the folder of a sweep.

    A folder with all runs is only read. Any other folder is locked against other sweeps during the block, and
    incomplete files are removed at the end of the block.

    Raises:
        SceneError: when the folder belongs to another sweep, or another sweep is writing to it.
        OSError: when the folder cannot be read or written.
    """
    if path.exists() and not path.is_dir():
        raise SceneError(f"{path} must be a folder: remove the file, or choose another name")
    dataset = Dataset(path, design.runs, job.dtype, sweep_identity(job, design))
    if dataset.is_complete():
        yield dataset
        return
    with _lock_folder(path):
        dataset.read_manifest()
        try:
            yield dataset
        finally:
            dataset.tidy()


@contextmanager
def _lock_folder(path: Path) -> Iterator[None]:
    """Make a folder if it does not exist, and lock it against other sweeps during a ``with`` block.

    If the folder is empty at the end of the block, the folder is removed.

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
    # the error names the folder, because users do not know the lock file
    except OSError as error:
        raise type(error)(error.errno, error.strerror, str(path)) from None
    try:
        yield
    finally:
        remove_lock(lock)
        with suppress(OSError):  # rmdir fails if the folder is not empty; the folder then stays
            path.rmdir()


def _array(column: Any) -> np.ndarray:
    """Return a column of Arrow as a NumPy array; a column of texts has NumPy's type for strings."""
    array = np.asarray(column.to_numpy(zero_copy_only=False))
    return array.astype(str) if array.dtype.kind == "O" else array


def sweep_identity(job: Job, design: Design) -> dict[str, Any]:
    """Return the data on which the rows of a sweep depend, to identify the sweep: name → value or hash."""
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
