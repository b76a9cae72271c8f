"""EPW, TMY2 and TMY3: when each hour began, what it held, and what is said about a bad file.

The good files are invented: GHI of the clear sky of pvlib (Haurwitz) in the middle of each hour, times a factor of
clouds, split by the correlation of Erbs; inputs/weather/two_days.epw is the same as invented.epw.
"""

import re
import warnings

import numpy as np
import pytest

from aomc_sky.errors import InputFileError
from aomc_sky.formats.weather import HOUR, read_weather
from tests.support.shared import DATA

WEATHER = DATA / "weather"
GOOD = {"epw": "invented.epw", "tmy3": "invented.tmy3.csv", "tmy2": "invented.tm2"}


def good(kind):
    return read_weather(WEATHER / "good" / GOOD[kind], kind)


@pytest.mark.parametrize(
    ("kind", "first", "latitude", "longitude", "place"),
    [
        # local midnight of the first day, in UTC: the label of the first row is 1, the hour began at 0
        ("epw", "2003-06-20T23:00:00", 52.40, 13.22, "Kleinmachnow"),
        ("tmy3", "1996-02-28T07:00:00", 40.017, -105.25, "INVENTED FIELD"),
        ("tmy2", "1962-01-31T08:00:00", 34 + 56 / 60, -(120 + 25 / 60), "SAN INVENTADO"),
    ],
)
def test_hours_begin_one_hour_before_their_label(kind, first, latitude, longitude, place):
    table = good(kind)
    assert table.start[0] == np.datetime64(first)
    assert table.midpoint[0] == np.datetime64(first) + np.timedelta64(30, "m")
    assert (table.latitude_deg, table.longitude_deg, table.station) == (latitude, longitude, place)
    assert table.line.size == 48
    assert table.line[0] == {"epw": 9, "tmy3": 3, "tmy2": 2}[kind]
    for day in (table.start[:24], table.start[24:]):
        assert np.all(np.diff(day) == HOUR)
    assert not table.start.flags.writeable


@pytest.mark.parametrize("kind", ["epw", "tmy3", "tmy2"])
def test_the_sun_at_the_middle_of_the_hour_fits_the_irradiances(kind):
    # the samples were made so: GHI = DNI cos Z + DHI, whole numbers; half an hour off would be wrong by tens
    pytest.importorskip("pvlib")
    from aomc_sky.source.light.sun_position import sun_position

    table = good(kind)
    sun = sun_position(table.midpoint, table.latitude_deg, table.longitude_deg)
    cosine = np.maximum(np.cos(np.deg2rad(sun.zenith_deg)), 0)
    assert np.abs(table.dni * cosine + table.dhi - table.ghi).max() < 1.6
    for minutes in (-30, 30):
        late = sun_position(table.midpoint + np.timedelta64(minutes, "m"), table.latitude_deg, table.longitude_deg)
        off = table.dni * np.maximum(np.cos(np.deg2rad(late.zenith_deg)), 0) + table.dhi - table.ghi
        assert np.abs(off).max() > 30


def test_pvlib_reads_the_same_and_marks_the_end_of_tmy3_hours_alone():
    iotools = pytest.importorskip("pvlib").iotools
    for kind, read, shift in (("epw", iotools.read_epw, 0), ("tmy3", iotools.read_tmy3, 1)):
        table = good(kind)
        frame, _ = read(str(WEATHER / "good" / GOOD[kind]))
        stamps = frame.index.tz_convert("UTC").tz_localize(None).to_numpy().astype("M8[s]")
        off = stamps != table.start + shift * HOUR
        # pvlib moves 24:00 of a 28 February of a leap year to 1 March, a day too late
        assert np.flatnonzero(off).tolist() == ([23] if kind == "tmy3" else [])
        columns = {name.lower(): name for name in frame.columns}
        for name in ("dni", "dhi", "ghi"):
            assert np.array_equal(frame[columns[name]].to_numpy(), getattr(table, name))


