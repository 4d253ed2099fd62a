"""Import closures: which files an analysis depends on."""

from __future__ import annotations

from pathlib import Path

import pytest

from microimpact.closure import closure, imports_of, source_files

SCRIPTS = Path(__file__).parents[2] / "workflow/scripts"


def names(files):
    return {Path(file).name for file in files}


def test_a_study_depends_on_its_physics_and_on_no_other():
    found = closure(["microimpact.studies.coulomb_friction"])
    assert "microimpact.model.rigid_body" in found
    assert "microimpact.model" in found  # the package it stands in
    assert "microimpact.model.restitution" not in found
    assert not any(name.startswith("microimpact.figures") for name in found)


def test_the_root_drags_nothing_in():
    assert closure(["microimpact"]) == ["microimpact"]


def test_data_files_and_scripts_belong_to_a_figure():
    script = SCRIPTS / "draw_figure.py"
    found = names(source_files("microimpact.figures.restitution", scripts=[script]))
    assert {"microimpact.mplstyle", "style.py", "draw_figure.py", "tables.py"} <= found
    assert "py.typed" not in found
    assert "coulomb.py" not in found


def test_scripts_are_read_for_imports(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import numpy\n"
        "def late():\n"
        "    from microimpact.model import restitution\n"
        "    import microimpact.tables as t\n"
    )
    assert imports_of(script) == [
        "microimpact.model",
        "microimpact.model.restitution",
        "microimpact.tables",
    ]


def test_an_unknown_module_is_refused():
    with pytest.raises(ModuleNotFoundError, match=r"microimpact\.studies\.nothing"):
        closure(["microimpact.studies.nothing"])
