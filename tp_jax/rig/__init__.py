"""A virtual rig with hard dry friction and hidden effects, independent of the package's model.

    parameters -> hooks -> equations, stepper, segment -> motion      two bodies that slide or rest
    effects                                                           what can be hidden
    drive -> simulator                                                `VirtualRig`, run by run
    plan, chain -> campaign                                           which runs, noise, files

NumPy and SciPy only.
"""

from tp_jax.rig.campaign import make_campaign as make_campaign
from tp_jax.rig.parameters import BENCH as BENCH
from tp_jax.rig.parameters import RigParameters as RigParameters
from tp_jax.rig.simulator import VirtualRig as VirtualRig
