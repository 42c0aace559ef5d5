"""Every numeric constant of a module says what it is: a line of text under it, or a comment beside it."""

from __future__ import annotations

import ast
import io
import tokenize
from pathlib import Path

import pytest

PACKAGE = Path(__file__).resolve().parent.parent / "purcell_cli"

_PLAIN_CALLS = {"np", "math", "tuple", "float", "int", "range"}
"""What makes numbers of numbers; other calls inside a call, such as a document's fields, have words of their own."""


def _caller(call: ast.Call) -> str:
    """Return the first name of what is called."""
    function = call.func
    while isinstance(function, ast.Attribute | ast.Call):
        function = function.value if isinstance(function, ast.Attribute) else function.func
    return function.id if isinstance(function, ast.Name) else ""


def is_numeric(value: ast.expr, inside_call: bool = False) -> bool:
    """Return whether a value is a number, or is made of numbers that stand there."""
    match value:
        case ast.Constant():
            return isinstance(value.value, int | float | complex) and not isinstance(value.value, bool)
        case ast.UnaryOp():
            return is_numeric(value.operand, inside_call)
        case ast.BinOp():
            return is_numeric(value.left, inside_call) or is_numeric(value.right, inside_call)
        case ast.Tuple() | ast.List() | ast.Set():
            return any(is_numeric(item, inside_call) for item in value.elts)
        case ast.Dict():
            return any(is_numeric(item, inside_call) for item in value.values)
        case ast.GeneratorExp() | ast.ListComp():
            return is_numeric(value.elt, inside_call)
        case ast.Attribute() | ast.Subscript():
            return is_numeric(value.value, inside_call)
        case ast.Call():
            if inside_call and _caller(value) not in _PLAIN_CALLS:
                return False
            parts = [*value.args, *(keyword.value for keyword in value.keywords)]
            return any(is_numeric(part, inside_call=True) for part in parts)
    return False


def unexplained(text: str) -> list[str]:
    """Return the numeric constants of a module's text that have no words under or beside them."""
    tree = ast.parse(text)
    commented = {
        token.start[0]
        for token in tokenize.generate_tokens(io.StringIO(text).readline)
        if token.type == tokenize.COMMENT and not token.string.startswith(("# noqa", "# type:"))
    }
    out = []
    for node, after in zip(tree.body, [*tree.body[1:], None], strict=True):
        if isinstance(node, ast.Assign):
            targets = node.targets
        elif isinstance(node, ast.AnnAssign):
            targets = [node.target]
        else:
            continue
        names = [name.id for target in targets for name in ast.walk(target) if isinstance(name, ast.Name)]
        if node.value is None or not any(name.isupper() for name in names) or not is_numeric(node.value):
            continue
        described = isinstance(after, ast.Expr) and isinstance(getattr(after.value, "value", None), str)
        if not described and not commented & set(range(node.lineno, (node.end_lineno or node.lineno) + 1)):
            out.append(", ".join(names))
    return out


def test_every_numeric_constant_says_what_it_is() -> None:
    paths = sorted(PACKAGE.rglob("*.py"))
    assert len(paths) > 100
    found = [f"{path.relative_to(PACKAGE)}: {name}" for path in paths for name in unexplained(path.read_text("utf-8"))]
    assert found == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("A = 1", ["A"]),
        ('A = 1\n"""A length [m]."""', []),
        ("A = 1  # a length [m]", []),
        ("A = 1  # noqa: S101", ["A"]),
        ('A = 1\nB = 2\n"""A length [m]."""', ["A"]),
        ("A, _B = 1e-3, -2.0", ["A, _B"]),
        ("_A: float = 2.0**-10", ["_A"]),
        ("A = np.array([0.0, 1.0])[:, None]", ["A"]),
        ("A = Accuracy(stages=4)", ["A"]),
        ("A = tuple(range(6))", ["A"]),
        ("A = {'k': 1.0}", ["A"]),
        ("A = 1 << 20\n\n\ndef f() -> None:\n    'text'", ["A"]),
        ("A = 'text'\nB = True\nC = other()", []),
        ("A = Record({'k': Field(Number(above=0.0), 'words')})", []),
        ("word = 1", []),
    ],
)
def test_a_constant_without_words_is_found(text: str, found: list[str]) -> None:
    assert unexplained(text) == found
