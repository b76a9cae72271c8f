"""A picture of a run folder reads its manifest, too: crafted ones are refused by ``plot`` as by every command."""

from __future__ import annotations

import json

import pytest

from tests.faults import test_crafted_folders
from tests.faults.test_crafted_folders import ANY_MANIFEST, RUN_MANIFEST, answer, change_of, place_of
from tests.support.crafted_folders import written
from tests.support.fault_rows import row_id

pytest.importorskip("matplotlib")

good_run = test_crafted_folders.good_run

CHANGES = ("name-00", "name-02", "name-03", "bytes-null", "nul-bytes", "key-twice", "band-twice")


@pytest.mark.parametrize("name", [pytest.param(n, id=row_id(45, f"plot-{n}")) for n in CHANGES])
def test_a_crafted_manifest_is_not_drawn(name, good_run, tmp_path, capsys):
    place = place_of(good_run, tmp_path)
    path = place.folder / "manifest.json"
    change = change_of(name, place, {**ANY_MANIFEST, **RUN_MANIFEST})
    path.write_bytes(written(json.loads(path.read_bytes()), change))
    place.settle()
    picture = tmp_path / "made.png"
    assert answer(place, capsys, "plot", place.folder, "--out", picture, "-q") == 3
    assert not picture.exists()
