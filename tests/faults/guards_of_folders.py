"""Guards of rows 45 and 48: folders that somebody prepared, and files of others."""

from __future__ import annotations

from tests.support.guards import Guard

FOLDER = "outputs/run_folder.py"
MANIFEST = "outputs/manifest_file.py"
CRAFTED = "test_crafted_folders.py"

CRAFTED_GUARDS = (
    Guard(
        row=45,
        file=MANIFEST,
        text="    if fault:\n",
        without="    if False:\n",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-name-00]",
    ),
    Guard(
        row=45,
        file="outputs/json_schema.py",
        text="if depth > MAX_DEPTH:",
        without="if False:",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-nested-40]",
    ),
    Guard(
        row=45,
        file="outputs/json_schema.py",
        text="if len(found) < len(pairs):",
        without="if False:",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-key-twice]",
    ),
    Guard(
        row=45,
        file="outputs/manifest.py",
        text="if waveband > n_bands]",
        without="if False]",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-band-beyond]",
    ),
    Guard(
        row=45,
        file="engine/finished.py",
        text="    except ForgedManifestError:\n        raise\n",
        without="",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-name-02]",
    ),
    Guard(
        row=45,
        file="outputs/shard_manifest.py",
        text="if shard_of_file(name) != shard or",
        without="if",
        test=f"{CRAFTED}::test_a_crafted_manifest_of_a_shard[row-45-shard-lists-another-shard]",
    ),
    Guard(
        row=45,
        file=FOLDER,
        text='raise refuse(self.path / name, error.reason, code="E961", advice=advice) from None',
        without="continue",
        test=f"{CRAFTED}::test_what_is_no_file_of_a_run[row-45-odd-counts.csv-link-to-a-copy]",
    ),
    Guard(
        row=45,
        file="outputs/year_index.py",
        text="        _check_row(path, line, row)\n",
        without="        pass\n",
        test=f"{CRAFTED}::test_a_crafted_index_of_a_year[row-45-index-photons-a-word]",
    ),
    Guard(
        row=45,
        file="outputs/npy_parts.py",
        text=" and folder.has_one_name(name)",
        without="",
        test=f"{CRAFTED}::test_a_file_that_is_changed_in_its_place_has_one_name[row-45-hard-link-part]",
    ),
    Guard(
        row=45,
        file="outputs/folder_lock.py",
        text=" or status.st_nlink > 1",
        without="",
        test=f"{CRAFTED}::test_a_file_that_is_changed_in_its_place_has_one_name[row-45-hard-link-lock]",
    ),
)
FOLDER_GUARDS = CRAFTED_GUARDS
