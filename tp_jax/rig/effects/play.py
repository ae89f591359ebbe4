"""Play: what follows only once the gap is used up."""


class Play:
    """The play operator of half width g [rad]: y stays unless |x - y| would exceed g.

    Within a step x must go one way; `begin` is to be called at the start of every step.
    """

    def __init__(self, half: float, x: float = 0.0):
        """Starts in the middle of its gap at `x` [rad]."""
        self.half = half
        self.rest = x

    def follow(self, x: float) -> float:
        """Output at an input `x` [rad] of the present step."""
        return min(max(self.rest, x - self.half), x + self.half)

    def begin(self, x: float) -> None:
        """A step begins at input `x` [rad]."""
        self.rest = self.follow(x)
