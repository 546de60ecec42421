"""The other end of ../worker.py: answers lines of JSON on stdin, in the Python of a renderer.

Only the standard library. This folder is the first that Python searches, so it holds nothing by the
name of a package.
"""
import json
import os
import sys


def answer(handlers, request):
    try:
        command = request.pop("command")
        return handlers[command](**request)
    except Exception as reason:  # whatever a renderer throws: the other end decides
        return {"error": f"{reason}" or type(reason).__name__}


def serve(handlers):
    """Until stdin ends. What the renderer itself prints goes to stderr."""
    replies = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)
    for line in sys.stdin:
        print(json.dumps(answer(handlers, json.loads(line))), file=replies, flush=True)
