"""Files that are no text, one kind per module, each read by a library that is loaded when needed.

Each module has `read(file, sheet)`, which returns the file's columns in order, name -> values as
the file has them: numbers, dates, or texts. A matrix gives a column for each of its columns,
"name[0]" and so on. What cannot be read raises `Unreadable`.
"""


class Unreadable(Exception):
    """A file of a known kind cannot be used; what is wrong, and the mend.

    Attributes:
        wrong: as part of a sentence.
        mend: what to do.
    """

    def __init__(self, wrong: str, mend: str):
        super().__init__(f"{wrong}; {mend}")
        self.wrong = wrong
        self.mend = mend
