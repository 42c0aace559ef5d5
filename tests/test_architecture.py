"""The floors of the package: a module imports only from its own room and the floors below, inside functions too."""

from __future__ import annotations

import ast
import functools
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "purcell_cli"

FLOORS = [
    ("errors", "frozen_dataclass", "user_cache", "wording"),
    ("processes", "kernel"),
    ("geometry",),
    ("mechanics", "environment"),
    ("lie_brackets", "motion"),
    ("gaits", "verification"),
    ("planner",),
    ("files", "query"),
    ("solution",),
    ("planning",),
    ("missions",),
    ("explanation",),
    ("pictures", "batch", "exports", "feedback"),
    ("cli",),
    ("__main__",),
]
"""Rooms by floor, from the bottom. Rooms of one floor do not import each other."""


def modules(package: Path) -> dict[str, Path]:
    """Return the files of a package by module name, the package's own being the empty one."""
    out = {}
    for path in sorted(package.rglob("*.py")):
        parts = path.relative_to(package).with_suffix("").parts
        out[".".join(part for part in parts if part != "__init__")] = path
    return out


def doors(package: Path) -> dict[str, str]:
    """Return the modules behind the names that the package loads when they are first used."""
    for node in ast.parse((package / "__init__.py").read_text(encoding="utf-8")).body:
        if isinstance(node, ast.Assign) and getattr(node.targets[0], "id", "") == "_HOMES":
            return ast.literal_eval(node.value)
    return {}


class _Imports(ast.NodeVisitor):
    """Collects what a module imports when it runs, as full names."""

    def __init__(self, package: str, inside: str) -> None:
        self.package, self.inside = package, inside
        self.names: list[str] = []

    def visit_If(self, node: ast.If) -> None:
        if ast.unparse(node.test) in {"TYPE_CHECKING", "typing.TYPE_CHECKING"}:
            for other in node.orelse:
                self.visit(other)
        else:
            self.generic_visit(node)

    def visit_Import(self, node: ast.Import) -> None:
        self.names += [alias.name for alias in node.names]

    def visit_ImportFrom(self, node: ast.ImportFrom) -> None:
        origin = node.module or ""
        if node.level:
            here = f"{self.package}.{self.inside}".strip(".").split(".")
            parts = here[: len(here) - node.level + 1]
            origin = ".".join([*parts, *([node.module] if node.module else [])])
        self.names += [f"{origin}.{alias.name}" for alias in node.names]


def imports(package: Path) -> dict[str, set[str]]:
    """Return which modules of a package each of its modules imports."""
    known, homes = modules(package), doors(package)
    out: dict[str, set[str]] = {}
    for module, path in known.items():
        inside = module if path.name == "__init__.py" else module.rpartition(".")[0]
        visitor = _Imports(package.name, inside)
        visitor.visit(ast.parse(path.read_text(encoding="utf-8")))
        out[module] = set()
        for name in visitor.names:
            if name.partition(".")[0] != package.name:
                continue
            target = name.partition(".")[2]
            target = homes.get(target, target)
            while target and target not in known:
                target = target.rpartition(".")[0]
            if target and target != module:
                out[module].add(target)
    return out


def height(module: str) -> int:
    """Return a module's floor; the package itself, which imports nothing until asked, is below all."""
    room = module.partition(".")[0]
    return next((k for k, rooms in enumerate(FLOORS) if room in rooms), -1)


def allowed(a: str, b: str) -> bool:
    """Return whether a module may import another: from its own room, or from a floor below."""
    return a.partition(".")[0] == b.partition(".")[0] or height(b) < height(a)


@functools.cache
def own_imports() -> dict[str, set[str]]:
    """Return what the modules of the package import; read once in a process."""
    return imports(PACKAGE)


def upward(graph: dict[str, set[str]]) -> list[str]:
    """Return the imports of a package that do not point down."""
    return [f"{a} imports {b}" for a in graph for b in sorted(graph[a]) if a and not allowed(a, b)]


