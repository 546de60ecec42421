"""Counterpart of ../worker.py: answers lines of JSON on stdin, in the Python of a renderer.

Uses only the standard library. Python searches this folder first, so no file in it may have the name of a
package.
"""
import json
import os
import sys


def answer(handlers, request):
    try:
        command = request.pop("command")
        return handlers[command](**request)
    except Exception as reason:  # a renderer may raise anything; ../worker.py handles the error
        return {"error": f"{reason}" or type(reason).__name__}


def serve(handlers):
    """Answers requests until stdin ends. Redirects the output of the renderer to stderr."""
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        print(json.dumps(answer(handlers, json.loads(line))), file=replies, flush=True)
