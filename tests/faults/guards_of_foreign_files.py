"""Guards of rows 37 to 40: descriptions of an atmosphere, and HDF5."""

from __future__ import annotations

from tests.support.guards import Guard

REFERENCE = "formats/atmo/spectra.py"
EVALUATOR = "atmosphere/language/block.py"
LEXER = "atmosphere/language/lexer.py"
STATEMENTS = "atmosphere/language/statements.py"
DENSITY = "atmosphere/medium.py"
UNITS = "formats/units.py"
SPECTRUM = "formats/spectrum_csv.py"
CHILD = "formats/background/hdf5_child.py"
MEMBERS = "formats/background/hdf5_members.py"

REFERENCE_GUARDS = (
    Guard(
        row=37,
        file=REFERENCE,
        text="if not any(os.path.commonpath((root, real)) == root for root in roots):",
        without="if False:",
        test="test_atmo_faults.py::test_other_files[row-37-beside-the-folder]",
    ),
    Guard(
        row=37,
        file=REFERENCE,
        text="real = os.path.realpath(shown)",
        without="real = os.path.abspath(shown)",
        test="test_atmo_faults.py::test_other_files[row-37-link-to-outside]",
    ),
    Guard(
        row=37,
        file=REFERENCE,
        text="if not stat.S_ISREG(status.st_mode):",
        without="if False:",
        test="test_atmo_faults.py::test_other_files[row-37-folder]",
    ),
    Guard(
        row=37,
        file=REFERENCE,
        text="if os.path.samefile(real, owner):",
        without="if False:",
        test="test_atmo_faults.py::test_other_files[row-37-itself]",
    ),
    Guard(
        row=37,
        file=REFERENCE,
        text="except FileNotFoundError:",
        without="except IsADirectoryError:",
        test="test_atmo_faults.py::test_other_files[row-37-missing]",
    ),
    Guard(
        row=37,
        file=REFERENCE,
        text="except (OSError, ValueError) as error:",
        without="except ValueError as error:",
        test="test_atmo_faults.py::test_other_files[row-37-link-to-itself]",
    ),
)
CODE_GUARDS = (
    Guard(
        row=38,
        file=EVALUATOR,
        text="if self._n_steps > MAX_STEPS:",
        without="if self._n_steps > 2 * MAX_STEPS:",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-12000-terms]",
    ),
    Guard(
        row=38,
        file=LEXER,
        text="if self._nesting >= MAX_NESTING:",
        without="if False:",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-200-brackets]",
    ),
    Guard(
        row=38,
        file=LEXER,
        text="if size > MAX_BLOCK_BYTES:",
        without="if False:",
        test="test_atmo_faults.py::test_brackets_without_end[row-38-200000-brackets]",
    ),
    Guard(
        row=38,
        file=LEXER,
        text='if word[0] == "#":',
        without="if False:",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-include]",
    ),
    Guard(
        row=38,
        file=STATEMENTS,
        text='if reader.at("("):\n        message = "a block has no functions of its own"',
        without='if False:\n        message = "a block has no functions of its own"',
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-recursion]",
    ),
    Guard(
        row=38,
        file=STATEMENTS,
        text='reader.take()\n    if reader.at("["):',
        without="reader.take()\n    if False:",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-array-of-1e9]",
    ),
    Guard(
        row=38,
        file=DENSITY,
        text="return ~((value >= 0.0) & (value < np.inf))",
        without="return ~(value >= 0.0)",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-pow-overflow]",
    ),
    Guard(
        row=38,
        file=DENSITY,
        text="return ~((value >= 0.0) & (value < np.inf))",
        without="return (value < 0.0) | (value == np.inf)",
        test="test_atmo_faults.py::test_code_that_runs_away[row-38-0-by-0-at-the-ground]",
    ),
)
FORM_GUARDS = (
    Guard(
        row=39,
        file=UNITS,
        text=r'_QUANTITY = re.compile(r"(-?[0-9.]+) *',
        without=r'_QUANTITY = re.compile(r"(-?[0-9.]+)(?:e[0-9]+)? *',
        test="test_atmo_faults.py::test_another_form[row-39-exponent-where-none-is-allowed]",
    ),
    Guard(
        row=39,
        file=UNITS,
        text="if unit not in UNITS[dimension]:\n        raise _wrong_unit(text, unit, match.start(2), dimension)",
        without='unit = unit if unit in UNITS[dimension] else "km"',
        test="test_atmo_faults.py::test_another_form[row-39-wrong-dimension]",
    ),
    Guard(
        row=39,
        file=UNITS,
        text="if match is None:\n        raise _not_a_quantity(text, dimension)",
        without='match = match or _QUANTITY.match(text + "m")',
        test="test_atmo_faults.py::test_another_form[row-39-missing-unit]",
    ),
    Guard(
        row=39,
        file="formats/atmo/scan.py",
        text="if not is_closed:",
        without="if False:",
        test="test_atmo_faults.py::test_another_form[row-39-unclosed-brace]",
    ),
    Guard(
        row=39,
        file=SPECTRUM,
        text="if len(cells) != 2:",
        without="if False:",
        test="test_atmo_faults.py::test_another_form[row-39-csv-with-one-column]",
    ),
    Guard(
        row=39,
        file=SPECTRUM,
        text="if rows and not rows[-1][0] < wavelength:",
        without="if False:",
        test="test_atmo_faults.py::test_another_form[row-39-csv-unsorted]",
    ),
    Guard(
        row=39,
        file=UNITS,
        text="if not _NUMBER.match(text):",
        without="if False:",
        test="test_atmo_faults.py::test_another_form[row-39-csv-with-nan]",
    ),
)
HDF5_GUARDS = (
    Guard(
        row=40,
        file=CHILD,
        text="or plan.get_external_count():",
        without=":",
        test="test_hdf5_faults.py::test_fault[row-40-external-storage]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if layout == h5d.VIRTUAL or",
        without="if",
        test="test_hdf5_faults.py::test_fault[row-40-virtual-dataset]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if group.links.get_info(raw).type != h5py.h5l.TYPE_HARD:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-external-link]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if info.addr in self.groups:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-cycle]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if n_bytes > self.budget:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-sparse-1e15]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if len(zlib.decompressobj().decompress(data, n_bytes + 1)) > n_bytes:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-gzip-bomb]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if len(filters) > 3 or rest not in",
        without="if False and rest not in",
        test="test_hdf5_faults.py::test_fault[row-40-another-filter]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if inner.get_class() not in number:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-object-dtype]",
    ),
    Guard(
        row=40,
        file=CHILD,
        text="if (n_values != 1 and not is_list) or kind.get_size() > MAX_TEXT_BYTES:",
        without="if False:",
        test="test_hdf5_faults.py::test_fault[row-40-wrong-dtype]",
    ),
    Guard(
        row=40,
        file=MEMBERS,
        text="if not _has_signature(file, size):",
        without="if False:",
        test="test_hdf5_faults.py::test_damaged[row-40-random-bytes]",
    ),
    Guard(
        row=40,
        file=MEMBERS,
        text="if done.returncode == 0:\n        return done.stdout",
        without="return done.stdout",
        test="test_hdf5_faults.py::test_damaged[row-40-cut]",
    ),
)
FOREIGN_FILE_GUARDS = (*REFERENCE_GUARDS, *CODE_GUARDS, *FORM_GUARDS, *HDF5_GUARDS)
