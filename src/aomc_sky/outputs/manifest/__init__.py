"""Manifests: what a finished run or shard holds.

file         Manifests as they are read: regular files within limits, held against a schema before they are used
json_schema  JSON of files that anybody may have changed: read within limits, and held against a published schema
run          manifest.json: what a finished run holds. Everything about time and machine stands under ``run``
shard        ``manifest.k003-of-100.json``: what one finished shard of a run holds, and what joining the shards ...
"""
