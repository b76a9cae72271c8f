"""Guards of rows 15 to 21: lines of skydist.inp as Fortran reads them, and what its bins and wavelengths mean."""

from __future__ import annotations

from tests.support.guards import Guard

HEAD = "formats/skydist.py"
ROWS = "formats/skydist.py"
SCANNER = "formats/scanner.py"
TABLE = "source/read/table.py"

LINE_GUARDS = (
    Guard(
        row=15,
        file=SCANNER,
        text="fits = len(values) == missing or",
        without="fits = True or",
        test="test_skydist_faults.py::test_fault[row-15-short-row]",
    ),
    Guard(
        row=15,
        file=SCANNER,
        text="fits = len(values) == missing or",
        without="fits =",
        test="test_skydist_faults.py::test_what_fortran_reads_is_read[row-15-next-line-holds-the-rest]",
    ),
    Guard(
        row=16,
        file=ROWS,
        text="if number is None:\n        report.at",
        without="if number is None:\n        number = 0.0\n    if False:\n        report.at",
        test="test_skydist_faults.py::test_fault[row-16-text-in-a-row]",
    ),
    Guard(
        row=16,
        file=ROWS,
        text="elif value is None:\n            message = ",
        without="elif value is None:\n            indices.append(lowest[k])\n        elif False:\n            message = ",
        test="test_skydist_faults.py::test_fault[row-16-text-as-an-index]",
    ),
    Guard(
        row=17,
        file=SCANNER,
        text='if token.word == "/":',
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-17-slash-leaves-a-value-unset]",
    ),
    Guard(
        row=17,
        file=SCANNER,
        text="            if after_separator:\n",
        without="            if False:\n",
        test="test_skydist_faults.py::test_fault[row-17-null-between-commas]",
    ),
    Guard(
        row=17,
        file=SCANNER,
        text="if star and repeat.isdigit()",
        without="if False and repeat.isdigit()",
        test="test_skydist_faults.py::test_what_fortran_reads_is_read[row-17-repeat-count]",
    ),
    Guard(
        row=18,
        file=ROWS,
        text='if rest and "." not in token.word:',
        without="if False:",
        test="test_skydist_faults.py::test_fault[row-18-decimal-comma]",
    ),
)
READING_GUARDS = (
    Guard(
        row=19,
        file=TABLE,
        text="if outside.size:",
        without="if False:",
        test="test_sky_reading_faults.py::test_fault[row-19-zenith-95-degrees]",
    ),
    Guard(
        row=19,
        file=TABLE,
        text="if beyond.size:",
        without="if False:",
        test="test_sky_reading_faults.py::test_fault[row-19-zenith-95-degrees-of-the-program]",
    ),
    Guard(
        row=19,
        file=TABLE,
        text="if far.size:",
        without="if False:",
        test="test_sky_reading_faults.py::test_fault[row-19-azimuth-400-degrees]",
    ),
    Guard(
        row=20,
        file=HEAD,
        text="if first != k:",
        without="if False:",
        test="test_sky_reading_faults.py::test_a_wavelength_twice[row-20-wavelength-twice]",
    ),
    Guard(
        row=20,
        file="wavebands.py",
        text="order = np.lexsort((np.arange(table.size), table))",
        without="order = np.arange(table.size)",
        test="test_sky_reading_faults.py::test_wavelengths_in_disorder[row-20-unsorted-takes-the-nearest]",
    ),
    Guard(
        row=20,
        file=TABLE,
        text="if table.wavelength_nm.size > 1 and np.any(np.diff(table.wavelength_nm) < 0):",
        without="if False:",
        test="test_sky_reading_faults.py::test_wavelengths_in_disorder[row-20-unsorted-takes-the-nearest]",
    ),
    Guard(
        row=21,
        file=TABLE,
        text="if not outside.any():",
        without="if True:",
        test="test_sky_reading_faults.py::test_a_band_far_outside[row-21-band-far-outside-strict]",
    ),
)
SKY_READING_GUARDS = (*LINE_GUARDS, *READING_GUARDS)
