"""What the writers have in common whose every file holds one waveband."""

from __future__ import annotations

from collections.abc import Sequence


class WavebandFiles:
    """A writer of files that hold one waveband each, from memory that every chunk has for itself."""

    def parts(self, bands: Sequence[int]) -> list[tuple[int, ...]]:
        """Wavebands that share files: every one has its own."""
        return [(band,) for band in bands]

    def recycle(self, chunks: tuple[memoryview, ...]) -> None:
        """Nothing: no memory is used twice."""
