"""What `look_up` and `weigh` mean in compiled code: instructions of x86, or of any processor."""

from collections.abc import Callable
from typing import Any, NamedTuple

from llvmlite import ir
from numba.core.typing.templates import AbstractTemplate, infer_global, signature
from numba.extending import lower_builtin

from simd_lanes.compiled import INTS, WordsType, call_intrinsic, in_every_lane
from simd_lanes.constants import ConstantType, compile_for
from simd_lanes.lanes import LANES, ByteTable, ByteWeights, look_up, weigh

_I8, _I16, _I32 = (ir.IntType(bits) for bits in (8, 16, 32))
_BYTES = ir.VectorType(_I8, 4 * LANES)


class Instructions(NamedTuple):
    """Instructions of x86 on registers of so many bytes, by the names that LLVM has for them."""

    feature: str
    register: int
    look_up: str
    sum_products: str
    sum_pairs: str


X86 = (
    Instructions(
        '+avx512bw',
        64,
        'llvm.x86.avx512.pshuf.b.512',
        'llvm.x86.avx512.pmaddubs.w.512',
        'llvm.x86.avx512.pmaddw.d.512',
    ),
    Instructions(
        '+avx2',
        32,
        'llvm.x86.avx2.pshuf.b',
        'llvm.x86.avx2.pmadd.ub.sw',
        'llvm.x86.avx2.pmadd.wd',
    ),
    Instructions(
        '+ssse3',
        16,
        'llvm.x86.ssse3.pshuf.b.128',
        'llvm.x86.ssse3.pmadd.ub.sw.128',
        'llvm.x86.sse2.pmadd.wd',
    ),
)
SUM_FOUR_FEATURE, SUM_FOUR = '+avx512vnni', 'llvm.x86.avx512.vpdpbusd.512'


def features(context: Any) -> set[str]:
    """Return what the processor that code is made for can do, in LLVM's words, as ``+avx2``."""
    return set(context.codegen().magic_tuple()[2].split(','))


def _instructions(context):
    known = features(context)
    return next((each for each in X86 if each.feature in known), None)


def _chosen(builder, a, b, numbers):
    return builder.shuffle_vector(a, b, ir.Constant(ir.VectorType(_I32, len(numbers)), numbers))


def _by_register(builder, register, given, compute):
    """Return what is computed from a vector of bytes, a register at a time."""
    count = given.type.count
    if count == register:
        return compute(given)
    low, high = (
        _by_register(
            builder,
            register,
            _chosen(builder, given, given, list(range(first, first + count // 2))),
            compute,
        )
        for first in (0, count // 2)
    )
    return _chosen(builder, low, high, list(range(2 * low.type.count)))


def _look_up(context, builder, table, words):
    given = builder.bitcast(words, _BYTES)
    instructions = _instructions(context)
    if instructions:
        kind = ir.VectorType(_I8, instructions.register)
        values = ir.Constant(kind, table.values * (kind.count // len(table.values)))
        found = _by_register(
            builder,
            kind.count,
            given,
            lambda part: call_intrinsic(builder, instructions.look_up, kind, values, part),
        )
    else:
        values = ir.Constant(ir.VectorType(_I8, len(table.values)), table.values)
        found = ir.Constant(_BYTES, ir.Undefined)
        for i in range(_BYTES.count):
            value = builder.extract_element(values, builder.extract_element(given, _I32(i)))
            found = builder.insert_element(found, value, _I32(i))
    return builder.bitcast(found, INTS)


def _weigh(context, builder, weights, words):
    offset = in_every_lane(weights.offset)
    if SUM_FOUR_FEATURE in features(context):
        packed = int.from_bytes(bytes(value & 0xFF for value in weights.values), 'little')
        return call_intrinsic(builder, SUM_FOUR, INTS, offset, words, in_every_lane(packed))
    instructions = _instructions(context)
    if instructions:
        register = instructions.register
        factors = ir.Constant(ir.VectorType(_I8, register), weights.values * (register // 4))
        pairs, sums = (
            ir.VectorType(_I16, register // 2),
            ir.VectorType(_I32, register // 4),
        )
        ones = ir.Constant(pairs, [1] * pairs.count)
        total = _by_register(
            builder,
            register,
            builder.bitcast(words, _BYTES),
            lambda part: call_intrinsic(
                builder,
                instructions.sum_pairs,
                sums,
                call_intrinsic(builder, instructions.sum_products, pairs, part, factors),
                ones,
            ),
        )
        return builder.add(total, offset)
    total = offset
    for i, weight in enumerate(weights.values):
        shifted = builder.lshr(words, in_every_lane(8 * i))
        byte = builder.and_(shifted, in_every_lane(0xFF))
        total = builder.add(total, builder.mul(byte, in_every_lane(weight)))
    return total


def _define(
    function: Callable[..., Any], kind: type, generate: Callable[[Any, Any, Any, Any], Any]
) -> None:
    """Say what calling a function of a constant of that kind and of `Words` means."""
    compile_for(kind)

    def generic(self, arguments, keywords):
        if len(arguments) == 2 and isinstance(getattr(arguments[0], 'value', None), kind):
            return signature(arguments[1], *arguments)
        return None

    infer_global(function)(type('Template', (AbstractTemplate,), {'generic': generic}))

    @lower_builtin(function, ConstantType, WordsType)
    def lower(context, builder, sig, values):
        return generate(context, builder, sig.args[0].value, values[1])


_define(look_up, ByteTable, _look_up)
_define(weigh, ByteWeights, _weigh)
