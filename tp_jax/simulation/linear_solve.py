"""Solution of the stages' linear systems, by the pendulum's structure.

A stage solves `(1/(gamma h) - J) k = r`. Positions follow velocities, so they are eliminated by
hand; what effects bring along as states of their own is eliminated next, each entry that is zero
by structure left out; the two velocities, which friction couples, remain and are solved in
closed form. Everything is elementwise over lanes.

The quotients are where they are on purpose: a compiler that fuses elementwise operations
evaluates a cheap expression anew for each of its readers, and theirs in turn, but never a
quotient. With products instead of quotients, a step costs five times as much.
"""

from collections.abc import Callable, Sequence

from tp_jax.model.arrays import AnyArray

#: Entry (i, j) of a Jacobian over lanes; None where zero by structure.
Jacobian = Sequence[Sequence[AnyArray | None]]


def eliminate(jacobian: Jacobian, g: AnyArray | float) -> Callable[[list], list]:
    """Prepares `(g - J) k = r` for several right-hand sides.

    Args:
        jacobian: (n, n) nested sequence over (phi1, phi2, v1, v2, own states...), each entry (L,)
            or None. Rows 0 and 1 must hold nothing but a rate in columns 2 and 3.
        g: (L,) 1/(gamma h).

    Returns:
        A function from the list of right-hand sides r_i to the list of k_i.
    """
    n = len(jacobian)
    rates = (jacobian[0][2], jacobian[1][3])
    # (g - J) with the positions gone: k_q = (r_q + rate k_v)/g.
    reduced: dict[tuple[int, int], AnyArray | float] = {}
    for i in range(2, n):
        for j in range(2, n):
            entry = jacobian[i][j]
            if j < 4:
                pull, rate = jacobian[i][j - 2], rates[j - 2]
                if pull is not None and rate is not None:
                    term = pull * rate / g
                    entry = term if entry is None else entry + term
            if i == j:
                reduced[i, j] = g if entry is None else g - entry
            elif entry is not None:
                reduced[i, j] = -entry
    # Own states of effects, from the last.
    steps = []
    for m in range(n - 1, 3, -1):
        pivot = reduced[m, m]
        rows = [i for i in range(2, m) if (i, m) in reduced]
        columns = [j for j in range(2, m) if (m, j) in reduced]
        factors = {i: reduced[i, m] / pivot for i in rows}
        for i in rows:
            for j in columns:
                term = factors[i] * reduced[m, j]
                reduced[i, j] = reduced[i, j] - term if (i, j) in reduced else -term
        steps.append((m, pivot, factors, {j: reduced[m, j] for j in columns}))
    a, d = reduced[2, 2], reduced[3, 3]
    b, c = reduced.get((2, 3)), reduced.get((3, 2))
    determinant = a * d if b is None or c is None else a * d - b * c

    def solve(r: list) -> list:
        r = list(r)
        for i in range(2, n):
            for q in (0, 1):
                if jacobian[i][q] is not None:
                    r[i] = r[i] + jacobian[i][q] * r[q] / g
        for m, _, factors, _ in steps:
            for i, f in factors.items():
                r[i] = r[i] - f * r[m]
        k: list = [None] * n
        k[2] = (d * r[2] if b is None else d * r[2] - b * r[3]) / determinant
        k[3] = (a * r[3] if c is None else a * r[3] - c * r[2]) / determinant
        for m, pivot, _, columns in reversed(steps):
            k[m] = (r[m] - sum(c * k[j] for j, c in columns.items())) / pivot
        for q in (0, 1):
            k[q] = (r[q] if rates[q] is None else r[q] + rates[q] * k[q + 2]) / g
        return k

    return solve
