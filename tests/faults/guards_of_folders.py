"""Guards of rows 45 and 48: folders that somebody prepared, and files of others."""

from __future__ import annotations

from tests.support.guards import Guard

FOLDER = "outputs/folder/run_folder.py"
MANIFEST = "outputs/manifest.py"
CRAFTED = "test_crafted_folders.py"

CRAFTED_GUARDS = (
    Guard(
        row=45,
        file=MANIFEST,
        text="    if fault:\n",
        without="    if False:\n",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-text-as-bytes]",
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
        text="if len(members) < len(pairs):",
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
        file="engine/job.py",
        text="    except ForgedManifestError:\n        raise\n",
        without="",
        test=f"{CRAFTED}::test_a_crafted_manifest[row-45-manifest-name-02]",
    ),
    Guard(
        row=45,
        file="outputs/manifest.py",
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
        file="outputs/year.py",
        text="        _check_row(path, line, row)\n",
        without="        pass\n",
        test=f"{CRAFTED}::test_a_crafted_index_of_a_year[row-45-index-photons-a-word]",
    ),
    Guard(
        row=45,
        file="outputs/photons/npy.py",
        text=" and folder.has_one_name(file.name)",
        without="",
        test=f"{CRAFTED}::test_a_file_that_is_changed_in_its_place_has_one_name[row-45-hard-link-part]",
    ),
    Guard(
        row=45,
        file="outputs/folder/lock.py",
        text=" or status.st_nlink > 1",
        without="",
        test=f"{CRAFTED}::test_a_file_that_is_changed_in_its_place_has_one_name[row-45-hard-link-lock]",
    ),
)
TARGETS = "test_output_targets.py"
TARGET = "outputs/folder/target_file.py"
TARGET_GUARDS = (
    Guard(
        row=48,
        file=TARGET,
        text="    if is_scene:\n",
        without="    if False:\n",
        test=f"{TARGETS}::test_the_folder_of_the_scene_is_no_run_folder[row-48-link-plain]",
    ),
    Guard(
        row=48,
        file=TARGET,
        text='    if not os.fspath(path):\n        raise UsageError(f"{option} is empty, which',
        without='    if False:\n        raise UsageError(f"{option} is empty, which',
        test=f"{TARGETS}::test_an_empty_name_is_refused[row-48-empty-atmosphere]",
    ),
    Guard(
        row=48,
        file=TARGET,
        text="if own or is_input:",
        without="if own:",
        test=f"{TARGETS}::test_inputs_are_never_replaced[row-48-input-amc.inp]",
    ),
    Guard(
        row=48,
        file=TARGET,
        text="if own or is_input:",
        without="if is_input:",
        test=f"{TARGETS}::test_a_file_that_the_command_reads_is_no_target[row-48-the-file-that-is-read]",
    ),
    Guard(
        row=48,
        file=TARGET,
        text="if not force and not is_ours(target, head):",
        without="if False:",
        test=f"{TARGETS}::test_a_skydist_of_others_needs_force_and_is_no_input_then[row-48-skydist-of-others]",
    ),
    Guard(
        row=48,
        file=TARGET,
        text="if not stat.S_ISREG(status.st_mode):",
        without="if False:",
        test=f"{TARGETS}::test_a_device_or_a_pipe_is_no_target[row-48-pipe]",
    ),
    Guard(
        row=48,
        file=FOLDER,
        text="foreign = set(names) - own_files(self.path, names)",
        without="foreign: set[str] = set()",
        test=f"{TARGETS}::test_files_of_others_under_our_names_stay[row-48-foreign-counts.csv]",
    ),
    Guard(
        row=48,
        file=FOLDER,
        text="names = sorted(filter(is_our_file, self.names(*BEGINNINGS)), key=removal_order)",
        without="names = sorted(self.names(*BEGINNINGS), key=removal_order)",
        test=f"{TARGETS}::test_force_removes_what_a_run_made_and_nothing_else[row-48-names-that-only-look-like-ours]",
    ),
)
FOLDER_GUARDS = (*CRAFTED_GUARDS, *TARGET_GUARDS)
