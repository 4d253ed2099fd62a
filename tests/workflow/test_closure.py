"""Import closures: which files an analysis depends on."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from tests.shared import ROOT
from workflow.scripts import digests

from study import analyses

sys.modules["digests"] = digests  # as scripts know it
from workflow.scripts import job  # noqa: E402
from workflow.scripts.closure import closure, source_files  # noqa: E402

SCRIPTS = ROOT / "workflow/scripts"


def names(files):
    return {Path(file).name for file in files}


def test_a_study_depends_on_what_it_imports_and_on_no_other():
    friction, trends = (
        closure([analyses.homes()[name]])
        for name in ("fig17_coulomb_friction", "fig14_restitution_trends")
    )
    assert {"study.tables", "study.analyses"} <= {*friction} & {*trends}
    assert "microimpact.model.rigid_body.algebra" in set(friction) - set(trends)
    assert "microimpact.model.empirical.equations" in set(trends) - set(friction)
    assert not any(name.startswith("study.figures") for name in friction)
    assert closure(["microimpact"]) == ["microimpact"]  # the root drags nothing in


def test_data_files_and_scripts_belong_to_a_figure():
    script = SCRIPTS / "draw_figures.py"
    found = names(source_files("study.analyses.fig14_restitution_trends.draw", scripts=[script]))
    assert {"microimpact.mplstyle", "style.py", "draw_figures.py", "tables.py"} <= found
    assert "digitised.py" in found  # the script alone imports it
    assert "py.typed" not in found
    assert "estimation.py" not in found


def test_digests_are_of_code_and_of_all_of_a_text(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    code, text = (
        "def f():\n    return 1\n",
        '"""Words."""\n# why\ndef f():\n\n    """Told."""\n    return 1\n',
    )

    def digest_of(folder, content, **kinds):
        file = tmp_path / folder / "a.py"
        file.parent.mkdir()
        file.write_text(content)
        files = {"code": [str(file)]} | {kind: [file] for kind in kinds}
        return repr(digests.of_files(file.parent, **files))

    same = {digest_of("plain", code), digest_of("commented", text)}
    assert len(same) == 1
    others = {digest_of("edited", code.replace("1", "2")), digest_of("shown", text, texts=True)}
    assert len(others | same) == 3
    # Kept for the next start.
    digests.keep()
    assert len(json.loads((tmp_path / digests.KEPT).read_text())) == 3


def test_a_job_is_refused_if_its_code_was_edited_since_the_run_began(tmp_path, monkeypatch):
    monkeypatch.setattr(job, "PROJECT", tmp_path)
    (tmp_path / "study.py").write_text("x = 1\n")
    recorded = dict(digests.of_files(tmp_path, [str(tmp_path / "study.py")]))
    (tmp_path / "study.py").write_text("x = 1  # one\n")
    job.require_recorded_code(recorded)
    (tmp_path / "study.py").write_text("x = 2\n")
    with pytest.raises(RuntimeError, match=r"edited while the run went on: study\.py"):
        job.require_recorded_code(recorded)