@pytest.mark.parametrize(
    ("date", "column"),
    [("1799,6,21,1", 1), ("2201,6,21,1", 1), ("2003.5,6,21,1", 1), ("2003,0,21,1", 6), ("2003,13,21,1", 6),
     ("2003,,21,1", 6), ("2003,6,0,1", 8), ("2003,6,31,1", 8), ("2003,2,29,1", 8), ("2003,6,1.5,1", 8),
     ("2003,6,21,-1", 11), ("2003,6,21,25", 11), ("2003,6,21,1.5", 11), ("1800,1,1,1", 0), ("2200,12,31,24", 0)],
)  # fmt: skip
def test_only_dates_that_exist(date, column, read):
    text = changed("epw", ("2003,6,21,1,", f"{date},"))
    if column == 0:
        year, month, day, hour = map(int, date.split(","))
        midnight = np.datetime64(f"{year}-{month:02d}-{day:02d}T00:00:00")
        assert read(text).start[0] == midnight + (hour - 2) * HOUR  # the zone is an hour east
        return
    with pytest.raises(InputFileError, match=rf":9:{column}: error\[E602\]"):
        read(text)


@pytest.fixture
def read(tmp_path):
    """Reads a text as a weather file."""

    def call(text, kind="epw", encoding="utf-8", **how):
        path = tmp_path / f"changed.{kind}"
        path.write_bytes(text.encode(encoding))
        return read_weather(path, kind, **how)

    return call


def changed(kind, *changes):
    """Text of a good file with the first place of some texts changed."""
    text = (WEATHER / "good" / GOOD[kind]).read_text()
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    return text


def lines_of(kind):
    return changed(kind).splitlines()


@pytest.mark.parametrize(
    ("kind", "old", "new", "missing"),
    [
        *(("epw", ",186,538,67,", new, True) for new in (",186,9999,67,", ",186,538,99999,", ",186,,67,")),
        ("epw", ",186,538,67,", ",9999,538,67,", False), ("tmy2", " 219E8 450E8", " 219E89999?0", True),
        ("tmy3", "119,1,8,328,1,9,67,", "119,1,8,-9900,1,9,67,", True),
    ],
)  # fmt: skip
def test_missing_values_are_marked_and_never_used(kind, old, new, missing, read):
    table = read(changed(kind, (old, new)), kind)
    assert np.isnan(table.dni + table.dhi).sum() == int(missing)
    values = np.array([table.dni, table.dhi, table.ghi])
    (row,) = np.flatnonzero(np.isnan(values).any(axis=0))
    assert len(table.irradiances(row)) == 2
    assert np.isfinite(list(table.irradiances(row).values())).all()


def test_a_quoted_name_may_hold_a_comma_zero_may_have_a_sign_and_zones_half_hours(read):
    signed = (",300,0,0,0,", ",300,0.00,-0.00,0.00,")
    table = read(changed("epw", (",Kleinmachnow,", ',"Kleinmachnow, south",'), signed, (",13.22,1.0,", ",77.2,5.5,")))
    assert (table.station, table.latitude_deg) == ("Kleinmachnow, south", 52.40)
    assert not np.signbit(table.dni).any()
    assert table.start[0] == np.datetime64("2003-06-20T18:30:00")


