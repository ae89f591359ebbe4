"""64 bits for JAX. Every module that computes imports this one, or one that does.

At 32 bits the solver's error is above the sensors' noise. So a program that imports `tp_jax.gap`
directly has the same precision as one that writes `tp.diagnose`; `import tp_jax` alone loads no JAX
and sets nothing.
"""

import jax

jax.config.update("jax_enable_x64", True)
