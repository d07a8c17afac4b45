"""What the names of `lanes` mean in compiled code: their Numba types and LLVM instructions."""

import itertools
import operator

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.typing.templates import ConcreteTemplate, infer_global, signature
from numba.extending import lower_builtin, models, register_model

from simd_lanes import lanes as plain
from simd_lanes.lanes import HALF, LANES

_I32 = ir.IntType(32)
_FLOATS = ir.VectorType(ir.FloatType(), LANES)
INTS = ir.VectorType(_I32, LANES)
_BITS = ir.VectorType(ir.IntType(1), LANES)


class LanesType(types.Type):
    """The type of a `Lanes`."""

    def __init__(self):
        super().__init__(name='Lanes')


class WordsType(types.Type):
    """The type of `Words`."""

    def __init__(self):
        super().__init__(name='Words')


class MaskType(types.Type):
    """The type of a `Mask`."""

    def __init__(self):
        super().__init__(name='Mask')


@register_model(LanesType)
class _LanesModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _FLOATS)


@register_model(WordsType)
class _WordsModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, INTS)


@register_model(MaskType)
class _MaskModel(models.PrimitiveModel):
    def __init__(self, manager, kind):
        super().__init__(manager, kind, _BITS)


_lanes = LanesType()
_words = WordsType()
_mask = MaskType()
_scalars = {_lanes: types.float32, _words: types.int64}


def _splat(builder, scalar):
    if scalar.type == ir.IntType(64):
        scalar = builder.trunc(scalar, _I32)
    vector = builder.insert_element(
        ir.Constant(ir.VectorType(scalar.type, LANES), ir.Undefined), scalar, _I32(0)
    )
    return builder.shuffle_vector(vector, vector, in_every_lane(0))


def _declare(function, cases):
    """Say with which types `function` may be called."""
    infer_global(function)(type('Template', (ConcreteTemplate,), {'cases': cases}))


def _define(function, result, arguments, generate):
    """Say what calling `function` means in compiled code.

    Parameters
    ----------
    function : callable
        The plain Python function or operator that kernels call.
    result, arguments : Numba type, sequence of Numba types
        A scalar may stand for any of the vectors, but not for all.
    generate : callable
        ``generate(builder, *values)`` emits the instructions and returns the result; scalars
        arrive in all lanes.
    """
    kinds = [(kind, _scalars[kind]) if kind in _scalars else (kind,) for kind in arguments]
    scalars = set(_scalars.values())
    cases = [case for case in itertools.product(*kinds) if not scalars.issuperset(case)]
    _declare(function, [signature(result, *case) for case in cases])

    def lower(context, builder, sig, values):
        return generate(
            builder,
            *(
                _splat(builder, v) if kind in scalars else v
                for v, kind in zip(values, sig.args, strict=True)
            ),
        )

    for case in cases:
        lower_builtin(function, *case)(lower)


def call_intrinsic(builder, name, result, *values):
    """Call an LLVM intrinsic of that name and result type."""
    kind = ir.FunctionType(result, [value.type for value in values])
    return builder.call(cgutils.get_or_insert_function(builder.module, kind, name), values)


def _call(name, result):
    """Return a generator that calls an LLVM intrinsic."""
    return lambda builder, *values: call_intrinsic(builder, name, result, *values)


def _on_bits(combine):
    """Return a generator that computes on the bit patterns of its vectors."""

    def generate(builder, *values):
        integers = [builder.bitcast(value, INTS) for value in values]
        return builder.bitcast(combine(builder, *integers), _FLOATS)

    return generate


def _extremum(symbol):
    return lambda builder, a, b: builder.select(builder.fcmp_ordered(symbol, a, b), a, b)


def _compare(symbol):
    return lambda builder, a, b: builder.fcmp_ordered(symbol, a, b)


def in_every_lane(value):
    """Return that 32-bit integer in each lane, as a constant."""
    return ir.Constant(INTS, [value] * LANES)


for _operator, _instruction in {
    'add': 'fadd',
    'sub': 'fsub',
    'mul': 'fmul',
    'truediv': 'fdiv',
}.items():
    _define(
        getattr(operator, _operator),
        _lanes,
        (_lanes, _lanes),
        lambda builder, a, b, instruction=_instruction: getattr(builder, instruction)(a, b),
    )
for _operator, _instruction in {
    'add': 'add',
    'mul': 'mul',
    'xor': 'xor',
    'and_': 'and_',
    'or_': 'or_',
    'lshift': 'shl',
    'rshift': 'lshr',
}.items():
    _define(
        getattr(operator, _operator),
        _words,
        (_words, _words),
        lambda builder, a, b, instruction=_instruction: getattr(builder, instruction)(a, b),
    )
