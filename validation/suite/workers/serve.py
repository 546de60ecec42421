"""The other end of ../worker.py: answers lines of JSON on stdin, in whatever Python the renderer needs.
Only the standard library. In this folder is nothing
whose name a package might look for: it is the first that Python searches."""
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
