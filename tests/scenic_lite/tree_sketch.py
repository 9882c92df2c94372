"""Trees in one line, for tests: Scenic's nodes in brackets, Python's as Python would write them."""

from __future__ import annotations

import ast

from scenic_lite.syntax import nodes
from scenic_lite.syntax.parser import parse


def sketch(node: object) -> str:
    """`(distance a b)`, `Ball<at x, with 'y' 3>`, `Ball<at x>?(at Ball x)` where the instance is not certain."""
    if isinstance(node, list):
        return "[" + " ".join(map(sketch, node)) + "]"
    if isinstance(node, nodes.New):
        text = sketch(node.cls) + "<" + ", ".join(map(sketch, node.specifiers)) + ">"
        return text if node.certain else f"{text}?{sketch(node.operator) if node.operator else 'name'}"
    if isinstance(node, nodes.Specifier):
        return " ".join([node.name, *map(sketch, node.arguments)])
    if isinstance(node, nodes.Operator):
        return "(" + " ".join([node.name, *map(sketch, node.operands)]) + ")"
    if isinstance(node, ast.expr) and not any(isinstance(each, ADDED) for each in ast.walk(node)):
        return ast.unparse(node)
    if isinstance(node, ast.BinOp | ast.UnaryOp | ast.BoolOp | ast.Compare | ast.IfExp | ast.Call):
        return "(" + " ".join(_parts(node)) + ")"
    if isinstance(node, ast.AST):
        fields = (getattr(node, name) for name in node._fields if name not in ("ctx", "type_comment", "kind"))
        return " ".join([type(node).__name__, *map(sketch, fields)])
    return "-" if node is None else repr(node)


ADDED = (nodes.Expression, nodes.Statement)
SIGNS = {
    ast.Add: "+",
    ast.Sub: "-",
    ast.Mult: "*",
    ast.Div: "/",
    ast.Pow: "**",
    ast.MatMult: "@",
    ast.Lt: "<",
    ast.Gt: ">",
    ast.In: "in",
    ast.NotIn: "not in",
    ast.And: "and",
    ast.Or: "or",
    ast.Not: "not",
    ast.USub: "-",
}


def _parts(node: ast.expr) -> list[str]:
    """Return the sign of an operation, then its operands."""
    if isinstance(node, ast.BinOp):
        return [SIGNS[type(node.op)], sketch(node.left), sketch(node.right)]
    if isinstance(node, ast.UnaryOp):
        return [SIGNS[type(node.op)], sketch(node.operand)]
    if isinstance(node, ast.BoolOp):
        return [SIGNS[type(node.op)], *map(sketch, node.values)]
    if isinstance(node, ast.Compare):
        return [SIGNS[type(node.ops[0])], sketch(node.left), *map(sketch, node.comparators)]
    if isinstance(node, ast.IfExp):
        return ["if", sketch(node.test), sketch(node.body), sketch(node.orelse)]
    assert isinstance(node, ast.Call)
    return [sketch(node.func), *map(sketch, node.args), *(f"{k.arg}={sketch(k.value)}" for k in node.keywords)]


def statements(text: str, dialect: int = 2) -> list[ast.stmt]:
    """Return the statements of a program."""
    return parse(text, "p.scenic", dialect).body


def value(text: str, dialect: int = 3) -> str:
    """Return the sketch of one expression."""
    (statement,) = statements(text, dialect)
    assert isinstance(statement, ast.Expr)
    return sketch(statement.value)
