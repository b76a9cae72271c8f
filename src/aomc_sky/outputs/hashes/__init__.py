"""The content hash of a run: a tree of SHA-256 over blocks of photons.

blocks        ``blocks-0001.npy``: the leaves of the content hash, one row per block of 65 536 photons of a waveband
content_tree  The content hash of a run: a tree of SHA-256 over blocks of photons, the same for any split of the work
"""
