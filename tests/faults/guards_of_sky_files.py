"""Guards of rows 1 to 14: indices, values and counts of skydist.inp."""

from __future__ import annotations

from tests.support.guards import Guard

FAST = "formats/skydist.py"
HEAD = "formats/skydist.py"
ROWS = "formats/skydist.py"

INDEX_GUARDS = (
    Guard(
        row=1,
        file=FAST,
        text="and zenith.min() >= 1",
        without="",
        test="test_skydist_faults.py::test_fault[row-01-zenith-index-0-onto-a-free-patch]",
    ),
    Guard(
        row=1,
        file=ROWS,
        text="lowest = (1, 1, 0)",
        without="lowest = (1, 0, 0)",
        test="test_skydist_faults.py::test_fault[row-01-zenith-index-0]",
    ),
    Guard(
        row=2,
        file=FAST,
        text="and zenith.max() <= head.n_zenith",
        without="",
        test="test_skydist_faults.py::test_fault[row-02-zenith-index-above-onto-a-free-patch]",
    ),
    Guard(
        row=2,
        file=ROWS,
        text="highest = (head.n_table, head.n_zenith, head.n_azimuth)",
        without="highest = (head.n_table, 10**9, head.n_azimuth)",
        test="test_skydist_faults.py::test_fault[row-02-zenith-index-above-sky-zenith]",
    ),
    Guard(
        row=3,
        file=FAST,
        text="and azimuth.max() <= head.n_azimuth",
        without="",
        test="test_skydist_faults.py::test_fault[row-03-azimuth-index-100000]",
    ),
    Guard(
        row=3,
        file=FAST,
        text="and azimuth.min() >= 0",
        without="",
        test="test_skydist_faults.py::test_fault[row-03-azimuth-index-negative]",
    ),
    Guard(
        row=3,
        file=ROWS,
        text="highest = (head.n_table, head.n_zenith, head.n_azimuth)",
        without="highest = (head.n_table, head.n_zenith, 10**9)",
        test="test_skydist_faults.py::test_fault[row-03-azimuth-index-100000]",
    ),
    Guard(
        row=4,
        file=FAST,
        text="wave.min() >= 1\n        and ",
        without="",
        test="test_skydist_faults.py::test_fault[row-04-wavelength-index-0-onto-a-free-patch]",
    ),
    Guard(
        row=4,
        file=FAST,
        text="and wave.max() <= head.n_table",
        without="",
        test="test_skydist_faults.py::test_fault[row-04-wavelength-index-above-numskywave]",
    ),
    Guard(
        row=4,
        file=ROWS,
        text="highest = (head.n_table, head.n_zenith, head.n_azimuth)",
        without="highest = (10**9, head.n_zenith, head.n_azimuth)",
        test="test_skydist_faults.py::test_fault[row-04-wavelength-index-above-numskywave]",
    ),
)
VALUE_GUARDS = (
    Guard(
        row=5,
        file=ROWS,
        text="not math.isfinite(number) or number < 0",
        without="math.isinf(number) or number < 0",
        test="test_skydist_faults.py::test_fault[row-05-nan-radiance]",
    ),
    Guard(
        row=6,
        file=ROWS,
        text="not math.isfinite(number) or number < 0",
        without="math.isnan(number) or number < 0",
        test="test_skydist_faults.py::test_fault[row-06-infinite-radiance]",
    ),
    Guard(
        row=6,
        file=FAST,
        text="not np.all(np.isfinite(value)) or value.min() < 0",
        without="value.min() < 0",
        test="test_skydist_faults.py::test_fault[row-06-radiance-beyond-float64]",
    ),
    Guard(
        row=7,
        file=ROWS,
        text="not math.isfinite(number) or number < 0",
        without="not math.isfinite(number)",
        test="test_skydist_faults.py::test_fault[row-07-negative-radiance]",
    ),
    Guard(
        row=7,
        file=FAST,
        text="not np.all(np.isfinite(value)) or value.min() < 0",
        without="not np.all(np.isfinite(value))",
        test="test_skydist_faults.py::test_fault[row-07-negative-radiance]",
    ),
    Guard(
        row=8,
        file="source/read/scene.py",
        text="if not scene.is_lit(int(band)):",
        without="if False:",
        test="test_skydist_faults.py::test_a_dark_band_is_refused_by_the_reader[row-08-all-zero-band-read-in-python]",
    ),
    Guard(
        row=8,
        file="source/scene.py",
        text="if wanting.size:",
        without="if False:",
        test="test_skydist_faults.py::test_a_dark_band_of_a_scene[row-08-all-zero-band-of-a-scene-in-python]",
    ),
    Guard(
        row=8,
        file="sampling/allocation.py",
        text="if not table.max(initial=0) > 0:",
        without="if False:",
        test="test_skydist_faults.py::test_a_dark_band_of_the_program[row-08-compat-warns-and-launches-none]",
    ),
)
COUNT_GUARDS = (
    Guard(
        row=9,
        file=ROWS,
        text="if extra or n_read < head.n_rows:",
        without="if extra:",
        test="test_skydist_faults.py::test_fault[row-09-fewer-rows-than-declared]",
    ),
    Guard(
        row=10,
        file=ROWS,
        text="while n_read == head.n_rows:",
        without="while False:",
        test="test_skydist_faults.py::test_fault[row-10-more-rows-than-declared]",
    ),
    Guard(
        row=10,
        file=ROWS,
        text='name="numskyelem", advice=advice, can_downgrade=True',
        without='name="numskyelem", advice=advice',
        test="test_skydist_faults.py::test_lenient[row-10-lenient-warns]",
    ),
    Guard(
        row=11,
        file=HEAD,
        text="if bins > MAX_BINS:",
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-11-header-1e9-by-1e9]",
    ),
    Guard(
        row=11,
        file=HEAD,
        text="if n_bytes <= max(memory.allowed(limit), memory.FREE_BYTES):",
        without="if n_bytes <= (limit or n_bytes):",
        test="test_costly_files.py::test_absent_bins_are_refused_before_they_take_memory"
        "[row-11-absent-bins-3000 x 3000 x 2]",
    ),
    Guard(
        row=11,
        file=HEAD,
        text="if n_bytes <= max(memory.allowed(limit), memory.FREE_BYTES):",
        without="if n_bytes <= memory.allowed(None):",
        test="test_costly_files.py::test_a_given_limit_is_one_of_files_and_plans_too[row-11-limit-given]",
    ),
    Guard(
        row=11,
        file="source/scene.py",
        text="if n_bytes > max(memory.allowed(limit), memory.FREE_BYTES):",
        without="if False:",
        test="test_costly_files.py::test_a_plan_is_refused_before_it_takes_memory[row-11-plan-of-many-wavebands]",
    ),
    Guard(
        row=12,
        file=HEAD,
        text="if n_rows > max(n_bytes, 64) * 1000:",
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-12-header-1e18-rows]",
    ),
    Guard(
        row=12,
        file=HEAD,
        text="if n_table > n_bytes // 2 + 1:",
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-12-header-1e18-wavelengths]",
    ),
    Guard(
        row=13,
        file=HEAD,
        text="if value < _LOWEST[k]:",
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-13-negative-zenith]",
    ),
    Guard(
        row=14,
        file=ROWS,
        text="if earlier and radiance[where] != value:",
        without="if False:",
        test="test_skydist_faults.py::test_a_patch_twice[row-14-values-differ]",
    ),
    Guard(
        row=14,
        file=FAST,
        text="if not np.array_equal(radiance.ravel()[cell], value):",
        without="if False:",
        test="test_skydist_faults.py::test_a_patch_twice[row-14-values-differ]",
    ),
    Guard(
        row=14,
        file=ROWS,
        text='report.at(row, "E309", message, advice=advice, can_downgrade=True)',
        without='report.at(row, "E309", message, advice=advice)',
        test="test_skydist_faults.py::test_lenient[row-14-lenient-last-one-wins]",
    ),
)
COST_GUARDS = (
    Guard(
        row=50,
        file="formats/text_file.py",
        text="if piece is None or n_bytes > most:",
        without="if piece is None:",
        test="test_costly_files.py::test_a_file_without_an_end_has_a_limit[row-50-no-end]",
        hangs=True,
    ),
    Guard(
        row=50,
        file="formats/text_file.py",
        text="if piece is None or n_bytes > most:",
        without="if piece is not None and n_bytes > most:",
        test="test_costly_files.py::test_a_file_without_an_end_has_a_limit[row-50-nothing-yet]",
    ),
    Guard(
        row=50,
        file=FAST,
        text="if not np.array_equal(radiance.ravel()[cell], value):",
        without="if np.count_nonzero(line) != rows.size:",
        test="test_costly_files.py::test_equal_rows_are_read_as_fast_as_others[row-50-equal-rows]",
    ),
    Guard(
        row=50,
        file=ROWS,
        text="if earlier and radiance[where] != value:",
        without="if earlier:",
        test="test_costly_files.py::test_rows_of_a_file_with_doubts_take_the_short_way_too"
        "[row-50-equal-rows-of-a-broken-file]",
    ),
)
SKY_FILE_GUARDS = (*INDEX_GUARDS, *VALUE_GUARDS, *COUNT_GUARDS, *COST_GUARDS)