@pytest.mark.parametrize(
    ("place", "is_doubtful"),
    [("13.22,1.0", False), ("75.99,8.0", False), ("-157.4,14.0", False), ("13.22,-8.0", True), ("-105.2,7.0", True),
     ("15.0,-2.0", False), ("15.0,-2.1", True), ("15.0,4.0", False), ("15.0,4.1", True)],
)  # fmt: skip
def test_a_zone_far_from_the_longitude_is_warned_of(place, is_doubtful, read):
    """Kashgar and Kiritimati are within three hours of their sun; a sign that is wrong is not."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read(changed("epw", (",13.22,1.0,", f",{place},")))
    assert [bool("where the sun is" in str(one.message)) for one in caught] == [True] * is_doubtful


def test_rows_of_less_than_an_hour_are_no_hours(read):
    """By their minutes, or by an hour that comes twice; the row that is asked for is not one of them, either."""
    lines = lines_of("epw")
    minute = lines[8].split(",")[4]
    halves = changed("epw", (f"2003,6,21,12,{minute},", "2003,6,21,12,30,"))
    twice = "\n".join([*lines[:20], lines[19], *lines[20:]])
    for text, line, other in ((halves, 20, 20), (twice, 21, 12)):
        for row in (None, 11, other):
            with pytest.raises(InputFileError, match=rf":{line}:\d+: error\[E602\]"):
                read(text, row=row)
    assert read(twice, row=20).ghi[20] == good("epw").ghi[19]


@pytest.mark.parametrize(
    ("kind", "old", "new"),
    [("epw", ",300,0,0,0,", ",300,-0.3,-5,-0.01,"), ("tmy3", "119,1,8,328,1,9,67,", "-0.3,1,8,-5,1,9,-0.01,")],
)
def test_the_offset_of_an_instrument_is_no_light(kind, old, new, read):
    table = read(changed(kind, (old, new)), kind)
    assert min(table.ghi.min(), table.dni.min(), table.dhi.min()) == 0.0
    for beyond in ("-5.01", "2000.1", "2559.6"):
        with pytest.raises(InputFileError, match=rf"E603\]: .*'{beyond}'"):
            read(changed(kind, (old, new.replace("-5", beyond))), kind)


@pytest.mark.parametrize("bad", [",300,-80,0,0,", ",300,none,0,0,", ",300,0,0,5000,"])
def test_only_the_row_that_is_asked_for_is_judged(bad, read):
    """A bad night refuses the file as a whole, and itself, but no other hour."""
    text = changed("epw", (",300,0,0,0,", bad))
    for row in (None, 0):
        with pytest.raises(InputFileError, match=r"changed\.epw:9:"):
            read(text, row=row)
    table = read(text, row=11)
    assert table.irradiances(0) == {}
    assert table.irradiances(11) == good("epw").irradiances(11)
    assert np.array_equal(table.start, good("epw").start)
    text = text.replace("2003,6,21,1,", "2003,6,31,1,")  # and a date that does not exist, left of it
    with pytest.raises(InputFileError, match=r":9:8: error\[E602\]"):
        read(text)
    assert np.flatnonzero(np.isnat(read(text, row=11).start)).tolist() == [0]


def test_a_quoted_cell_may_hold_a_comma(read):
    """RFC 4180: the flags of a row in quotes."""
    row = lines_of("epw")[19]
    fields = row.split(",")
    quoted = ",".join([*fields[:5], f'"{fields[5]}, ?"', *fields[6:]])
    assert read(changed("epw", (row, quoted))).irradiances(11) == good("epw").irradiances(11)
    wrong = quoted.replace(f",{fields[13]},", ",word,", 1)
    with pytest.raises(InputFileError) as caught:
        read(changed("epw", (row, wrong)))
    assert caught.value.problems[0].column == wrong.index("word") + 1


def test_a_huge_file_is_refused_unread(tmp_path):
    path = tmp_path / "huge.epw"
    with path.open("wb") as file:
        file.truncate(2**31)
    with pytest.raises(InputFileError, match="E101"):
        read_weather(path, "epw")


EPW_NUMBERS = [k for k in range(6, 35) if k not in (26, 27)]


def with_commas(columns, n_fields=35):
    """The invented EPW file with decimals written with commas in some columns, and so many fields a row."""
    lines = lines_of("epw")
    for k in range(8, len(lines)):
        fields = lines[k].split(",")[:n_fields]
        for column in columns:
            if column < n_fields:
                fields[column] = f"{float(fields[column]):.1f}".replace(".", ",")
        lines[k] = ",".join(fields)
    return "\n".join(lines) + "\n"


def without_a_field(column):
    lines = lines_of("epw")
    fields = lines[8].split(",")
    return "\n".join([*lines[:8], ",".join(fields[:column] + fields[column + 1 :]), *lines[9:]])


def short_with_commas(*columns):
    """Rows without the last fields have room for a shift; the pressure of such a row is another number."""
    return with_commas(columns, n_fields=30)


LOCATION, TMY3 = lines_of("epw")[0], lines_of("tmy3")
HALF = [line.replace(",", ",0,5,", 1) for line in TMY3[2:]]
EARLY = [re.sub(r",(\d\d):00,", lambda time: f",{int(time[1]) - 1:02d}:00,", line, count=1) for line in TMY3]
SHIFTED = {
    **{f"comma in field {k}": with_commas([k]) for k in EPW_NUMBERS},
    **{
        f"commas in a short row {k}": short_with_commas(*k) for k in ((6,), (7,), (6, 7, 21), (6, 8), (6, 7, 8), (7, 8))
    },
    **{f"no field {k}": without_a_field(k) for k in (4, 5, 6)},
    **{f"pressure {p}": changed("epw", (",101300,", f",{p},")) for p in ("0.1", "101.3", "999.9")},
}
OTHERS = {
    "hour 0": ("32:11 E602", changed("epw", ("2003,6,21,24,", "2003,6,22,0,"))),
    # an entry too few or too many moves latitude and longitude
    "no state": ("1:1 E601", changed("epw", (LOCATION, "LOCATION,Amsterdam,NLD,IWEC,0,52.30,4.77,1.0,-2.0"))),
    "city": ("1:1 E601", changed("epw", (LOCATION, "LOCATION,Berlin, south,-,DEU,x,0,52.40,13.22,1.0,36.0"))),
    "commas of tmy3": ("3:1 E602", "\n".join([*TMY3[:2], *HALF])),
    "column twice": ("2:1 E601", changed("tmy3", ("ETR (W/m^2)", "GHI (W/m^2)"))),
}
REFUSED = {name: ("9:1 E602", text) for name, text in SHIFTED.items()} | OTHERS


@pytest.mark.parametrize("name", REFUSED)
def test_columns_that_are_shifted_or_not_clear_are_refused(name, read):
    place, text = REFUSED[name]
    with pytest.raises(InputFileError) as caught:
        read(text, "tmy3" if text.startswith(TMY3[0]) else "epw")
    first = caught.value.problems[0]
    assert f"{first.line}:{first.column} {first.code}" == place


SAME = {
    "the end of a day as the start of the next": changed("tmy3", ("02/28/1996,24:00", "02/29/1996,00:00")),
    "other line ends, and blank lines": "\r\n".join([*lines_of("epw"), "", ""]),
    "names in quotes": "\n".join([TMY3[0], ",".join(f'"{name}"' for name in TMY3[1].split(",")), *TMY3[2:]]),
    # some programs end their lines with a comma
    **{f"rows of {n} fields": with_commas([], n).replace("\n", ",\n") for n in (16, 30, 35)},
}


@pytest.mark.parametrize("text", SAME.values(), ids=SAME)
def test_other_spellings_of_one_file(text, read):
    kind = "tmy3" if text.startswith(TMY3[0]) else "epw"
    for name in ("start", "dni", "dhi", "ghi"):
        np.testing.assert_array_equal(getattr(read(text, kind), name), getattr(good(kind), name))


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "latin-1"])
def test_the_encoding_of_a_station_is_found(encoding, read):
    assert read(changed("epw", ("Kleinmachnow", "Z\u00fcrich")), encoding=encoding).station == "Z\u00fcrich"


@pytest.mark.parametrize("row", [None, 11])
def test_hours_of_0_to_23_are_the_whole_file_s(row, read):
    """Each label is then an hour early, and so would be the sun of every row, whichever is asked for."""
    lines = lines_of("epw")
    cells = [line.split(",") for line in lines[8:]]
    early = [",".join([*one[:3], str(int(one[3]) - 1), *one[4:]]) for one in cells]
    for kind, text, place in (("epw", "\n".join([*lines[:8], *early]), "9:11"), ("tmy3", "\n".join(EARLY), "3:12")):
        with pytest.raises(InputFileError, match=rf":{place}: error\[E602\]"):
            read(text, kind, row=row)


@pytest.mark.parametrize(("given", "of"), [("epw", "tmy3"), ("tmy3", "epw"), ("epw", "tmy2"), ("tmy2", "epw")])
def test_a_head_of_another_kind_is_named(given, of):
    with pytest.raises(InputFileError, match="E601") as caught:
        read_weather(WEATHER / "good" / GOOD[given], of)
    assert ("--weather" in str(caught.value)) is (given != "tmy2")
