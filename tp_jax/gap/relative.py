"""Amplitudes of which only the differences matter, told as differences from their mean.

While fitting, the last recording's is held at zero; what that leaves to the parameter they are
relative to is then that recording's. The model is the same.
"""

import dataclasses
from collections.abc import Sequence

from tp_jax.effects import Effect
from tp_jax.estimation.layout import Values
from tp_jax.gap.refit import Refit


def centred(values: Values, effects: Sequence[Effect], fitted: Sequence[int]) -> Values:
    """The same numbers with amplitudes whose mean over the fitted recordings is zero.

    Beside another effect of the same place they are told about the last fitted recording's.

    What is p (1 + a_r) becomes p (1 + m) (1 + a'_r), with a'_r = (a_r - m) / (1 + m), in all
    recordings; of one that was not fitted, a_r has to be what is expected or was found there.

    Args:
        values: of a fit.
        effects: that are in it.
        fitted: recordings that were fitted.
    """
    for effect in effects:
        # another effect of the same place is a part of its friction, which would change with it
        beside = [e for e in effects if e is not effect and e.location == effect.location]
        if not effect.relative or beside:
            continue
        name = effect.qualified(effect.amplitudes[0].name)
        row = values.table[values.layout.index[name]]
        mean = row[list(fitted)].mean()
        row = (row - mean) / (1.0 + mean)
        scaled = values.get(effect.relative) * (1.0 + mean)
        values = values.replace({name: row, effect.relative: scaled})
    return values


def told(result: Refit, fitted: Sequence[int]) -> Refit:
    """A refit with its numbers as they are to be told; what was computed with it stays.

    So does the standard error of the parameter: it is the last recording's, not the mean's, which
    is known better.
    """
    effects = [v.effect for v in result.variants]
    if not any(e.relative for e in effects):
        return result
    fit = dataclasses.replace(result.fit, values=centred(result.fit.values, effects, fitted))
    return dataclasses.replace(result, fit=fit)
