"""What goes wrong by no fault of the package."""


class InputError(ValueError):
    """Something given to the package cannot be used; the message says in one sentence what to mend.

    The command line prints the message alone, without a traceback, and exits with 2.
    """
