"""Arctangent, sine and cosine that compilers can turn into vector instructions.

On a CPU, XLA calls the C library for each, one number after the other: 8 ns each, which is
most of what a friction law costs. The polynomials below need a sixth of it. All agree with NumPy
to 4e-16 (sine and cosine: up to a million radians), and the arctangent to a few units in the last
place.
"""

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from tp_jax.model.arrays import AnyArray, Real

# Interpolation at Chebyshev nodes of arctan(sqrt w)/sqrt w on [0, tan^2(pi/8)], and of
# sin(sqrt w)/sqrt w and cos(sqrt w) on [0, (pi/2)^2]: errors 3e-17, 2e-19 and 4e-18, computed to
# 40 digits.
_ARCTAN = (
    0.99999999999999996532,
    -0.33333333333328438572,
    0.19999999998855110134,
    -0.1428571418097646683,
    0.1111110618045594522,
    -0.090907730748084137897,
    0.076899534963068577563,
    -0.066402339304294085887,
    0.056883492268090104794,
    -0.043480522157164624777,
    0.021135373157693245206,
)
_SINE = (
    0.99999999999999999979,
    -0.16666666666666665307,
    0.008333333333333186384,
    -0.0001984126984120867517,
    2.7557319211229606622e-6,
    -2.5052106890569519539e-8,
    1.6058940878486559931e-10,
    -7.6430265579716326635e-13,
    2.7215749422983442826e-15,
)
_COSINE = (
    0.99999999999999999608,
    -0.49999999999999974243,
    0.04166666666666388234,
    -0.0013888888888772989911,
    2.4801587277414924404e-5,
    -2.7557316391025750805e-7,
    2.0876561839933163279e-9,
    -1.1462901901757274785e-11,
    4.6089770030017970304e-14,
)

_TAN_EIGHTH = 0.41421356237309504880  # tan(pi/8)
_TAN_SIXTEENTH = 0.19891236737965800691  # tan(pi/16)
_EIGHTH = 0.39269908169872415481  # pi/8
_QUARTER = 1.5707963267948966192  # pi/2
# pi in two parts, the first short: multiples of it are exact.
_PI_HIGH = 3.1415926534682512
_PI_LOW = 1.2154201013012384e-10


@jax.custom_jvp
def arctan(x: Real) -> Float[Array, "..."]:
    """Inverse tangent [rad], elementwise.

    Args:
        x: any real number; infinite ones give a quarter turn.
    """
    size = jnp.abs(x)
    # One of x and 1/x is at most one; turned back by pi/8, where it is not small already (so that
    # small ones keep their digits and zero stays zero), at most tan(pi/8) is left.
    z = jnp.where(size > 1.0, 1.0 / size, size)
    turned = z > _TAN_SIXTEENTH
    z = jnp.where(turned, (z - _TAN_EIGHTH) / (1.0 + _TAN_EIGHTH * z), z)
    angle = jnp.where(turned, _EIGHTH, 0.0) + z * _polynomial(_ARCTAN, z * z)
    angle = jnp.where(size > 1.0, _QUARTER - angle, angle)
    return jnp.where(x < 0.0, -angle, angle)


@arctan.defjvp
def _(primals, tangents):
    (x,), (dx,) = primals, tangents
    return arctan(x), dx / (1.0 + x * x)


@jax.custom_jvp
def sine_cosine(x: Real) -> tuple[Float[Array, "..."], Float[Array, "..."]]:
    """Sine and cosine of an angle [rad], elementwise; each is the other's derivative.

    Args:
        x: angle [rad].
    """
    turns = jnp.floor(x / jnp.pi + 0.5)
    rest = (x - turns * _PI_HIGH) - turns * _PI_LOW
    sign = 1.0 - 2.0 * (turns - 2.0 * jnp.floor(0.5 * turns))
    w = rest * rest
    # One, as far as a compiler can know some number: a quotient is evaluated once for all its
    # readers, and they are many, where a product would be evaluated anew for each.
    one = jnp.where(w >= 0.0, 1.0, w)
    return sign * rest * _polynomial(_SINE, w) / one, sign * _polynomial(_COSINE, w) / one


@sine_cosine.defjvp
def _(primals, tangents):
    (x,), (dx,) = primals, tangents
    s, c = sine_cosine(x)
    return (s, c), (c * dx, -s * dx)


def sine(x: Real) -> Float[Array, "..."]:
    """Sine of an angle [rad], elementwise (see `sine_cosine`)."""
    return sine_cosine(x)[0]


def cosine(x: Real) -> Float[Array, "..."]:
    """Cosine of an angle [rad], elementwise (see `sine_cosine`)."""
    return sine_cosine(x)[1]


def _polynomial(coefficients: tuple[float, ...], w: AnyArray) -> Array:
    """Value at `w`, lowest power first, by Horner's rule."""
    total = jnp.full_like(w, coefficients[-1])
    for c in coefficients[-2::-1]:
        total = total * w + c
    return total
