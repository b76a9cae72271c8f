"""Shards: parts of a run made apart and joined.

shard      One shard of a run: part k of K of its photons, made anywhere, with no coordinator
shard_set  The shards of one run, gathered from their folders: of one plan, all there, none twice
merge      Shards joined into the files that the run makes in one go, every block checked on its way
"""
