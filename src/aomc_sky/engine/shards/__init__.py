"""Shards: parts of a run made apart and joined.

copy       The photon files of a whole run from those of its shards: copied block by block, every block checked
merge      Shards of a run, joined into the files that the run makes in one go, every block checked on its way
shard      One shard of a run: part k of K of its photons, made anywhere, with no coordinator
shard_set  The shards of one run, gathered from their folders: of one plan, all there, none twice
"""
