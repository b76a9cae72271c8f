"""Guards of rows 41 to 44, 47 and 51: killed runs, disks, damaged shards, two processes or plans, machines, limits."""

from __future__ import annotations

from tests.support.guards import Guard

FOLDER = "outputs/folder/run_folder.py"
LOCK = "outputs/folder/lock.py"
RUN = "engine/run.py"
MAIN = "cli/main.py"
MERGE = "engine/merge.py"
SHARDS = "engine/merge.py"
BLOCKS = "verify/stored/photons.py"
JIT = "kernels/jit.py"

DISK_GUARDS = (
    Guard(
        row=41,
        file=FOLDER,
        text="with self._held(temporary) as file:\n                yield file\n                file.flush()\n"
        "                os.fsync(file.fileno())\n            os.replace(temporary, target)\n",
        without='with open(target, "wb") as file:\n                yield file\n',
        test="test_folder_faults.py::test_a_killed_run_is_finished_by_the_same_command[row-41-kill-9]",
    ),
    Guard(
        row=41,
        file=FOLDER,
        text="        self._remove_leftovers(shard)\n",
        without="",
        test="test_folder_faults.py::test_leftovers_are_swept_up[row-41-leftovers-of-a-killed-run]",
    ),
    Guard(
        row=41,
        file=FOLDER,
        text="            with contextlib.suppress(OSError):\n                temporary.unlink(missing_ok=True)\n",
        without="            pass\n",
        test="test_folder_faults.py::test_the_operating_system_refuses_at_the_last_step[row-41-replace-fails]",
    ),
    Guard(
        row=41,
        file=FOLDER,
        text="                os.fsync(file.fileno())\n",
        without="",
        test="test_folder_faults.py::test_the_operating_system_refuses_at_the_last_step[row-41-fsync-fails]",
    ),
    Guard(
        row=41,
        file=FOLDER,
        text='raise os_error("create the folder", path, error) from error',
        without="raise",
        test="test_folder_faults.py::test_a_file_in_the_place_of_the_folder[row-41-file-in-the-place-of-the-folder]",
    ),
    Guard(
        row=41,
        file=FOLDER,
        text="if n_bytes > free:",
        without="if False:",
        test="test_shard_disk_faults.py::test_a_disk_known_to_be_too_small[row-41-merge-disk-known-to-be-too-small]",
    ),
    Guard(
        row=41,
        file="outputs/photons/files.py",
        text='raise os_error("write", self._folder.path / layout.name, error) from error',
        without="raise",
        test="test_folder_faults.py::test_a_full_disk_leaves_nothing_half[row-41-disk-full]",
    ),
    Guard(
        row=41,
        file=MAIN,
        text="sys.stdout.flush()\n            return code\n",
        without="return code\n",
        test="test_folder_faults.py::test_a_full_standard_output_is_exit_6[row-41-full-standard-output-dry-run]",
    ),
    Guard(
        row=41,
        file=RUN,
        text="except BrokenPipeError:",
        without="except BlockingIOError:",
        test="test_folder_faults.py::test_a_reader_that_goes_away_is_exit_6[row-41-reader-goes-away]",
    ),
    Guard(
        row=41,
        file=MAIN,
        text="except KeyboardInterrupt:",
        without="except EOFError:",
        test="test_folder_faults.py::test_a_killed_run_is_finished_by_the_same_command[row-41-interrupt]",
    ),
)
SHARD_GUARDS = (
    Guard(
        row=42,
        file="outputs/photons/leaves.py",
        text="agrees = block.leaf == leaf.tobytes()",
        without="agrees = True",
        test="test_shard_faults.py::test_fault[row-42-flipped]",
    ),
    Guard(
        row=42,
        file=BLOCKS,
        text="agrees = self._expected is None or",
        without="agrees = True or",
        test="test_shard_faults.py::test_a_damage_that_the_manifest_vouches_for"
        "[row-42-photons-that-the-manifest-vouches-for]",
    ),
    Guard(
        row=42,
        file="verify/stored/run.py",
        text='if part.folder.sha256_of(name) != entry["sha256"]:',
        without="if False:",
        test="test_shard_faults.py::test_damaged_counts[row-42-counts-of-a-whole-run]",
    ),
    Guard(
        row=42,
        file=MERGE,
        text="elif n_bytes < size:",
        without="elif False:",
        test="test_shard_faults.py::test_fault[row-42-cut]",
    ),
    Guard(
        row=42,
        file=MERGE,
        text="elif n_bytes > size:",
        without="elif False:",
        test="test_shard_faults.py::test_fault[row-42-extra-byte]",
    ),
    Guard(
        row=42,
        file=BLOCKS,
        text="if other is not None and other != (self._band, block):",
        without="if False:",
        test="test_shard_faults.py::test_fault[row-42-exchanged]",
    ),
    Guard(
        row=42,
        file=SHARDS,
        text="if plan_sha256 != expected:",
        without="if False:",
        test="test_shard_faults.py::test_a_foreign_shard[row-42-of-another-seed]",
    ),
    Guard(
        row=42,
        file="verify/stored/parts.py",
        text="if of_manifest != plan:",
        without="if False:",
        test="test_shard_faults.py::test_a_foreign_shard[row-42-of-another-scene]",
    ),
    Guard(
        row=42,
        file=SHARDS,
        text=", *_missing(shards)]",
        without="]",
        test="test_shard_faults.py::test_a_missing_shard[row-42-missing]",
    ),
    Guard(
        row=42,
        file="engine/job.py",
        text='damaged = [] if manifest is None else _damaged(pool, folder, manifest["files"], progress)',
        without="damaged = []",
        test="test_shard_faults.py::test_fault[row-42-of-another-band]",
    ),
)
TWICE_GUARDS = (
    Guard(
        row=43,
        file=FOLDER,
        text="flock(file, EXCLUSIVE | NON_BLOCKING)",
        without="",
        test="test_folder_faults.py::test_a_file_under_way_is_not_swept_up[row-43-file-under-way-of-another-process]",
    ),
    Guard(
        row=43,
        file=FOLDER,
        text="                flock(file, EXCLUSIVE)\n",
        without="                pass\n",
        test="test_folder_faults.py::test_a_file_under_way_is_not_swept_up[row-43-file-under-way-of-another-process]",
    ),
    Guard(
        row=43,
        file=FOLDER,
        text=".{secrets.token_hex(4)}",
        without="",
        test="test_folder_faults.py::test_one_name_under_way_twice[row-43-one-name-under-way-twice]",
    ),
)
MACHINE_GUARDS = (
    Guard(
        row=44,
        file=JIT,
        text="source_stamp=(self._impl.locator.get_source_stamp(), _kernel_stamp()),",
        without="source_stamp=self._impl.locator.get_source_stamp(),",
        test="test_machine_faults.py::test_editing_a_helper_recompiles_the_caller[row-44-stale-cache]",
    ),
    Guard(
        row=44,
        file=JIT,
        text="except (RuntimeError, AttributeError, TypeError, OSError):",
        without="except (AttributeError, TypeError, OSError):",
        test="test_machine_faults.py::test_no_writable_cache_folder[row-44-no-writable-cache-folder]",
    ),
    Guard(
        row=44,
        file=JIT,
        text="        except Exception:  # pickle raises any error for damaged bytes",
        without="        except FileNotFoundError:",
        test="test_machine_faults.py::test_a_damaged_cache[row-44-zeroed-cache.nbi]",
    ),
    Guard(
        row=44,
        file=JIT,
        text='raise OSError(f"{name} is damaged") from error',
        without="raise",
        test="test_machine_faults.py::test_a_damaged_cache[row-44-cut-cache.nbc]",
    ),
    Guard(
        row=44,
        file=JIT,
        text="if stamp != self._source_stamp or",
        without="if",
        test="test_machine_faults.py::test_killed_between_index_and_code[row-44-older-code-under-the-name]",
    ),
    Guard(
        row=44,
        file=JIT,
        text="if stamp != self._source_stamp or digest != hashlib.sha256(code).digest():",
        without="if stamp != self._source_stamp:",
        test="test_machine_faults.py::test_a_damaged_cache[row-44-one-bit-cache.nbc]",
    ),
    Guard(
        row=44,
        file=JIT,
        text="        with contextlib.suppress(OSError):\n            super().save_overload(sig, data)",
        without="        super().save_overload(sig, data)",
        test="test_machine_faults.py::test_no_room_for_the_cache[row-44-no-room-for-the-cache]",
    ),
    Guard(
        row=44,
        file="source/photon_source.py",
        text="yield self._filled(band, start, arrays)",
        without="yield self._filled(band, 0, arrays)",
        test="test_machine_faults.py::test_batches[row-44-batches-of-7]",
    ),
    Guard(
        row=44,
        file="outputs/blocks/blocks.py",
        text="            if len(waiting) > n_ahead:\n                yield waiting.popleft().result()",
        without="            if len(waiting) > n_ahead:\n                yield waiting.pop().result()",
        test="test_machine_faults.py::test_threads[row-44-threads-1-to-64]",
    ),
)
LOCK_GUARDS = (
    Guard(
        row=47,
        file=FOLDER,
        text="with folder_held(self.path, plan.sha256, claim, exclusive=force and not shard.is_named):",
        without="with contextlib.nullcontext(claim()):",
        test="test_two_runs.py::test_another_plan_is_refused_while_one_holds_the_folder"
        "[row-47-another-seed-while-one-runs-plain]",
    ),
    Guard(
        row=47,
        file=FOLDER,
        text=", exclusive=force and not shard.is_named)",
        without=")",
        test="test_two_runs.py::test_force_takes_no_living_run_apart[row-47-force-while-the-same-run-goes-on]",
    ),
    Guard(
        row=47,
        file=LOCK,
        text="holder is not None and holder.plan_sha256 == plan_sha256:\n                _refuse_others",
        without="holder is None:\n                _refuse_others",
        test="test_two_runs.py::test_shards_of_one_plan_share_a_folder[row-47-shards-of-one-plan-share-the-folder]",
    ),
    Guard(
        row=47,
        file=LOCK,
        text="if taken == EXCLUSIVE and (holder is None or holder == dead_holder):",
        without="if taken == EXCLUSIVE and holder is None:",
        test="test_two_runs.py::test_a_killed_holder_blocks_nobody[row-47-killed-holder]",
    ),
    Guard(
        row=47,
        file=LOCK,
        text="except ImportError:  # Windows has none: there nobody is kept out\n",
        without="except ZeroDivisionError:\n",
        test="test_two_runs.py::test_a_system_without_locks_runs[row-47-no-locks-on-this-system]",
    ),
)
PROCESS_GUARDS = (
    Guard(
        row=51,
        file="float_mode.py",
        text="        if is_default():\n            return function(*args, **named)\n        with default_mode():",
        without="        with contextlib.nullcontext():",
        test="test_process_faults.py::test_a_host_that_rounds_another_way[row-51-host-that-rounds-towards-zero]",
    ),
    Guard(
        row=51,
        file="formats/sky_toml/rules.py",
        text="if not EARLIEST_S <= self.read(value) <= LATEST_S:",
        without="if False:",
        test="test_process_faults.py::test_dates_outside_the_calendar[row-51-date-year-0]",
    ),
    Guard(
        row=51,
        file=MAIN,
        text="except (MemoryError, RecursionError,",
        without="except (RecursionError,",
        test="test_process_faults.py::test_little_memory[row-51-1-MB-to-spare]",
    ),
    Guard(
        row=51,
        file=MAIN,
        text="if isinstance(error, RecursionError) or is_shallow:",
        without="if False:",
        test="test_process_faults.py::test_a_low_recursion_limit[row-51-recursion-limit-80]",
    ),
)
RUN_GUARDS = (*PROCESS_GUARDS, *DISK_GUARDS, *SHARD_GUARDS, *TWICE_GUARDS, *MACHINE_GUARDS, *LOCK_GUARDS)
