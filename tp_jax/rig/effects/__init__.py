"""Effects that can be hidden, one family per file, and the list of them all."""

from tp_jax.rig.effects.base import Draw as Draw
from tp_jax.rig.effects.base import Effect as Effect
from tp_jax.rig.effects.base import Hidden as Hidden
from tp_jax.rig.effects.registry import catalogue as catalogue
from tp_jax.rig.effects.registry import hide as hide
from tp_jax.rig.effects.registry import register as register
