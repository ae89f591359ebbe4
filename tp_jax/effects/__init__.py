"""The catalogue of effects: one small module each, found by its id.

The formulas are this project's statement of effects known from the literature on friction and
torsional drives; those the paper suspects in its Section 6 say so in `source`.
"""

from tp_jax.effects.base import CHANNELS as CHANNELS
from tp_jax.effects.base import Amplitude as Amplitude
from tp_jax.effects.base import Applied as Applied
from tp_jax.effects.base import Effect as Effect
from tp_jax.effects.base import Shape as Shape
from tp_jax.effects.laws import AnyLaw as AnyLaw
from tp_jax.effects.laws import Law as Law
from tp_jax.effects.laws import laws as laws
from tp_jax.effects.registry import catalogue as catalogue
from tp_jax.effects.registry import get as get
from tp_jax.effects.registry import register as register
from tp_jax.effects.registry import unregister as unregister
