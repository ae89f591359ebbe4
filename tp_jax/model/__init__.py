"""The pendulum: every law of the paper its own small piece, put together in `pendulum`.

The names below are looked up when first used, so that the tables of `parameters` can be read
without JAX.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tp_jax.model.bearing import Bearing as Bearing
    from tp_jax.model.contact import Contact as Contact
    from tp_jax.model.drive import PiecewiseCubicDrive as PiecewiseCubicDrive
    from tp_jax.model.drive import SineDrive as SineDrive
    from tp_jax.model.friction import smooth_sign as smooth_sign
    from tp_jax.model.motion import Motion as Motion
    from tp_jax.model.parameters import Parameter as Parameter
    from tp_jax.model.pendulum import DoubleTorsionPendulum as DoubleTorsionPendulum
    from tp_jax.model.pendulum import SingleTorsionPendulum as SingleTorsionPendulum
    from tp_jax.model.sensors import Sensors as Sensors
    from tp_jax.model.spring import LinearSpring as LinearSpring

_MODULES = {
    "Bearing": "bearing",
    "Contact": "contact",
    "DoubleTorsionPendulum": "pendulum",
    "LinearSpring": "spring",
    "Motion": "motion",
    "Parameter": "parameters",
    "PiecewiseCubicDrive": "drive",
    "Sensors": "sensors",
    "SineDrive": "drive",
    "SingleTorsionPendulum": "pendulum",
    "smooth_sign": "friction",
}

__all__ = sorted(_MODULES)


def __getattr__(name: str) -> Any:
    if name not in _MODULES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(f"{__name__}.{_MODULES[name]}"), name)
