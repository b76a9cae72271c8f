"""Blocks of a waveband: the unit of work, of the content hash, of statistics and of shards.

content_tree  The content hash of a run: a tree of SHA-256 over blocks of photons
shard         Ranges of blocks: which photons a shard makes, and the part of its files' names that says so
exact_sum     A sum of any number of floats, held exactly in bounded memory
statistics    Sums over the photons of a block, and what a run says of its photons
in_order      Work on threads whose results come in the order of the items, in bounded memory
chunk_pool    The blocks of a waveband, made on threads ahead of the one that is written
"""
