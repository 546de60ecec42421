"""What is wrong with a scene."""


class Error(Exception):
    """A mistake in a scene, a file or an argument. str() is "FILE:LINE:COLUMN: message".

    message: without its place. file, line, column: counted from 1; line 0 is a file as a whole, and
    of a dict, `file` is the path of its keys. all: every mistake of a scene, this one first.
    """

    def __init__(self, text, message="", file="", line=0, column=0):
        super().__init__(text)
        self.message, self.file, self.line, self.column = message or text, file, line, column
        self.all = [self]
