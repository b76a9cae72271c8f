"""The MCPL reader against libmcpl, on every option of the format, and on files that somebody broke."""

import os
import platform
import struct
import time
from dataclasses import replace

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats.mcpl.file import check_mcpl, read_mcpl
from aomc_sky.formats.mcpl.header import McplHeader, encode_header
from tests.support.limits import MOST_CPU_S, answers_within_limits
from tests.support.mcpl import COUNT_OFFSET, encoded, oracle, random_particles

N = 400
FULL = {
    "source": "a program",
    "comments": ("first", "stat:sum:runs:                       3", "Grüße \N{SUN}"),
    "blobs": (("key", b"\0\1\2"), ("empty", b"")),
}
# on other machines the compiler of libmcpl may fuse a product and a sum
ULPS = 0 if platform.machine() in {"x86_64", "AMD64"} else 4


def options():
    """Every pair of two options is among them."""
    switches = [(0, 0, 0, 0, 0), (0, 1, 1, 1, 1), (1, 0, 0, 1, 1), (1, 1, 1, 0, 0), (1, 0, 1, 0, 1), (0, 1, 0, 1, 0)]
    names = ("has_user_flags", "has_polarisation", "is_double")
    return [
        McplHeader(
            n_particles=N,
            pdg_code=22 * pdg,
            weight=0.75 * weight,
            **dict(zip(names, map(bool, kinds), strict=True)),
            **FULL,
        )
        for *kinds, pdg, weight in switches
    ]


def name_of(header):
    marks = {"flags": header.has_user_flags, "polarised": header.has_polarisation, "double": header.is_double}
    return "-".join([k for k, v in marks.items() if v] + [str(header.pdg_code), str(header.weight)])


@pytest.mark.parametrize("header", options(), ids=name_of)
def test_every_option_is_read_as_libmcpl_does(header, tmp_path):
    library, path = oracle(), tmp_path / "x.mcpl"
    particles = random_particles(N, 3)
    library.write(path, header, [particles])
    file = read_mcpl(path)
    assert file.header == header
    ours, theirs = file.particles(), library.read(path)
    names = {"energy": "ekin", "pdg_code": "pdgcode", "user_flags": "userflags"}
    for name in (*names, "position", "time", "weight", "polarisation"):
        assert np.array_equal(getattr(ours, name), theirs[names.get(name, name)]), name
    np.testing.assert_array_max_ulp(ours.direction, theirs["direction"], ULPS)
    if ULPS == 0:
        assert ours.direction.tobytes() == np.ascontiguousarray(theirs["direction"]).tobytes()  # signs of zeros too
    assert path.read_bytes()[: file.data_start] == encode_header(header)


@pytest.mark.parametrize("is_double", [False, True])
def test_version_2_is_read_as_libmcpl_does(is_double, tmp_path):
    header = McplHeader(n_particles=N, version=2, is_double=is_double, pdg_code=22, weight=1.0)
    generator = np.random.default_rng(8)
    records = np.zeros(N, header.record)
    records["packed"] = generator.uniform(-1, 1, size=(N, 3))
    records["packed"][:9, :2] = [(a, b) for a in (-1, 0, 1) for b in (-1, 0, 1)]
    path = tmp_path / "x.mcpl"
    path.write_bytes(encoded(header, records))
    ours, theirs = read_mcpl(path).particles(), oracle().read(path)
    assert np.array_equal(ours.energy, theirs["ekin"])
    np.testing.assert_array_max_ulp(ours.direction, theirs["direction"], ULPS)
    assert (ours.direction[np.signbit(records["packed"][:, 2]), 2] == 0).all()


def test_the_other_byte_order_gives_the_same_particles(tmp_path):
    header = McplHeader(n_particles=N, has_user_flags=True, has_polarisation=True, is_double=True, **FULL)
    library = oracle()
    library.write(tmp_path / "native.mcpl", header, [random_particles(N, 4)])
    native = read_mcpl(tmp_path / "native.mcpl")
    data = (tmp_path / "native.mcpl").read_bytes()[native.data_start :]
    records = np.frombuffer(data, native.header.record)
    swapped = replace(header, is_little_endian=not native.header.is_little_endian)
    (tmp_path / "swapped.mcpl").write_bytes(encoded(swapped, records.astype(swapped.record)))
    other = read_mcpl(tmp_path / "swapped.mcpl")
    assert other.header == swapped
    for name in native.particles().__slots__:
        assert np.array_equal(getattr(native.particles(), name), getattr(other.particles(), name)), name


