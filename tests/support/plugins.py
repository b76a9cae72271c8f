"""A package with a sky model of its own on the module path, as pip lays it there."""


def lay_package(site, module, code, *, name, distribution, version="1"):
    """Write the module and its entry point into a folder, which the caller puts on the module path."""
    about = site / f"{distribution.replace('-', '_')}-{version}.dist-info"
    about.mkdir(parents=True)
    (site / f"{module}.py").write_text(code)
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {distribution}\nVersion: {version}\n")
    (about / "entry_points.txt").write_text(f"[aomc_sky.sky_models]\n{name} = {module}:make\n")
    return site