for _operator, _symbol in {'lt': '<', 'le': '<=', 'gt': '>', 'ge': '>='}.items():
    _define(getattr(operator, _operator), _mask, (_lanes, _lanes), _compare(_symbol))
_define(operator.neg, _lanes, (_lanes,), lambda builder, a: builder.fneg(a))
_define(operator.and_, _mask, (_mask, _mask), lambda builder, a, b: builder.and_(a, b))
_define(operator.or_, _mask, (_mask, _mask), lambda builder, a, b: builder.or_(a, b))
_define(operator.invert, _mask, (_mask,), lambda builder, a: builder.not_(a))

_define(plain.fma, _lanes, (_lanes, _lanes, _lanes), _call(f'llvm.fma.v{LANES}f32', _FLOATS))
_define(plain.absolute, _lanes, (_lanes,), _call(f'llvm.fabs.v{LANES}f32', _FLOATS))
_define(plain.square_root, _lanes, (_lanes,), _call(f'llvm.sqrt.v{LANES}f32', _FLOATS))
_define(plain.copy_sign, _lanes, (_lanes, _lanes), _call(f'llvm.copysign.v{LANES}f32', _FLOATS))
_define(plain.minimum, _lanes, (_lanes, _lanes), _extremum('<'))
_define(plain.maximum, _lanes, (_lanes, _lanes), _extremum('>'))
_define(
    plain.select, _lanes, (_mask, _lanes, _lanes), lambda builder, m, a, b: builder.select(m, a, b)
)
_define(
    plain.swap_halves,
    _lanes,
    (_lanes,),
    lambda builder, a: builder.shuffle_vector(
        a, a, ir.Constant(INTS, [(i + HALF) % LANES for i in range(LANES)])
    ),
)
_define(
    plain.any_lane,
    types.boolean,
    (_mask,),
    lambda builder, m: builder.icmp_unsigned(
        '!=', builder.bitcast(m, ir.IntType(LANES)), ir.IntType(LANES)(0)
    ),
)
_define(
    plain.lane_bits,
    types.uint32,
    (_mask,),
    lambda builder, m: builder.zext(builder.bitcast(m, ir.IntType(LANES)), _I32),
)


_define(plain.from_bits, _lanes, (_words,), lambda builder, a: builder.bitcast(a, _FLOATS))
_define(plain.signed, _lanes, (_words,), lambda builder, a: builder.sitofp(a, _FLOATS))
_define(
    plain.subtract_bits,
    _lanes,
    (_words, _lanes),
    lambda builder, constant, a: builder.bitcast(
        builder.sub(constant, builder.bitcast(a, INTS)), _FLOATS
    ),
)
_define(
    plain.add_exponent,
    _lanes,
    (_lanes, _lanes),
    _on_bits(lambda builder, a, n: builder.add(a, builder.shl(n, in_every_lane(23)))),
)


@lower_builtin(plain.splat, types.float32)
def _lower_splat(context, builder, sig, values):
    return _splat(builder, values[0])


_declare(plain.splat, [signature(_lanes, types.float32)])


def _row_pointer(context, builder, sig, values, vector):
    array = context.make_array(sig.args[0])(context, builder, values[0])
    index = builder.mul(values[1], ir.IntType(64)(LANES))
    address = builder.gep(array.data, [index])
    return builder.bitcast(address, ir.PointerType(vector))


def _define_memory(kind, vector, rows):
    """Say how rows of one kind of vector are loaded and stored."""

    @lower_builtin(plain.load, rows, types.intp)
    def lower_load(context, builder, sig, values):
        return builder.load(_row_pointer(context, builder, sig, values, vector), align=4)

    @lower_builtin(plain.store, rows, types.intp, kind)
    def lower_store(context, builder, sig, values):
        builder.store(values[2], _row_pointer(context, builder, sig, values, vector), align=4)
        return context.get_dummy_value()


_floats = types.Array(types.float32, 2, 'C')
_integers = types.Array(types.uint32, 2, 'C')
_define_memory(_lanes, _FLOATS, _floats)
_define_memory(_words, INTS, _integers)
_declare(
    plain.load,
    [signature(_lanes, _floats, types.intp), signature(_words, _integers, types.intp)],
)
_declare(
    plain.store,
    [
        signature(types.none, _floats, types.intp, _lanes),
        signature(types.none, _integers, types.intp, _words),
    ],
)