def test_blocks_are_the_particles_in_order(tmp_path):
    path = tmp_path / "x.mcpl"
    oracle().write(path, McplHeader(n_particles=N), [random_particles(N, 5)])
    file = read_mcpl(path)
    blocks = list(file.blocks(150))
    assert [(b.start, len(b)) for b in blocks] == [(0, 150), (150, 150), (300, 100)]
    assert np.array_equal(np.concatenate([b.direction for b in blocks]), file.particles().direction)
    assert np.array_equal(file.particles(7, 9).energy, file.particles().energy[7:9])
    assert len(file.particles(N, N)) == 0
    for start, stop in ((-1, 2), (3, 2), (0, N + 1)):
        with pytest.raises(IndexError):
            file.particles(start, stop)
    with pytest.raises(ValueError, match="at least 1"):
        next(file.blocks(0))


# ---- broken files ------------------------------------------------------------------------------


def small(**changes):
    """A head and three records."""
    header = replace(McplHeader(n_particles=3, weight=1.0, pdg_code=22, has_user_flags=True, **FULL), **changes)
    records = np.zeros(3, header.record)
    records["packed"] = (0.6, 0.0, 1.0)
    return header, records.tobytes()


def with_number(data, offset, form, value):
    packed = struct.pack(form, value)
    return data[:offset] + packed + data[offset + len(packed) :]


def with_field(name, value, *, column=None, **changes):
    header, data = small(**changes)
    records = np.frombuffer(data, header.record).copy()
    records[name][1 if column is None else (1, column)] = value
    return encoded(header, records)


GOOD = encoded(*small())
HEAD = len(encode_header(small()[0]))
BROKEN = {
    "E802": {
        "empty": b"", "no_mcpl": b"NPCL003L" + bytes(100), "magic_alone": b"MCPL",
        "version_1": GOOD[:4] + b"001" + GOOD[7:], "version_letters": GOOD[:4] + b"\xff\n3" + GOOD[7:],
        "byte_order": GOOD[:7] + b"X" + GOOD[8:],
    },
    "E803": {
        "cut_in_the_numbers": GOOD[:47], "cut_in_the_head": GOOD[:40], "cut_in_a_comment": GOOD[: HEAD - 20],
        "comment_beyond_the_file": with_number(GOOD, 56, "<I", 2**32 - 1),
        "comments_beyond_the_file": with_number(GOOD, 16, "<I", 2**32 - 1),
        "blobs_beyond_the_file": with_number(GOOD, 20, "<I", 2**31),
        "another_switch": with_number(GOOD, 24, "<I", 0), "record_length": with_number(GOOD, 40, "<I", 96),
        "sum_without_a_number": GOOD.replace(b"       3", b"       x"),
        **{f"weight_{weight}": with_number(GOOD, 48, "<d", weight) for weight in (np.nan, 0.0, -1.0)},
    },
    "E804": {
        "billion_billions": with_number(GOOD, COUNT_OFFSET, "<Q", 10**18), "cut_record": GOOD[:-5],
        "record_too_many": GOOD + bytes(small()[0].record.itemsize),
        "never_closed": with_number(GOOD, COUNT_OFFSET, "<Q", 0),
    },
    "E805": {
        **{f"packed_{k}": with_field("packed", value, column=k) for k, value in enumerate((np.nan, 1.1, np.nan))},
        "nan_position": with_field("position", np.nan, column=2), "infinite_time": with_field("time", np.inf),
        "nan_weight": with_field("weight", np.nan, weight=0.0),
        "nan_polarisation": with_field("polarisation", np.nan, column=0, has_polarisation=True),
    },
    "E806": {"compressed": b"\x1f\x8b\x08\0" + bytes(50)},
}  # fmt: skip


@pytest.mark.parametrize(("code", "name"), [(code, name) for code, files in BROKEN.items() for name in files])
def test_broken_files_have_their_code(code, name, tmp_path):
    path = tmp_path / "x.mcpl"
    path.write_bytes(BROKEN[code][name])
    with pytest.raises(InputFileError) as caught:
        check_mcpl(path)
    assert {p.code for p in caught.value.problems} == {code}
    assert str(caught.value).startswith(f"{path}: error[{code}]: ")


def test_any_number_but_0_switches_a_field_on_as_in_libmcpl(tmp_path):
    path = tmp_path / "x.mcpl"
    path.write_bytes(with_number(GOOD, 24, "<I", 7))
    assert read_mcpl(path).header == small()[0]
    assert len(oracle().read(path)) == len(read_mcpl(path).particles()) == 3


