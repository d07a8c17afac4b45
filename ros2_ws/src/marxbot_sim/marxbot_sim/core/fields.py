"""Fields that say what they are: one source of defaults, limits, units, help and checks."""

from __future__ import annotations

import dataclasses
import functools
import math
import reprlib
import sys
import types
import typing
from collections.abc import Iterable
from typing import Any


@dataclasses.dataclass(frozen=True)
class Option:
    """What is to be known of a field of a dataclass; see `described`.

    Attributes
    ----------
    name : str
    kind : type
        bool, int, float or str.
    optional : bool
        Whether it may be None.
    """

    name: str
    kind: type
    default: Any
    help: str
    unit: str = ''
    minimum: float = -math.inf
    maximum: float = math.inf
    above: float = -math.inf
    choices: tuple[str, ...] = ()
    optional: bool = False

    @property
    def expected(self) -> str:
        """What a value must be, such as 'a whole number from 1 to 10 (ticks)'."""
        if self.choices:
            return f'one of {", ".join(self.choices)}'
        if self.kind in (bool, str):
            return {bool: 'True or False', str: 'text'}[self.kind]
        unit = f' ({self.unit})' if self.unit else ''
        return f'{"a whole" if self.kind is int else "a"} number{self._range}{unit}'

    @property
    def _range(self) -> str:
        low, high = self.minimum, self.maximum
        if self.above > -math.inf:
            return f' above {self.above:.10g}' + (f' and up to {high:.10g}' * (high < math.inf))
        if low == -math.inf:
            return f' of at most {high:.10g}' * (high < math.inf)
        return (
            f' from {low:.10g} to {high:.10g}' if high < math.inf else f' of at least {low:.10g}'
        )

    def check(self, value: Any) -> Any:
        """Return the value in the option's type, an int where a float is due.

        Raises
        ------
        ValueError
            It is of another type or beyond its limits: one sentence that names the option, the
            value and what was expected.
        """
        if value is None and self.optional:
            return None
        if not self._allows(value):
            raise ValueError(f'{self.name} is {reprlib.repr(value)}, expected {self.expected}')
        return self.kind(value)

    def _allows(self, value: Any) -> bool:
        allowed: Any = (int, float) if self.kind is float else self.kind
        if not isinstance(value, allowed) or isinstance(value, bool) != (self.kind is bool):
            return False
        if self.kind in (int, float):
            within = self.minimum <= value <= self.maximum and self.above < value
            return within and abs(value) <= sys.float_info.max
        return not self.choices or value in self.choices


def described(
    default: Any,
    help: str,
    unit: str = '',
    minimum: float = -math.inf,
    maximum: float = math.inf,
    above: float = -math.inf,
    choices: Iterable[str] = (),
) -> Any:
    """Return a field of a dataclass that `options_of` and `check_fields` know.

    Parameters
    ----------
    default
        None where the field may be left open; its type then has None as well.
    help : str
        What it is, without its default, unit and limits.
    unit : str
    minimum, maximum : float
        Least and highest value.
    above : float
        What the value must exceed.
    choices : iterable of str
        What a text may be; any without them.
    """
    return dataclasses.field(
        default=default,
        metadata={
            'help': help,
            'unit': unit,
            'minimum': minimum,
            'maximum': maximum,
            'above': above,
            'choices': tuple(choices),
        },
    )


def same_as(option: Option) -> Any:
    """Return a field of a dataclass with the default and the description of an option."""
    facts = {name: getattr(option, name) for name in ('help', 'unit', 'minimum', 'maximum')}
    return described(option.default, **facts, above=option.above, choices=option.choices)


@functools.cache
def options_of(kind: type) -> dict[str, Option]:
    """Return the described fields of a dataclass by name, in their order."""
    hints = typing.get_type_hints(kind)
    options = {}
    for field in dataclasses.fields(kind):
        if field.metadata:
            hint = hints[field.name]
            optional = isinstance(hint, types.UnionType)
            hint = typing.get_args(hint)[0] if optional else hint
            options[field.name] = Option(
                field.name, hint, field.default, optional=optional, **field.metadata
            )
    return options


def check_fields(instance: Any) -> None:
    """Check each described field of a new dataclass and give it its type, see `Option.check`."""
    kind: Any = type(instance)
    for name, option in options_of(kind).items():
        object.__setattr__(instance, name, option.check(getattr(instance, name)))


def check_choice(name: str, value: Any, choices: Iterable[str]) -> None:
    """Raise ValueError, in one sentence, where a value is none of those there are."""
    known = list(choices)
    if value not in known:
        raise ValueError(f'{name} is {reprlib.repr(value)}, expected one of {", ".join(known)}')
