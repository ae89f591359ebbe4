"""Message where an executor's package is not installed."""

from tp_jax.errors import InputError


def missing(kind: str, package: str) -> InputError:
    """One sentence with the command that mends it.

    Args:
        kind: of the executor, and name of the extra. package: that is missing.
    """
    return InputError(
        f"The executor {kind} needs the package {package}, which is not installed: "
        f"pip install 'tp-jax[{kind}]'"
    )
