"""The content hash: its tree against published roots, and what is hashed of a block."""

from __future__ import annotations

import hashlib
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from aomc_sky.outputs.photons.leaves import leaf_hash, tree_root

ENTRIES = ("", "00", "10", "2021", "3031", "40414243", "5051525354555657", "606162636465666768696a6b6c6d6e6f")
"""Entries of the test tree of the Certificate Transparency code."""

ROOTS = (
    "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855",
    "6e340b9cffb37a989ca544e6bb780a2c78901d3fb33738768511a30617afa01d",
    "fac54203e7cc696cf0dfcb42c92a1d9dbaf70ad9e621f4bd8d98662f00e3c125",
    "aeb6bcfe274b70a14fb067a5e5578264db0fa9b51af5e0ba159158f329e06e77",
    "d37ee418976dd95753c1c73862b9398fa2a2cf9b4ff0fdfe8b30cd95209614b7",
    "4e3bbb1f7b478dcfe71fb631631519a3bca12c9aefca1612bfce4c13a86264d4",
    "76e67dadbcdf1e10e1b74ddc608abd2f98dfb16fbce75277b5232a127f2087ef",
    "ddb89be403809e325750d3d263cd78929c2942b7942a34b77e122c9594a74c8c",
    "5dc9da79a70659a9ad559cb701ded9a2ab9d823aad2f4960cfe370eff4604328",
)
"""Its roots over the first 0 to 8 entries, as that code publishes them."""


def leaf_of(entry: bytes) -> bytes:
    return hashlib.sha256(b"\x00" + entry).digest()


def root_by_definition(leaves: list[bytes]) -> bytes:
    """RFC 6962, section 2.1, word for word."""
    if len(leaves) < 2:
        return leaves[0] if leaves else hashlib.sha256(b"").digest()
    split = 1 << ((len(leaves) - 1).bit_length() - 1)
    branches = root_by_definition(leaves[:split]) + root_by_definition(leaves[split:])
    return hashlib.sha256(b"\x01" + branches).digest()


@pytest.mark.parametrize("n", range(len(ROOTS)))
def test_published_roots(n: int) -> None:
    leaves = [leaf_of(bytes.fromhex(entry)) for entry in ENTRIES[:n]]
    assert tree_root(leaves).hex() == ROOTS[n]


@given(st.lists(st.binary(min_size=32, max_size=32), max_size=70))
def test_root_follows_the_definition(leaves: list[bytes]) -> None:
    assert tree_root(leaves) == root_by_definition(leaves)


@given(st.integers(0, 40), st.lists(st.integers(0, 40)))
def test_any_partition_has_the_same_root(n: int, cuts: list[int]) -> None:
    leaves = np.frombuffer(hashlib.shake_256(b"leaves").digest(32 * n), np.uint8).reshape(n, 32)
    edges = [0, *sorted(min(cut, n) for cut in cuts), n]
    joined = np.concatenate([leaves[a:b] for a, b in itertools.pairwise(edges)])
    assert tree_root(joined) == tree_root(leaves) == root_by_definition([bytes(leaf) for leaf in leaves])


@given(st.integers(2, 40), st.data())
def test_every_leaf_and_its_place_count(n: int, data: st.DataObject) -> None:
    leaves = [leaf_of(bytes([i])) for i in range(n)]
    i = data.draw(st.integers(0, n - 1))
    changed = [*leaves[:i], leaf_of(b"other"), *leaves[i + 1 :]]
    swapped = [*leaves[1:], leaves[0]]
    assert len({tree_root(leaves), tree_root(changed), tree_root(swapped), tree_root(leaves[:-1])}) == 4


def test_a_leaf_holds_rows_in_little_endian() -> None:
    directions = np.array([[1.0, 0.0, -2.0], [0.5, 0.25, -1.0]], np.float32)
    positions, weights = np.array([[3.0, 4.0], [5.0, 6.0]], np.float32), np.array([7.0, 8.0], np.float32)
    rows = np.array([[1.0, 0.0, -2.0, 3.0, 4.0, 7.0], [0.5, 0.25, -1.0, 5.0, 6.0, 8.0]], "<f4").tobytes()
    assert leaf_hash(directions, positions, weights) == leaf_of(rows)
    assert leaf_hash(*directions.T, *positions.T, weights) == leaf_of(rows)
    assert leaf_hash(directions.astype(">f4")) == leaf_hash(directions) == leaf_of(directions.tobytes())


def test_golden_leaf() -> None:
    block = np.array([[0.0, 0.6, -0.8]])
    assert leaf_hash(block.astype(np.float32)).hex() == GOLDEN["float32"]
    assert leaf_hash(block).hex() == GOLDEN["float64"]


GOLDEN = {
    "float32": "83c2495145a218184dfacd3b152779fb5398922899fd2b0ea66ee4272586ff2c",
    "float64": "ffd0b10af7e6de318f960a600d0ca798c2e86d38b8df231e89079a1392a40a1a",
}
"""SHA-256 of the byte 00 and the IEEE words, as sha256sum prints it."""
