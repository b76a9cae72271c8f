"""The folder in which the mistakes of docs/errors.md are made."""

from __future__ import annotations

import shutil
from pathlib import Path

from tests.support.scenes import copy_scene
from tests.support.shared import INPUTS


def make_folder(folder: Path) -> None:
    """A scene, a run of it, a scene whose sky.toml has an unknown key, an atmosphere, and a program."""
    from aomc_sky.cli.main import main

    copy_scene("document_example", folder).parent.rename(folder / "scene")
    words = ["run", str(folder / "scene"), "--iterations", "100", "-q", "--out"]
    assert main([*words, str(folder / "out")]) == 0
    shutil.copytree(INPUTS / "perez_sky", folder / "misspelt")
    (folder / "misspelt" / "sky.toml").write_text("[perez]\ndni = 850.0\ndiffuse = 95.0\n")
    shutil.copy(INPUTS / "atmosphere" / "molecules_only.atmo", folder / "air.atmo")
    (folder / "my_sky.py").write_text("import aomc_sky\n")