def cycle(graph: dict[str, set[str]]) -> set[str]:
    """Return modules of a package that import one another in a ring, if there are any."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        return set(error.args[1])
    return set()


def test_every_module_has_a_floor_and_every_floor_a_module() -> None:
    found = {module.partition(".")[0] for module in modules(PACKAGE)} - {""}
    known = [room for rooms in FLOORS for room in rooms]
    assert found - set(known) == set(), "a new room needs a place in FLOORS"
    assert set(known) - found == set()
    assert len(known) == len(set(known))


def test_imports_point_down() -> None:
    graph = own_imports()
    assert upward(graph) == []
    assert cycle(graph) == set()
    assert "files.trajectory_formats" in graph["cli.plan"], "imports inside functions are seen"
    assert graph["geometry.se3"] == {"geometry.reproducible", "geometry.rotations", "kernel.poses"}


def test_every_room_says_what_it_is_for() -> None:
    for folder in {path.parent for path in PACKAGE.rglob("*.py")} - {PACKAGE}:
        text = ast.get_docstring(ast.parse((folder / "__init__.py").read_text(encoding="utf-8")))
        assert text is not None, folder
        assert 1 < len(text.splitlines()) <= 4, folder


def test_no_module_is_longer_than_can_be_read_at_once() -> None:
    assert [path.name for path in PACKAGE.rglob("*.py") if len(path.read_text("utf-8").splitlines()) > 350] == []


def test_the_certificate_uses_nothing_that_made_the_plan() -> None:
    graph = own_imports()
    used, todo = set(), {m for m in graph if m.startswith("verification")}
    while todo:
        module = todo.pop()
        used.add(module)
        todo |= graph[module] - used
    assert used & {"mechanics.lift", "kernel.flow", "solution"} == set()
    assert {module.partition(".")[0] for module in used} & {"planner", "gaits", "lie_brackets", "files"} == set()


def small_package(folder: Path, module: str, text: str) -> Path:
    """Write a package of a few modules, one of them with a text, and return its folder."""
    package = folder / "purcell_cli"
    texts = {
        "__init__": "_HOMES = {'plan': 'solution'}\n__version__ = '0'",
        "errors": "",
        "solution": "from purcell_cli.errors import PurcellError",
        "cli": "",
        "planner.__init__": "",
        "planner.finish": "",
        "planner.steps": "from purcell_cli.planner.finish import arrive",
        module: text,
    }
    for name, content in texts.items():
        path = package / (name.replace(".", "/") + ".py")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return package


@pytest.mark.parametrize(
    ("module", "text", "found"),
    [
        ("errors", "from purcell_cli.cli.app import main", ["errors imports cli"]),
        ("errors", "import purcell_cli.cli.app", ["errors imports cli"]),
        ("errors", "from purcell_cli import cli as face", ["errors imports cli"]),
        ("errors", "from .cli import main", ["errors imports cli"]),
        ("errors", "from . import cli", ["errors imports cli"]),
        ("errors", "def late():\n    from purcell_cli.cli.app import main", ["errors imports cli"]),
        ("errors", "from purcell_cli import plan", ["errors imports solution"]),
        ("planner.finish", "from ..solution import plan", ["planner.finish imports solution"]),
        ("errors", "if TYPE_CHECKING:\n    from purcell_cli.cli.app import main", []),
        (
            "errors",
            "if TYPE_CHECKING:\n    pass\nelse:\n    from purcell_cli.cli.app import main",
            ["errors imports cli"],
        ),
        ("errors", "import numpy\nfrom purcell_cli import __version__", []),
        ("cli", "from purcell_cli import errors, plan\nfrom .planner import steps", []),
    ],
)
def test_an_upward_import_is_found(tmp_path: Path, module: str, text: str, found: list[str]) -> None:
    assert upward(imports(small_package(tmp_path, module, text))) == found


def test_a_ring_of_imports_is_found(tmp_path: Path) -> None:
    ring = imports(small_package(tmp_path, "planner.finish", "from . import steps"))
    assert upward(ring) == []
    assert cycle(ring) == {"planner.finish", "planner.steps"}
    assert cycle(imports(small_package(tmp_path, "planner.finish", ""))) == set()
