"""Guards of rows 22 to 33: numbers of photons, amc.inp, the files beside it, and what is no file."""

from __future__ import annotations

from tests.support.guards import Guard

ALLOCATION = "sampling/allocation.py"
MASS = "sampling/mass.py"
AMC = "formats/amc.py"
TEXT = "formats/text_file.py"
BANDS = "formats/amc.py"

NUMBER_GUARDS = (
    Guard(
        row=22,
        file=MASS,
        text="scaled = np.ldexp(values, -int(np.frexp(values.max())[1]))",
        without="scaled = values.copy()",
        test="test_number_faults.py::test_radiances_at_the_ends[row-22-sum-beyond-float64-systematic]",
    ),
    Guard(
        row=23,
        file="skies/tabulated.py",
        text="scaled = np.ldexp(values, -int(np.frexp(peak)[1])) if peak > 0 else values",
        without="scaled = values",
        test="test_number_faults.py::test_subnormal_radiances[row-23-subnormals-times-solid-angles]",
    ),
    Guard(
        row=24,
        file=ALLOCATION,
        text="np.subtract(quotient[1:], quotient[:-1], out=counts.view(np.uint64))",
        without="counts[:] = np.rint(np.diff(cumulative) * (n / 2**62))",
        test="test_number_faults.py::test_fewer_photons_than_patches[row-24-7-photons-32400-patches]",
    ),
    Guard(
        row=24,
        file=ALLOCATION,
        text="[: missing - int(above.sum())]",
        without="",
        test="test_number_faults.py::test_ties_go_to_the_first_patches[row-24-10-of-24-ties-to-the-first]",
    ),
    Guard(
        row=25,
        file="sampling/fixed_point.py",
        text="rest = first + second * 2.0**FIXED_POINT_BITS + 0.5",
        without="rest = first + 0.5",
        test="test_number_faults.py::test_many_photons_in_thirds[row-25-thirds-of-2-to-the-62]",
    ),
    Guard(
        row=25,
        file="source/read/scene.py",
        text='as_number_of(iterations, "iterations", 1, MAX_PHOTONS, error=SceneError)',
        without='as_number_of(iterations, "iterations", 1, 2**80, error=SceneError)',
        test="test_number_faults.py::test_fault[row-25-refused-2-to-the-62-plus-1]",
    ),
    Guard(
        row=26,
        file=AMC,
        text="if not field.is_allowed(value) or",
        without="if",
        test="test_number_faults.py::test_fault[row-26-no-photons]",
    ),
)
AMC_GUARDS = (
    Guard(
        row=27,
        file=AMC,
        text="if meant is None or meant != value:",
        without="if False:",
        test="test_amc_faults.py::test_fault[row-27-flag-one-column-right]",
    ),
    Guard(
        row=28,
        file=AMC,
        text="if meant is None or meant != value:",
        without="if False:",
        test="test_amc_faults.py::test_fault[row-28-real-without-point]",
    ),
    Guard(
        row=29,
        file=AMC,
        text="if _is_displaced(lines, fields, report) and not report.lenient:",
        without="if False:",
        test="test_amc_faults.py::test_fault[row-29-line-missing]",
    ),
    Guard(
        row=29,
        file="formats/amc.py",
        text="if not with_polar_cap:",
        without="if True:",
        test="test_amc_faults.py::test_what_is_read_gives_the_same_photons[row-29-older-layout-is-read]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text='return [line[:-1] if line.endswith("\\r") else line for line in lines]',
        without="return lines",
        test="test_amc_faults.py::test_what_is_read_gives_the_same_photons[row-30-crlf-is-read]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text="data = data.removeprefix(_BOM_UTF8)",
        without="",
        test="test_amc_faults.py::test_what_is_read_gives_the_same_photons[row-30-byte-order-mark-is-read]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text="if not pieces and piece.startswith(_BOMS_OTHER):",
        without="if False:",
        test="test_amc_faults.py::test_fault[row-30-sky-utf-16]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text='if (nul := piece.find(b"\\0")) >= 0:',
        without="if False:",
        test="test_amc_faults.py::test_fault[row-30-nul-bytes]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text='if b"\\r" in data and (lone_return := _LONE_RETURN.search(data)):',
        without="if False:",
        test="test_amc_faults.py::test_fault[row-30-lone-returns]",
    ),
    Guard(
        row=30,
        file=TEXT,
        text="if long_line is not None:",
        without="if False:",
        test="test_amc_faults.py::test_a_gigabyte_in_one_line[row-30-gigabyte-in-one-line-of-amc.inp]",
    ),
)
BAND_GUARDS = (
    Guard(
        row=31,
        file=BANDS,
        text="if n_wavebands is not None and count != n_wavebands:",
        without="if False:",
        test="test_file_faults.py::test_fault[row-31-count-of-lambbot-differs]",
    ),
    Guard(
        row=32,
        file=BANDS,
        text="if not 0 <= value <= highest[k]:",
        without="if not value >= 0:",
        test="test_file_faults.py::test_fault[row-32-reflectance-above-1]",
    ),
    Guard(
        row=32,
        file=BANDS,
        text="if not 0 <= value <= highest[k]:",
        without="if not value <= highest[k]:",
        test="test_file_faults.py::test_fault[row-32-reflectance-negative]",
    ),
    Guard(
        row=32,
        file=BANDS,
        text="elif not math.isfinite(value):",
        without="elif math.isinf(value):",
        test="test_file_faults.py::test_fault[row-32-reflectance-nan]",
    ),
    Guard(
        row=32,
        file="formats/amc.py",
        text="(1.0, inf)",
        without="(inf, inf)",
        test="test_file_faults.py::test_fault[row-32-direct-fraction-above-1]",
    ),
)
NO_FILE_GUARDS = (
    Guard(
        row=33,
        file=TEXT,
        text='    except FileNotFoundError:\n        raise refuse(path, "there is no such file") from None\n',
        without="",
        test="test_file_faults.py::test_what_is_no_file[row-33-missing]",
    ),
    Guard(
        row=33,
        file=TEXT,
        text="if not stat.S_ISREG(status.st_mode):",
        without="if False:",
        test="test_file_faults.py::test_what_is_no_file[row-33-a-device]",
    ),
    Guard(
        row=33,
        file=TEXT,
        text="if not stat.S_ISREG(status.st_mode):",
        without="if False:",
        test="test_file_faults.py::test_what_is_no_file[row-33-a-pipe]",
    ),
    Guard(
        row=33,
        file=TEXT,
        text="max(status.st_size, UNSIZED_BYTES))\n    except OSError as error:",
        without="max(status.st_size, UNSIZED_BYTES))\n    except UnicodeError as error:",
        test="test_file_faults.py::test_a_file_that_cannot_be_read[row-33-a-file-that-cannot-be-read]",
    ),
)
SCENE_GUARDS = (*NUMBER_GUARDS, *AMC_GUARDS, *BAND_GUARDS, *NO_FILE_GUARDS)
