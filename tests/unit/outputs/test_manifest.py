"""Damaged manifests are errors that name the file."""

from __future__ import annotations

import pytest

from aomc_sky.errors import AomcSkyError
from aomc_sky.outputs.manifest import read_manifest

WRONG_BAND = (
    '{"schema": "aomc-sky-manifest/1", "plan_sha256": "", "seed": 0, '
    '"options": {"formats": []}, "bands": [{}], "content": null, "files": {}, "notes": []}'
)
NO_CONTENT = WRONG_BAND.replace("{}]", "]").replace('"content": null, ', "")


@pytest.mark.parametrize("text", ["", "[]", "{}", WRONG_BAND, NO_CONTENT, '{"schema": "aomc-sky-manifest/1"}', "\xff"])
def test_damaged_manifests_are_told(tmp_path, text):
    (tmp_path / "manifest.json").write_bytes(text.encode("latin-1"))
    with pytest.raises(AomcSkyError, match="manifest"):
        read_manifest(tmp_path / "manifest.json")
