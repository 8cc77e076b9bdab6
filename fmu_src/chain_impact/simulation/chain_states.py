"""Saved states of chains as bytes."""

from __future__ import annotations

import struct
import zlib
from typing import NamedTuple

import numpy as np

from chain_impact.files import with_checksum
from chain_impact.recording.impacts import LOG_DTYPE
from chain_impact.recording.stick_slip import CHANGE_DTYPE
from chain_impact.scene.errors import SceneError

# the head of a saved state: magic number, CRC-32 of all bytes from CHECKED_FROM on, digest of the scene,
# whether the chain has made a step, number of contacts that have ended, number of changes of friction modes
STATE = struct.Struct("<8sQ16sqqq")
CHECKED_FROM = 16
MAGIC = b"chainsv2"
DAMAGED = "the state is damaged"


class ChainState(NamedTuple):
    """The whole present state of a chain.

    Attributes:
        has_stepped: whether the chain has made a step.
        impacts: the contacts that have ended, see LOG_DTYPE.
        changes: the changes of friction modes, see CHANGE_DTYPE.
        words: the record of the instance, as numbers of 8 bytes.
    """

    has_stepped: bool
    impacts: np.ndarray
    changes: np.ndarray
    words: np.ndarray

    def as_bytes(self, digest: bytes) -> bytes:
        """Return the state as bytes, for a chain of the scene with this digest."""
        head = STATE.pack(MAGIC, 0, digest, self.has_stepped, len(self.impacts), len(self.changes))
        contents = (self.impacts, self.changes, self.words)
        return with_checksum(MAGIC, head[CHECKED_FROM:] + b"".join(content.tobytes() for content in contents))


def state_from(saved: bytes, digest: bytes, size: int, subject: str) -> ChainState:
    """Return the state that ``ChainState.as_bytes`` has written.

    Args:
        saved: the bytes.
        digest: the digest of the scene.
        size: the size of the record of the scene [byte].
        subject: the first words of the message of an error.

    Raises:
        SceneError: when the bytes belong to no chain of this scene, or their checksum is wrong.
    """
    magic, checksum, own_digest, has_stepped, *counts = STATE.unpack_from(saved.ljust(STATE.size, b"\0"))
    changes_at = STATE.size + counts[0] * LOG_DTYPE.itemsize
    record_at = changes_at + counts[1] * CHANGE_DTYPE.itemsize
    if magic != MAGIC or own_digest != digest or min(counts) < 0 or len(saved) != record_at + size:
        raise SceneError(f"{subject}: the bytes are no state of this scene")
    if checksum != zlib.crc32(saved[CHECKED_FROM:]):
        raise SceneError(f"{subject}: {DAMAGED}")
    return ChainState(
        bool(has_stepped),
        np.frombuffer(saved, LOG_DTYPE, counts[0], STATE.size).copy(),
        np.frombuffer(saved, CHANGE_DTYPE, counts[1], changes_at).copy(),
        np.frombuffer(saved, offset=record_at).copy(),
    )
