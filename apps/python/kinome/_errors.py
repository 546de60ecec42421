"""Errors of scenes, files and arguments."""


class Error(Exception):
    """An error in a scene, a file or an argument. str() is "FILE:LINE:COLUMN: message".

    message: the message without the location. file, line, column: the location; lines and columns
    start at 1, and line 0 is the file as a whole. For a dict, `file` is the path of its keys. all:
    all errors of a scene, this one first.
    """

    def __init__(self, text, message="", file="", line=0, column=0):
        super().__init__(text)
        self.message, self.file, self.line, self.column = message or text, file, line, column
        self.all = [self]
