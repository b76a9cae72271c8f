"""Manifests: what a finished run or shard holds.

json_schema  JSON that anybody may have changed: read within limits, and held against a published schema
file         Manifests as they are read, and the hash that one holds of itself
run          manifest.json of a run. Everything about time and machine stands under ``run``
shard        ``manifest.k003-of-100.json`` of one shard of a run
"""
