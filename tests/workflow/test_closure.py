"""Import closures: which files an analysis depends on."""

from __future__ import annotations

from pathlib import Path

from tests.shared import ROOT
from workflow.scripts.closure import closure, digest_of_files, source_files

SCRIPTS = ROOT / "workflow/scripts"


def names(files):
    return {Path(file).name for file in files}


def test_a_study_depends_on_what_it_imports_and_on_no_other():
    friction, trends = (
        closure([f"study.studies.models.{name}"])
        for name in ("coulomb_friction", "restitution_trends")
    )
    assert {"study.tables", "study.studies.models"} <= {*friction} & {*trends}
    assert "microimpact.model.rigid_body.algebra" in set(friction) - set(trends)
    assert "microimpact.model.empirical.equations" in set(trends) - set(friction)
    assert not any(name.startswith("study.figures") for name in friction)
    assert closure(["microimpact"]) == ["microimpact"]  # the root drags nothing in


def test_data_files_and_scripts_belong_to_a_figure():
    script = SCRIPTS / "draw_figures.py"
    found = names(source_files("study.figures.models.curves", scripts=[script]))
    assert {"microimpact.mplstyle", "style.py", "draw_figures.py", "tables.py"} <= found
    assert "py.typed" not in found
    assert "estimation.py" not in found


def test_a_digest_is_of_contents_and_names_in_any_order(tmp_path):
    def digest_of(folder, texts):
        (tmp_path / folder).mkdir()
        for name, text in texts.items():
            (tmp_path / folder / name).write_text(text)
        return digest_of_files([tmp_path / folder / name for name in texts], tmp_path / folder)

    first = digest_of("first", {"a": "1", "b": "2"})
    assert digest_of("elsewhere", {"b": "2", "a": "1"}) == first
    changes = ({"a": "1", "b": "3"}, {"a": "1", "c": "2"}, {"a": "1"}, {"a": "2", "b": "1"})
    assert len({first, *(digest_of(f"{i}", texts) for i, texts in enumerate(changes))}) == 5
