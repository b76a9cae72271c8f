"""Manifests as they are read: regular files within limits, held against a schema before they are used."""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from importlib import resources
from pathlib import Path, PurePosixPath
from typing import Any

from aomc_sky.errors import InputFileError, Problem
from aomc_sky.outputs.manifest.json_schema import first_fault, parse_json
from aomc_sky.regular_file import FileKindError, read_regular

MAX_MANIFEST_BYTES = 1 << 26
"""More than 40 000 wavebands take."""

_ADVICE = "remove the file and write the command that made it again, or name another folder"


class ForgedManifestError(InputFileError):
    """A manifest that no damage made so: it agrees with its own hash but is none of ours, or names files elsewhere."""


def rest_sha256(rest: dict[str, Any]) -> str:
    """SHA-256 of a manifest without its ``run``: JSON text with sorted keys, without white space."""
    return hashlib.sha256(json.dumps(rest, sort_keys=True, separators=(",", ":")).encode()).hexdigest()


def hash_matches(manifest: dict[str, Any]) -> bool:
    """Whether a manifest agrees with the hash that it holds of itself."""
    rest = {key: value for key, value in manifest.items() if key != "run"}
    run = manifest.get("run")
    return isinstance(run, dict) and run.get("rest_sha256") == rest_sha256(rest)


def load_manifest(path: str | Path, schema_file: str) -> dict[str, Any]:
    """Read a manifest and hold it against a schema that ships with the package (``manifest.schema.json``).

    InputFileError where it is not a regular file (E961), no JSON or too much of it (E100), or not what the schema
    allows (E962); this one a ForgedManifestError where the manifest agrees with its own hash, or names a file outside
    its folder.
    """
    try:
        manifest = parse_json(read_regular(path, MAX_MANIFEST_BYTES, follow_links=False))
    except FileKindError as error:
        raise manifest_error(path, "E961", error.reason) from None
    except OSError as error:
        raise manifest_error(path, "E100", f"cannot be read: {error.strerror}") from None
    except ValueError as error:
        raise manifest_error(path, "E100", f"not a readable manifest ({error})") from None
    fault = first_fault(manifest, _schema(schema_file)) or _text_fault(manifest)
    if fault:
        raise manifest_error(path, "E962", f"not a manifest of ours: {fault}", manifest)
    return dict(manifest)


def manifest_error(path: str | Path, code: str, message: str, manifest: Any = None) -> InputFileError:
    """The error of a manifest as a whole; one of its own class where no damage can have made it so."""
    is_forged = isinstance(manifest, dict) and (hash_matches(manifest) or _names_files_elsewhere(manifest))
    kind = ForgedManifestError if is_forged else InputFileError
    return kind([Problem(path=str(path), line=0, column=0, code=code, field="", message=message, advice=_ADVICE)])


def _names_files_elsewhere(manifest: dict[str, Any]) -> bool:
    """Whether a name leads out of the folder, and no byte that has changed makes one of ours such a name."""
    files = manifest.get("files")
    paths = [PurePosixPath(name) for name in files] if isinstance(files, dict) else []
    return any(".." in path.parts or (path.is_absolute() and len(path.parts) > 2) for path in paths)


@lru_cache
def _schema(name: str) -> dict[str, Any]:
    return dict(json.loads((resources.files("aomc_sky.outputs") / name).read_text("utf-8")))


def _text_fault(manifest: dict[str, Any]) -> str:
    """Texts that no terminal can show; names of files and places may hold any bytes."""
    parts = {key: value for key, value in manifest.items() if key not in ("inputs", "run")}
    try:
        json.dumps(parts, ensure_ascii=False).encode("utf-8")
    except UnicodeEncodeError:
        return "half a surrogate pair in a text"
    return ""
