"""What importing loads, and where compiled code is kept."""

import ast
import os
import sys
from pathlib import Path

import pytest
from tests.docs.blocks import blocks
from tests.shared import ROOT, execute

SOURCE = ROOT / "src/microimpact"
WATCHED = (
    *("numpy", "numba", "llvmlite", "pandas", "scipy", "matplotlib", "pydantic", "sympy", "pint"),
    *("yaml", "emcee"),
    *(f"scipy.{part}" for part in ("special", "optimize", "stats", "interpolate", "linalg")),
    "scipy.ndimage",
)

IMPACT = """
from microimpact import Contact, Material, simulate
steel = Material(name="steel", youngs_modulus=193e9, poissons_ratio=0.28, density=8000.0)
contact = Contact(particle=steel, surface=steel, diameter=62e-6, work_of_adhesion=0.5)
print(float(simulate(contact, 1.0).coefficient_of_restitution))
"""


def run(code, **environment):
    return execute(sys.executable, "-c", code, env={**os.environ, **environment}).stdout


def loaded_after(*steps):
    """Return what is loaded after each of several steps of one program."""
    told = "print('LOADED', *[n for n in {watched!r} if n in sys.modules])"
    code = [line for step in steps for line in (step, told.format(watched=WATCHED))]
    lines = run("\n".join(["import sys", *code])).splitlines()
    return [set(line.split()[1:]) for line in lines if line.startswith("LOADED")]


def test_what_is_not_used_is_not_loaded():
    modules = ("dynamics.kernel", "passes", "dynamics.impact")
    help_ = (
        "from microimpact.cli import main\n"
        'for arguments in ["--help"], ["simulate", "--help"], ["capture", "-h"]:\n'
        "    sys.argv[1:] = arguments\n"
        "    try:\n        main()\n    except SystemExit:\n        pass"
    )
    package, told, imported, impact = loaded_after(
        "import microimpact",
        help_,
        "import " + ", ".join(f"microimpact.model.{module}" for module in modules),
        IMPACT,
    )
    assert package == set()
    assert told <= {"numpy", "yaml"}
    # The compiler waits for the first call; Numba itself loads parts of SciPy.
    assert imported <= {"numpy", "yaml"}
    assert impact - {"numpy", "yaml", "scipy", "scipy.linalg"} == {"numba", "llvmlite"}


def test_the_parameters_of_all_studies_load_nothing_heavy():
    # All that the workflow reads when it starts.
    (found,) = loaded_after(
        "from study import analyses\n"
        "from study.report.site import record\n"
        "from study.run import config\n"
        "for name in analyses.homes():\n    analyses.analysis(name)"
    )
    assert "pandas" in found
    assert not found - {"numpy", "scipy", "pandas", "pydantic", "yaml"}


# Compiled code

TINY = """
from microimpact.core.compiled import jit

@jit()
def twice(x):
    return 2.0 * x
"""
CALL = (
    "import tiny\nfirst = tiny.twice\nvalue = first(2.0)\nassert first(1.0) == tiny.twice(1.0)\n"
    "print(value, tiny.twice.stats.cache_path, len(tiny.twice.stats.cache_hits))"
)


@pytest.fixture
def call(tmp_path):
    """Return a function that calls a compiled function in a new process."""
    (tmp_path / "tiny.py").write_text(TINY)

    def called(**environment):
        return run(CALL, PYTHONPATH=str(tmp_path), **environment).split()

    return called


USERS_CACHE = {"NUMBA_CACHE_LOCATOR_CLASSES": "UserWideCacheLocator", "NUMBA_CACHE_DIR": ""}


def test_compiled_code_is_kept_where_it_can_be(call, tmp_path):
    value, where, hits = call(NUMBA_CACHE_DIR=str(tmp_path / "kept"))
    assert (value, hits) == ("4.0", "0")
    assert where.startswith(str(tmp_path / "kept"))
    # Another process compiles nothing.
    assert call(NUMBA_CACHE_DIR=str(tmp_path / "kept")) == ["4.0", where, "1"]
    # As where the source's folder cannot be written (which does not hinder a superuser).
    places = {"HOME": str(tmp_path), "XDG_CACHE_HOME": str(tmp_path / "cache")}
    assert Path(call(**USERS_CACHE, **places)[1]).is_relative_to(tmp_path / "cache")
    # Nowhere to keep it is no error.
    blocked = tmp_path / "home"
    blocked.write_text("not a folder")
    places = {"HOME": str(blocked), "XDG_CACHE_HOME": str(blocked / "cache")}
    assert call(**USERS_CACHE, **places) == ["4.0", "None", "0"]


