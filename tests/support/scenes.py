"""Small scenes written into a test's own folder."""

import json
import shutil

from tests.support.shared import INPUTS, REPOSITORY


def copy_scene(name, folder):
    """Copy a scene of inputs/ into `folder` and return its amc.inp."""
    target = folder / name
    shutil.copytree(INPUTS / name, target, ignore=shutil.ignore_patterns("aomc-sky-out"))
    return target / "amc.inp"


def coarse_atmosphere(folder):
    """A copy of atmosphere_sky whose light is scattered once into few patches; its amc.inp."""
    amc = copy_scene("atmosphere_sky", folder)
    keys = 'file = "clear.atmo"\norders = 1\nzenith_bins = 6\nazimuth_bins = 12\n'
    (amc.parent / "sky.toml").write_text(f"[atmosphere]\n{keys}[sun]\nzenith_deg = 41.5\n")
    return amc


def change_config(amc_inp, **values):
    """Write other values of some fields into an amc.inp of 30 lines."""
    from aomc_sky.formats.aomc.amc import fields_of_layout

    lines = amc_inp.read_text().splitlines()
    places = {
        field.name: (k, int if field.decimals is None else float) for k, field in enumerate(fields_of_layout(False))
    }
    for name, value in values.items():
        k, kind = places[name]
        lines[k] = f"{lines[k][:48]}{kind(value)}"
    amc_inp.write_text("\n".join([*lines, ""]))


def scene_with_circle(folder):
    """A copy of document_example with a round footprint, so that photons have positions; its amc.inp."""
    from aomc_sky.formats.aomc.amc import FootprintCode

    amc = copy_scene("document_example", folder)
    change_config(amc, footprint=FootprintCode.CIRCLE, circle_diameter_m=4.0)
    return amc


def flip_bit(path, position):
    data = bytearray(path.read_bytes())
    data[position] ^= 4
    path.write_bytes(data)


def run_bytes(folder):
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert "manifest.json" in files, sorted(files)
    return files


def manifest_of(folder):
    """The manifest of a run folder, which keeps the published schema."""
    import jsonschema

    schema = json.loads((REPOSITORY / "src/aomc_sky/outputs/manifest.schema.json").read_text())
    manifest = json.loads((folder / "manifest.json").read_text())
    jsonschema.Draft202012Validator(schema).validate(manifest)
    return dict(manifest)


def write_scene(folder, *, sky_text=None, difcol=None, bands=(500.0,), iterations=1000, flag=1, zenith=30):
    """Write amc.inp and lambbot.inp, and skydist.inp and difcol.inp where they are given; return the folder."""
    text = (INPUTS / "document_example" / "amc.inp").read_text().splitlines()
    for line, value in ((1, iterations), (2, flag), (4, zenith), (30, len(bands))):
        text[line - 1] = text[line - 1][:48] + str(value)
    (folder / "amc.inp").write_text("\n".join(text) + "\n")
    (folder / "lambbot.inp").write_text(f"{len(bands)}\n" + "".join(f"{b} 0.1 0.0\n" for b in bands))
    for name, content in (("skydist.inp", sky_text), ("difcol.inp", difcol)):
        if content is not None:
            (folder / name).write_text(content)
    return folder
