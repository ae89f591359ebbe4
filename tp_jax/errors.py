"""Errors and notices that are no fault of the package."""


class InputError(ValueError):
    """Something given to the package cannot be used; the message says in one sentence what to mend.

    The command line prints the message alone, without a traceback, and exits with 2.
    """


class Notice(UserWarning):
    """Something was left out, and the package goes on without it; the message says what and why.

    The command line prints it as one line, while warnings of libraries stay unseen.
    """
