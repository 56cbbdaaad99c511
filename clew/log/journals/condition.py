"""An expression over the names of a core's state, as `epoch > 20000 and not leads`. Nothing of Python is run.

Rule 1: there are names, numbers, texts, `True`, `False`, `None`, `and`, `or`, `not`, comparisons, `in` with a
        list in brackets, and the four kinds of arithmetic. Anything else is refused before the first look,
        and so is an expression without a name: it is always true, or never.
Rule 2: None is what is not there. It is equal to None alone, less or greater than nothing, and a sum with it
        is None. So is a division by 0.
"""

import ast
import operator
from collections.abc import Callable, Mapping
from typing import Any

from protocol.errors import UsageError
from protocol.files.names import did_you_mean

LENGTH_MAX = 200  # characters: so that its depth is bounded, too

COMPARISONS: dict[type[ast.cmpop], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.In: lambda one, others: one in others,
    ast.NotIn: lambda one, others: one not in others,
}
ARITHMETIC: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
}
SIGNS: dict[type[ast.unaryop], ast.operator] = {ast.UAdd: ast.Add(), ast.USub: ast.Sub()}
EQUALITIES = (ast.Eq, ast.NotEq, ast.In, ast.NotIn)


class Condition:
    """An expression that has been read."""

    def __init__(self, text: str, names: tuple[str, ...]) -> None:
        """Read an expression over these names.

        Raises:
            UsageError: it is none, or it has another name.
        """
        self.text = text
        if len(text) > LENGTH_MAX:
            raise UsageError(f"an expression may have {LENGTH_MAX} characters, not {len(text)}")
        try:
            self._tree = ast.parse(text.strip(), mode="eval").body
        except (SyntaxError, ValueError, MemoryError, RecursionError) as error:
            raise UsageError(f"not an expression: {text!r}; {_known(names)}") from error
        self._check(self._tree, names)
        if not any(isinstance(node, ast.Name) for node in ast.walk(self._tree)):
            raise UsageError(f"{text!r} names nothing of the state; {_known(names)}")

    def holds(self, values: Mapping[str, Any]) -> bool:
        """Whether it is true of these values, which have all the names.

        Raises:
            UsageError: it compares or adds what cannot be.
        """
        return bool(self._value(self._tree, values))

    def _check(self, node: ast.expr, names: tuple[str, ...]) -> None:
        """Rule 1."""
        match node:
            case ast.Name(id=name):
                if name not in names:
                    near = did_you_mean(name, names)
                    raise UsageError(f"there is no name {name!r}{near}; {_known(names)}")
                return
            case ast.Constant(value=bool() | int() | float() | str() | None):
                return
            case ast.BoolOp(values=parts) | ast.Tuple(elts=parts) | ast.List(elts=parts):
                pass
            case ast.UnaryOp(op=ast.Not() | ast.USub() | ast.UAdd(), operand=part):
                parts = [part]
            case ast.BinOp(left=left, op=op, right=right) if type(op) in ARITHMETIC:
                parts = [left, right]
            case ast.Compare(left=left, ops=ops, comparators=others) if all(
                isinstance(other, ast.Tuple | ast.List) == isinstance(op, ast.In | ast.NotIn)
                for op, other in zip(ops, others, strict=True)
            ) and all(type(op) in COMPARISONS for op in ops):
                parts = [left, *others]
            case _:
                said = ast.unparse(node)
                raise UsageError(f"{said!r} cannot stand in an expression; {_known(names)}")
        for part in parts:
            self._check(part, names)

    def _value(self, node: ast.expr, values: Mapping[str, Any]) -> Any:  # noqa: ANN401 - of any value
        match node:
            case ast.Name(id=name):
                return values[name]
            case ast.Constant(value=value):
                return value
            case ast.Tuple(elts=parts) | ast.List(elts=parts):
                return [self._value(part, values) for part in parts]
            case ast.BoolOp(op=op, values=parts):
                found = (self._value(part, values) for part in parts)
                return all(found) if isinstance(op, ast.And) else any(found)
            case ast.UnaryOp(op=op, operand=part):
                value = self._value(part, values)
                return not value if isinstance(op, ast.Not) else self._sum(SIGNS[type(op)], 0, value)
            case _:
                return self._of_two(node, values)

    def _of_two(self, node: ast.expr, values: Mapping[str, Any]) -> Any:  # noqa: ANN401 - of any value
        match node:
            case ast.BinOp(left=left, op=op, right=right):
                return self._sum(op, self._value(left, values), self._value(right, values))
            case ast.Compare(left=left, ops=ops, comparators=others):
                compared = [self._value(each, values) for each in (left, *others)]
                return all(
                    self._compares(op, one, other)
                    for op, one, other in zip(ops, compared, compared[1:], strict=False)
                )
            case _:
                raise AssertionError(ast.dump(node))  # `_check` has refused it

    def _compares(self, op: ast.cmpop, one: Any, other: Any) -> bool:  # noqa: ANN401 - of any value
        if not isinstance(op, EQUALITIES) and (one is None or other is None):
            return False  # rule 2
        try:
            return COMPARISONS[type(op)](one, other)
        except TypeError as error:
            raise UsageError(f"{self.text!r}: {one!r} cannot be compared with {other!r}") from error

    def _sum(self, op: ast.operator, one: Any, other: Any) -> Any:  # noqa: ANN401 - a number, or None
        if one is None or other is None:
            return None  # rule 2
        if not (isinstance(one, int | float) and isinstance(other, int | float)):
            raise UsageError(f"{self.text!r}: there is no arithmetic with {one!r} and {other!r}")
        if isinstance(op, ast.Div) and other == 0:
            return None
        return ARITHMETIC[type(op)](one, other)


def _known(names: tuple[str, ...]) -> str:
    return f"the names are {', '.join(names)}"
