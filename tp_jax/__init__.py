"""Differentiable modelling of a double torsion pendulum with friction, and its sim-to-real gap.

    import tp_jax as tp

    campaign = tp.load_campaign("case-02")  # a folder with a campaign.toml
    diagnosis = tp.diagnose(campaign)       # where the gap lies, its cause, how far it shrinks
    print(diagnosis.summary())

The names below are looked up when first used, so that `import tp_jax` costs nothing. The modules
that compute tell JAX to use 64 bits (`tp_jax._float64`).

Data flows one way through the package:

    acquisition -> recordings -> estimation (over model, effects, simulation)
                -> identifiability -> sensitivity_analysis, gap -> report, cli
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

from tp_jax._version import __version__ as __version__

if TYPE_CHECKING:
    from tp_jax import effects as effects
    from tp_jax import report as report
    from tp_jax._config import enable_compilation_cache as enable_compilation_cache
    from tp_jax.checks import check as check
    from tp_jax.errors import InputError as InputError
    from tp_jax.estimation.identify import identify as identify
    from tp_jax.estimation.nelder_mead import NelderMead as NelderMead
    from tp_jax.estimation.projected_gauss_newton import VariableProjection as VariableProjection
    from tp_jax.gap.diagnosis import Diagnosis as Diagnosis
    from tp_jax.gap.diagnosis import diagnose as diagnose
    from tp_jax.gap.predict import predict as predict
    from tp_jax.model import presets as presets
    from tp_jax.model.pendulum import DoubleTorsionPendulum as DoubleTorsionPendulum
    from tp_jax.model.pendulum import SingleTorsionPendulum as SingleTorsionPendulum
    from tp_jax.recordings import Campaign as Campaign
    from tp_jax.recordings import CampaignError as CampaignError
    from tp_jax.recordings import Recording as Recording
    from tp_jax.recordings import load_campaign as load_campaign
    from tp_jax.report.arviz_export import to_arviz as to_arviz
    from tp_jax.sensitivity_analysis.analysis import SensitivityAnalysis as SensitivityAnalysis
    from tp_jax.sensitivity_analysis.analysis import sensitivity as sensitivity
    from tp_jax.simulation.reversal_controller import ReversalController as ReversalController
    from tp_jax.simulation.rodas4 import Rodas4 as Rodas4
    from tp_jax.simulation.sensitivities import Sensitivities as Sensitivities
    from tp_jax.simulation.sensitivities import sensitivities as sensitivities
    from tp_jax.simulation.solve import Trajectory as Trajectory
    from tp_jax.simulation.solve import accelerations as accelerations
    from tp_jax.simulation.solve import simulate as simulate
    from tp_jax.simulation.sweep import Sweep as Sweep
    from tp_jax.simulation.sweep import sweep as sweep

# name -> (module, attribute; None for the module itself)
_WITHOUT_JAX = {
    "Campaign": ("tp_jax.recordings", "Campaign"),
    "CampaignError": ("tp_jax.recordings", "CampaignError"),
    "InputError": ("tp_jax.errors", "InputError"),
    "check": ("tp_jax.checks", "check"),
    "Recording": ("tp_jax.recordings", "Recording"),
    "load_campaign": ("tp_jax.recordings", "load_campaign"),
    "to_arviz": ("tp_jax.report.arviz_export", "to_arviz"),
}
_WITH_JAX = {
    "Diagnosis": ("tp_jax.gap.diagnosis", "Diagnosis"),
    "DoubleTorsionPendulum": ("tp_jax.model.pendulum", "DoubleTorsionPendulum"),
    "Sensitivities": ("tp_jax.simulation.sensitivities", "Sensitivities"),
    "NelderMead": ("tp_jax.estimation.nelder_mead", "NelderMead"),
    "ReversalController": ("tp_jax.simulation.reversal_controller", "ReversalController"),
    "Rodas4": ("tp_jax.simulation.rodas4", "Rodas4"),
    "SensitivityAnalysis": ("tp_jax.sensitivity_analysis.analysis", "SensitivityAnalysis"),
    "SingleTorsionPendulum": ("tp_jax.model.pendulum", "SingleTorsionPendulum"),
    "Sweep": ("tp_jax.simulation.sweep", "Sweep"),
    "VariableProjection": ("tp_jax.estimation.projected_gauss_newton", "VariableProjection"),
    "Trajectory": ("tp_jax.simulation.solve", "Trajectory"),
    "accelerations": ("tp_jax.simulation.solve", "accelerations"),
    "diagnose": ("tp_jax.gap.diagnosis", "diagnose"),
    "enable_compilation_cache": ("tp_jax._config", "enable_compilation_cache"),
    "effects": ("tp_jax.effects", None),
    "report": ("tp_jax.report", None),
    "identify": ("tp_jax.estimation.identify", "identify"),
    "predict": ("tp_jax.gap.predict", "predict"),
    "presets": ("tp_jax.model.presets", None),
    "sensitivities": ("tp_jax.simulation.sensitivities", "sensitivities"),
    "sensitivity": ("tp_jax.sensitivity_analysis.analysis", "sensitivity"),
    "simulate": ("tp_jax.simulation.solve", "simulate"),
    "sweep": ("tp_jax.simulation.sweep", "sweep"),
}

__all__ = [
    "Campaign",
    "CampaignError",
    "Diagnosis",
    "DoubleTorsionPendulum",
    "InputError",
    "NelderMead",
    "Recording",
    "ReversalController",
    "Rodas4",
    "Sensitivities",
    "SensitivityAnalysis",
    "SingleTorsionPendulum",
    "Sweep",
    "Trajectory",
    "VariableProjection",
    "__version__",
    "accelerations",
    "check",
    "diagnose",
    "effects",
    "enable_compilation_cache",
    "identify",
    "load_campaign",
    "predict",
    "presets",
    "report",
    "sensitivities",
    "sensitivity",
    "simulate",
    "sweep",
    "to_arviz",
]


def __getattr__(name: str) -> Any:
    if name in _WITH_JAX:
        module, attribute = _WITH_JAX[name]
    elif name in _WITHOUT_JAX:
        module, attribute = _WITHOUT_JAX[name]
    else:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    loaded = import_module(module)
    value = loaded if attribute is None else getattr(loaded, attribute)
    globals()[name] = value  # looked up once
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
