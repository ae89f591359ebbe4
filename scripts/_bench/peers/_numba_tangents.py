"""The hand-written explicit method on the variational equations, for its sensitivities.

Same pair of orders 5 and 4, on sixty numbers. The tolerance holds for the derivatives too, since
an explicit method whose steps the motion alone bounds can let them explode. Steps end at samples:
sixty interpolants at each would save little.
"""

import numba
import numpy as np

from ..equations import FAST, constants
from ..variational import derivatives, fill_variations, start

#: Dormand and Prince's coefficients; the last row is the step itself.
A = np.zeros((7, 6))
A[1, 0] = 1 / 5
A[2, :2] = 3 / 40, 9 / 40
A[3, :3] = 44 / 45, -56 / 15, 32 / 9
A[4, :4] = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
A[5, :5] = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
A[6] = 35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
C = A.sum(axis=1)
E = np.array([71 / 57600, 0.0, -71 / 16695, 71 / 1920, -17253 / 339200, 22 / 525, -1 / 40])


@numba.njit(fastmath=FAST, cache=True, error_model="numpy")
def integrate(c, y, ts, tol, out):
    """States and derivatives (n, 60) into `out`, NaN where it failed."""
    m = y.size
    k, z = np.empty((7, m)), np.empty(m)
    out[:] = np.nan
    out[0] = y
    t, h, last = ts[0], 1e-6, 1e-4
    fill_variations(t, y, c, k[0])
    for sample in range(1, ts.size):
        end = ts[sample]
        while t < end:
            rest = end - t
            landing = h >= rest
            # two halves rather than a full step and a sliver
            step = rest if landing else (0.5 * rest if 2.0 * h > rest else h)
            for i in range(1, 7):
                for j in range(m):
                    total = 0.0
                    for s in range(i):
                        total += A[i, s] * k[s, j]
                    z[j] = y[j] + step * total
                fill_variations(t + C[i] * step, z, c, k[i])
            error = 0.0
            for j in range(m):
                total = 0.0
                for s in range(7):
                    total += E[s] * k[s, j]
                ratio = step * total / (tol * (1.0 + max(abs(y[j]), abs(z[j]))))
                error += ratio * ratio
            error = np.sqrt(error / m)
            if not error < 1e300:  # infinite or NaN
                h = 0.1 * step
                if h < 1e-15:
                    return
                continue
            growth = max(error, 1e-10) ** 0.17
            if error > 1.0:
                h = step / min(5.0, growth / 0.9)
                continue
            t = end if landing else t + step
            for j in range(m):
                y[j], k[0, j] = z[j], k[6, j]
            new = step / min(5.0, max(0.1, growth / last**0.04 / 0.9))
            # a step cut short by a sample says nothing against the longer one
            h = max(h, new) if step < h else new
            last = max(error, 1e-4)
        out[sample] = y


def sensitivities(parameters, eps, ts, tol):
    """Derivatives (n, 2, 14) of the angles."""
    out = np.empty((ts.size, 60))
    integrate(constants(parameters, eps), start(), ts, tol, out)
    return derivatives(out, parameters)
