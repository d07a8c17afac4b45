"""Objects that kernels are compiled for: what their attributes are is known to the compiler."""

from __future__ import annotations

import functools
import hashlib
from collections.abc import Callable
from typing import Any

from numba import typeof, types
from numba.core.imputils import lower_constant, lower_getattr_generic
from numba.core.typing.templates import AttributeTemplate, infer_getattr
from numba.extending import NativeValue, models, register_model, typeof_impl, unbox


class ConstantType(types.Type):
    """The type of one object: another object is of another type.

    Parameters
    ----------
    value : object
        Immutable.
    text : str
        Equal for equal objects, in all processes: caches on disk know the type by it.
    """

    def __init__(self, value: Any, text: str) -> None:
        self.value = value
        digest = hashlib.sha256(text.encode()).hexdigest()
        super().__init__(name=f'{type(value).__name__}_{digest[:16]}')


register_model(ConstantType)(models.OpaqueModel)


def compile_for(kind: type, text: Callable[[Any], str] = repr) -> None:
    """Let kernels take objects of a class, and be compiled anew for each that differs.

    Their attributes, numbers, tuples of numbers and other such objects, are constants of the
    compiled code, so that sizes unroll loops and offsets cost nothing.

    Parameters
    ----------
    kind : type
        A frozen dataclass.
    text : callable
        What tells its objects apart.
    """
    known = functools.lru_cache(lambda value: ConstantType(value, text(value)))
    typeof_impl.register(kind)(lambda value, _: known(value))


@unbox(ConstantType)
def _unbox(kind, value, c):
    return NativeValue(c.context.get_dummy_value())


@lower_constant(ConstantType)
def _lower(context, builder, kind, value):
    return context.get_dummy_value()


@infer_getattr
class _Attributes(AttributeTemplate):
    key = ConstantType

    def generic_resolve(self, kind, name):  # type: ignore[override]
        return typeof(getattr(kind.value, name))


@lower_getattr_generic(ConstantType)
def _get_attribute(context, builder, kind, value, name):
    attribute = getattr(kind.value, name)
    return context.get_constant_generic(builder, typeof(attribute), attribute)
