"""Blocks of a waveband: the unit of work, of the content hash, of statistics and of shards.

content_tree  The content hash of a run: a tree of SHA-256 over blocks of photons
statistics    Sums over the photons of a block, held exactly, and what a run says of its photons
blocks        Which blocks a shard makes, and their photons, made on threads ahead of the one that is written
"""