def test_functions_of_the_model_are_kept():
    code = """
from importlib import import_module
from numba.core.dispatcher import Dispatcher
from microimpact.core.compiled import _Uncompiled

for name in ("dynamics.kernel", "passes", "dynamics.tangential"):
    module = vars(import_module(f"microimpact.model.{name}"))
    next(f for f in module.values() if isinstance(f, _Uncompiled)).compiled()
    found = [f for f in module.values() if isinstance(f, Dispatcher)]
    kept = [f for f in found if not f.targetoptions.get("inline")]
    print(len(kept) >= 1, all(f.stats.cache_path for f in kept))
"""
    assert run(code).split() == ["True"] * 6


def loaded(node):
    return {n.id for n in ast.walk(node) if isinstance(n, ast.Name)}


def foreign(tree):
    """Names in a module whose values other modules of the package decide."""
    names = {
        alias.asname or alias.name.partition(".")[0]
        for node in ast.walk(tree)
        if isinstance(node, ast.ImportFrom | ast.Import)
        for alias in node.names
        if "microimpact" in (getattr(node, "module", None) or alias.name)
    }
    for node in tree.body:
        if isinstance(node, ast.Assign) and names & loaded(node.value):
            names |= set().union(*map(loaded, node.targets))
    return names


def test_compiled_code_rests_on_its_own_file_alone():
    """Numba's cache would keep functions, and constants, as they stood in another file."""
    users = [
        path for path in SOURCE.rglob("*.py") if "core.compiled import jit" in path.read_text()
    ]
    assert {path.stem for path in users} >= {"kernel", "passes", "tangential"}
    for path in users:
        tree = ast.parse(path.read_text())
        strangers = foreign(tree)
        functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
        for function in functions:
            if any("jit" in ast.unparse(decorator) for decorator in function.decorator_list):
                used = set().union(*map(loaded, function.body)) & strangers
                assert not used, f"{path.name}: {function.name} uses {used} of another file"


# The physics alone

ALONE = """
import sys
from importlib.metadata import distribution, packages_distributions, requires
import re

def needed(name, found):
    for line in requires(name) or ():
        other = re.match(r"[\\w.-]+", line)[0].lower().replace("_", "-")
        if "extra ==" not in line and other not in found:
            found.add(other)
            try:
                needed(other, found)
            except ImportError:
                found.discard(other)  # of another platform or Python
    return found

core = needed("microimpact", {"microimpact"})
others = {
    module
    for module, owners in packages_distributions().items()
    if not core & {owner.lower().replace("_", "-") for owner in owners}
}

class Absent:
    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] in others:
            raise ModuleNotFoundError(f"No module named {name!r}", name=name)

sys.meta_path.insert(0, Absent())
assert {"pandas", "matplotlib", "snakemake", "pydantic", "rich", "emcee"} <= others
assert not {"numpy", "scipy", "numba", "click"} & others
"""


def test_the_physics_needs_none_of_the_studys_packages(tmp_path):
    data, drawn = tmp_path / "mine.csv", tmp_path / "drawn.json"
    rows = ("0.2,0.1", "0.25,0.4", "0.3,0.5", "0.5,0.6", "1,0.7", "2,0.7", "3,0.7")
    data.write_text("\n".join(["v,e", *rows]), encoding="utf-8")
    pair = ["--particle", "stainless-steel-316", "--surface", "silicon"]
    targets = ["--restitution", "0.7", "--at-speed", "1.66", "--capture-velocity", "0.18"]
    commands = [
        ["simulate", *pair, "--speed", "1"],
        ["capture", *pair],
        ["materials"],
        ["export", *pair, "-o", str(tmp_path / "law")],
        ["fit", str(data)],
        ["calibrate", *pair, *targets, "-o", str(drawn)],
        ["simulate", "--contact", str(drawn), "--speed", "1", "--json"],
    ]
    lacking = [
        ["fit", str(data), "--report", str(tmp_path / "report")],
        ["calibrate", str(data), *pair, "--sigma", "0.02"],
        ["compare", "x", "x"],
    ]
    code = (
        f"{ALONE}{IMPACT}\n"
        "from microimpact import fit_restitution, tabulate, trajectory\n"
        "from microimpact.cli import main\n"
        f"for sys.argv[1:] in {commands!r}:\n    main()\n"
        f"for sys.argv[1:] in {lacking!r}:\n"
        "    try:\n        main()\n    except SystemExit as end:\n"
        "        print('ended', end.code)\n"
    )
    done = execute(sys.executable, "-c", code)
    assert done.stdout.rstrip().endswith("ended 2\nended 2\nended 2")
    assert "needs emcee: pip install '.[calibrate]'" in done.stderr
    assert "needs jinja2: pip install '.[report]'" in done.stderr


def test_the_page_on_python_runs_with_the_physics_alone(tmp_path):
    code = [block.text for block in blocks("python") if block.page == "docs/python.md"]
    examples = (path.read_text() for path in sorted((ROOT / "docs/examples").glob("*.py")))
    code += [text for text in examples if "matplotlib" not in text]
    run(f"import os\nos.chdir({str(tmp_path)!r})\n{ALONE}{chr(10).join(code)}")
