"""Descriptions and tables made to hurt: an answer for each, at little cost."""

from tests.support.limits import answers_within_limits
from tests.support.shared import DATA

PLAIN = (DATA / "atmo" / "good" / "plain.atmo").read_text()
READERS = """
from aomc_sky.skies.atmosphere.description.reader import read_atmo
readers = (read_atmo,)
"""


def with_sun(value):
    return PLAIN.replace("1.5, 1.9, 1.7, 1.4", value)


def with_ground(albedo, sun):
    return with_sun(sun).replace("ground albedo: 0.1, 0.1, 0.2, 0.3\n", albedo)


def with_head(lines):
    return PLAIN.replace("scattering orders", f"{lines}scattering orders", 1)


def absorbers(n, body):
    return PLAIN + "".join(f'Absorber "a{k}":\n{{\n{body}}}\n' for k in range(n))


CODE = "number density:\n```\n1\n```\n"
TEXTS = {
    # every name ends in what is wanted
    "unknown_keys_read": with_head("a:1\n" * 40_000),
    "repeated_keys_read": with_head("scattering orders:9\n" * 20_000),
    "unknown_keys_of_a_section_read": PLAIN.replace("    angstrom", "a:1\n" * 40_000 + "    angstrom"),
    "lines_without_colon_E401": with_head("ab\n" * 340_000),
    "lines_of_colons_E401": with_head("::\n" * 340_000),
    "braces_E401": with_head("{\n" * 500_000),
    "nested_sections_E401": "version: 6\n" + 'Scatterer "a":\n{\n' * 60_000,
    "empty_sections_E405": "version: 6\n" + "".join(f'Absorber "{k}":\n{{\n}}\n' for k in range(10_000)),
    "too_many_species_E407": absorbers(300, f"{CODE}cross section: 1, 1, 1, 1\n"),
    "one_name_E407": PLAIN + ('Absorber "a":\n{\n' + CODE + "cross section: 1,1,1,1\n}\n") * 10_000,
    "open_fences_E401": "version: 6\n" + "number density:\n```\n" * 40_000,
    "fences_far_away_E401": "version: 6\n" + 'Absorber "a":\n{\nnumber density:\n' + "\n" * 100_000,
    "keys_without_fence_E401": 'version: 6\nScatterer "a":\n{\n' + "number density:\n\n" * 50_000,
    "long_code_read": PLAIN.replace("return 1e18;", "x;\n" * 300_000),
    "key_of_one_line_read": with_head("k" * 65_000 + ": 1\n"),
    "digits_E401": PLAIN.replace("120 km", "9" * 60_000 + " km"),
    "points_E401": PLAIN.replace("120 km", "0." * 30_000 + " km"),
    "blanks_E401": PLAIN.replace("120 km", "1" + " " * 60_000 + "!"),
    "digits_and_blanks_E401": PLAIN.replace("120 km", "1" * 30_000 + " " * 30_000 + "!"),
    "count_of_many_digits_E404": PLAIN.replace("count=4", "count=" + "9" * 60_000),
    "range_of_blanks_E401": PLAIN.replace("count=4", " " * 60_000 + "x"),
    "long_list_E408": with_sun("1," * 30_000 + "1"),
    "weighted_blanks_E401": with_sun("weighted file" + " " * 60_000),
    "one_table_often_E402": with_ground("ground albedo: weighted file 0.000001 t.csv\n" * 20_000, "file t.csv"),
    "missing_tables_E402": with_ground("ground albedo: weighted file 1 no.csv\n" * 20_000, "file no.csv"),
    "many_tables_E402": with_ground(
        "".join(f"ground albedo: weighted file 0.01 many{k}.csv\n" for k in range(80)), "1, 1, 1, 1"
    ),
    "dense_table_read": with_ground(
        "light pollution relative radiance: file dense.csv\n" + "ground albedo: weighted file 0.001 dense.csv\n" * 900,
        "file dense.csv",
    ),
    "bad_table_E401": with_sun("file bad.csv"),
    "deep_path_E402": with_sun("file " + "a/" * 30_000 + "t.csv"),
    "comments_E405": "#\n" * 500_000,
    "fine_grid_E408": PLAIN.replace("count=4", "count=4096"),
}


def tables():
    yield "t.csv", b"300,0.5\n900,0.5\n"
    yield "dense.csv", b"".join(b"%.4f,0.5\n" % (300 + k / 90) for k in range(60_000))
    yield "bad.csv", b"x\n" * 500_000
    for k in range(80):
        yield f"many{k}.csv", b"300,0.5\n900,0.5\n"


def test_each_gets_an_answer(tmp_path):
    for name, table in tables():
        (tmp_path / name).write_bytes(table)
    for name, text in TEXTS.items():
        (tmp_path / f"{name}.atmo").write_text(text)
    with (tmp_path / "sparse_E401.atmo").open("wb") as file:
        file.truncate(2**30)
    (tmp_path / "line_E101.atmo").write_bytes(b"a" * 1_000_000)
    paths = list(tmp_path.glob("*.atmo"))
    assert len(paths) == len(TEXTS) + 2
    found = {path.stem: answers_within_limits(READERS, path) for path in paths}
    assert {name: answer for name, answer in found.items() if not name.endswith(f"_{answer[0]}")} == {}
