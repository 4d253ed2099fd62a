"""Import closures: which files an analysis depends on."""

from __future__ import annotations

from pathlib import Path

import pytest
from tests.shared import ROOT
from workflow.scripts.closure import closure, digest_of_files, imports_of, source_files

SCRIPTS = ROOT / "workflow/scripts"


def names(files):
    return {Path(file).name for file in files}


def test_a_study_depends_on_its_physics_and_on_no_other():
    found = closure(["microimpact.studies.models.coulomb_friction"])
    assert "microimpact.model.rigid_body.algebra" in found
    assert "microimpact.model" in found  # the package it stands in
    assert "microimpact.model.empirical.equations" not in found
    assert not any(name.startswith("microimpact.figures") for name in found)


def test_tables_are_of_every_study_and_figure():
    for module in ("studies.models.coulomb_friction", "studies.models.restitution_trends"):
        assert "microimpact.core.tables" in closure([f"microimpact.{module}"])
    trends = closure(["microimpact.studies.models.restitution_trends"])
    assert "microimpact.model.empirical.equations" in trends
    assert "microimpact.model.rigid_body.algebra" not in trends


def test_the_root_drags_nothing_in():
    assert closure(["microimpact"]) == ["microimpact"]


def test_data_files_and_scripts_belong_to_a_figure():
    script = SCRIPTS / "draw_figures.py"
    found = names(source_files("microimpact.figures.models.curves", scripts=[script]))
    assert {"microimpact.mplstyle", "style.py", "draw_figures.py", "tables.py"} <= found
    assert "py.typed" not in found
    assert "estimation.py" not in found


def test_scripts_are_read_for_imports(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(
        "import numpy\n"
        "def late():\n"
        "    from microimpact.model.empirical import equations\n"
        "    import microimpact.core.tables as t\n"
    )
    assert imports_of(script) == [
        "microimpact.core.tables",
        "microimpact.model.empirical",
        "microimpact.model.empirical.equations",
    ]


def test_a_digest_tells_content_and_names_and_nothing_else(tmp_path):
    def digest_of(folder, **texts):
        (tmp_path / folder).mkdir()
        paths = [tmp_path / folder / name for name in texts]
        for path, text in zip(paths, texts.values(), strict=True):
            path.write_text(text)
        return digest_of_files(paths, tmp_path / folder)

    first = digest_of("first", a="1", b="2")
    assert digest_of("later and elsewhere", b="2", a="1") == first
    others = {"text": {"a": "1", "b": "3"}, "name": {"a": "1", "c": "2"}, "fewer": {"a": "1"}}
    others["exchanged"] = {"a": "2", "b": "1"}
    found = {first, *(digest_of(name, **texts) for name, texts in others.items())}
    assert len(found) == 1 + len(others)
    a, b = tmp_path / "first/a", tmp_path / "first/b"
    assert digest_of_files([b, a, a], tmp_path / "first") == first


def test_an_unknown_module_is_refused():
    with pytest.raises(ModuleNotFoundError, match=r"microimpact\.studies\.nothing"):
        closure(["microimpact.studies.nothing"])
