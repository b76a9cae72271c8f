"""The content hash of a run: a tree of SHA-256 over blocks of photons, the same for any split of the work."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable

import numpy as np

BLOCK = 65_536
"""Photons of a leaf, of a chunk of work and of a block of statistics; part of what makes runs reproducible."""

HASH_BYTES = 32
"""Length of a leaf, of a node and of a root. [bytes]"""

_LEAF, _NODE = b"\x00", b"\x01"
"""What is hashed before a leaf and before a node, so that neither can pass for the other."""


def leaf_hash(*columns: np.ndarray) -> bytes:
    """Hash one block of n photons: SHA-256 of a zero byte and the rows, all numbers of one photon after the other.

    `columns` are travel directions (n, 3), positions (n, 2) where the run has them, weights (n,) where it has
    them, all of one dtype; hashed little-endian.
    """
    parts = [column if column.ndim == 2 else column[:, np.newaxis] for column in columns]
    rows = parts[0] if len(parts) == 1 else np.hstack(parts)
    digest = hashlib.sha256(_LEAF)
    digest.update(np.ascontiguousarray(rows, rows.dtype.newbyteorder("<")).data.cast("B"))
    return digest.digest()


def tree_root(leaves: Iterable[bytes]) -> bytes:
    """Root of the hash tree over leaves, the tree of RFC 6962 (Certificate Transparency), section 2.1.

    Of n leaves the first 2^k, the largest power of two below n, hang from the left branch and the others
    from the right one; a node is SHA-256 of the byte 1, its left and its right branch. One leaf is
    its own root; the root of no leaves is SHA-256 of nothing. Rows of a uint8 array (n, 32) will do for leaves.
    """
    complete: list[tuple[int, bytes]] = []  # subtrees (leaves, root), each larger than the next
    for leaf in leaves:
        size, node = 1, bytes(leaf)
        while complete and complete[-1][0] == size:
            node = _node(complete.pop()[1], node)
            size *= 2
        complete.append((size, node))
    if not complete:
        return hashlib.sha256().digest()
    root = complete.pop()[1]
    while complete:
        root = _node(complete.pop()[1], root)
    return root


def _node(left: bytes, right: bytes) -> bytes:
    return hashlib.sha256(_NODE + left + right).digest()