def test_the_library_prints_nothing_and_leaves_nothing(tmp_path, capfd, monkeypatch):
    """It warns of files that were not closed and of comments that it does not know."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    (tmp_path / "x.mcpl").write_bytes(with_number(encoded(*small(comments=("stat:new:kind",))), COUNT_OFFSET, "<Q", 0))
    with pytest.raises(InputFileError, match="E804"):
        check_mcpl(tmp_path / "x.mcpl")
    assert capfd.readouterr() == ("", "")
    assert [path.name for path in tmp_path.iterdir()] == ["x.mcpl"]


def test_a_whole_file_has_no_problems(tmp_path):
    for data, n in ((GOOD, 3), (encode_header(McplHeader(n_particles=0)), 0)):
        (tmp_path / "x.mcpl").write_bytes(data)
        check_mcpl(tmp_path / "x.mcpl")
        assert len(read_mcpl(tmp_path / "x.mcpl").particles()) == n


def test_bad_records_and_files_that_shrink_are_input_errors(tmp_path):
    header = McplHeader(n_particles=1000, weight=1.0, pdg_code=22)
    records = np.zeros(1000, header.record)
    records["time"][100::2] = np.nan
    path = tmp_path / "x.mcpl"
    path.write_bytes(encoded(header, records))
    with pytest.raises(InputFileError) as caught:
        read_mcpl(path).particles()
    assert [p.message.split(":")[0] for p in caught.value.problems] == [f"record {k}" for k in range(100, 140, 2)]
    with pytest.raises(InputFileError, match="record 502"):
        read_mcpl(path).particles(501, 503)
    assert len(read_mcpl(path).particles(0, 100)) == 100
    path = tmp_path / "x.mcpl"
    path.write_bytes(GOOD)
    file = read_mcpl(path)
    path.write_bytes(GOOD[:-1])
    with pytest.raises(InputFileError, match="shorter"):
        file.particles()


def broken_copies(n):
    """Copies of files of every kind with bytes changed, cut off, put in or taken out."""
    generator, templates = np.random.default_rng(20), []
    for header in [*options(), replace(options()[5], is_little_endian=False)]:
        records = np.zeros(5, header.record)
        records["packed"] = generator.uniform(-0.7, 0.7, size=(5, 3))
        templates.append(encoded(replace(header, n_particles=5), records))
    for k in range(n):
        data = bytearray(templates[k % len(templates)])
        place, width = generator.integers(len(data)), generator.integers(1, 40)
        for _ in range(generator.integers(1, 4)):
            data[generator.integers(len(data) if k % 2 else 60)] = generator.integers(256)
        end, more = [(len(data), b""), (place, generator.bytes(width)), (place + width, b"")][k % 3]
        yield bytes(data[:place] + more + data[end:]) if k % 5 < 3 else bytes(data)


def test_broken_copies_give_particles_or_an_input_error(tmp_path):
    path, codes, begin = tmp_path / "x.mcpl", [], time.process_time()
    for data in broken_copies(300):
        path.write_bytes(data)
        try:
            check_mcpl(path)
        except InputFileError as error:
            codes += {problem.code for problem in error.problems}
            continue
        particles = read_mcpl(path).particles()
        assert len(particles) <= 40
        assert np.isfinite(particles.energy).all()
        assert (np.abs((particles.direction**2).sum(axis=1) - 1) < 3e-5).all()
    assert set(codes) <= {"E802", "E803", "E804", "E805"}
    assert len(codes) > 150
    assert time.process_time() - begin < MOST_CPU_S


READERS = "from aomc_sky.formats.mcpl.file import check_mcpl\nreaders = (check_mcpl,)"


def sparse(data, size):
    def make(path):
        path.write_bytes(data)
        os.truncate(path, size)

    return make


def texts(n, length):
    """As many comments as announced, in a file that is long enough for them."""
    head = with_number(encode_header(McplHeader(n_particles=0, pdg_code=22, weight=1.0)), 16, "<I", n)
    return lambda path: path.write_bytes(head + (struct.pack("<I", length) + b"\xff" * length) * n)


@pytest.mark.parametrize(
    ("make", "code"),
    [
        (sparse(b"", 2**34), "E802"), (sparse(GOOD, 2**36), "E804"),
        (sparse(with_number(GOOD, COUNT_OFFSET, "<Q", 10**18), 2**40), "E804"),
        (sparse(with_number(GOOD, 56, "<I", 2**32 - 1), 2**36), "E803"),
        (sparse(with_number(GOOD, 16, "<I", 2**32 - 1), 2**36), "E803"),
        (sparse(with_number(GOOD, 16, "<I", 9999), 2**36), "E803"), (texts(10_001, 0), "E803"),
        (texts(9000, 1700), "read"), (texts(3, 8_000_000), "E803"),
    ],
)  # fmt: skip
def test_large_bad_files_cost_little(make, code, tmp_path):
    path = tmp_path / "x.mcpl"
    make(path)
    assert answers_within_limits(READERS, path) == [code]
