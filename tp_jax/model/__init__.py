"""The pendulum: every law of the paper its own small piece, put together in `pendulum`."""

from tp_jax.model.bearing import Bearing as Bearing
from tp_jax.model.contact import Contact as Contact
from tp_jax.model.drive import PiecewiseCubicDrive as PiecewiseCubicDrive
from tp_jax.model.drive import SineDrive as SineDrive
from tp_jax.model.energy import Energy as Energy
from tp_jax.model.energy import energy as energy
from tp_jax.model.friction import smooth_sign as smooth_sign
from tp_jax.model.motion import Motion as Motion
from tp_jax.model.parameters import Parameter as Parameter
from tp_jax.model.pendulum import DoubleTorsionPendulum as DoubleTorsionPendulum
from tp_jax.model.pendulum import SingleTorsionPendulum as SingleTorsionPendulum
from tp_jax.model.sensors import Sensors as Sensors
from tp_jax.model.spring import LinearSpring as LinearSpring
