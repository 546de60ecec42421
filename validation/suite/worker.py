"""A renderer in a persistent separate process, which answers requests in lines of JSON."""
import json
import os
import select
import signal
import subprocess
import time

from .problems import Problem, one_line

HINTS = {signal.SIGILL: "this processor lacks required instructions (AVX?)",
         signal.SIGKILL: "out of memory?"}


class Dead(Problem):
    """The process has ended. Its loaded scene is lost."""


class Refused(Problem):
    """The process has rejected a request. It can process other requests."""


class Worker:
    def __init__(self, name, command, environment=None, timeout=900):
        self.name, self.timeout = name, timeout
        self.rest = b""
        try:
            self.process = subprocess.Popen(
                [str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, env={**os.environ, **(environment or {})},
                start_new_session=True)  # only the parent receives Ctrl-C, and then ends the process
        except OSError as reason:
            raise Dead(f"{name}: can't be started: {reason.strerror}") from reason
        os.set_blocking(self.process.stderr.fileno(), False)
        os.set_blocking(self.process.stdout.fileno(), False)
        self.said = b""

    def ask(self, **request):
        """Sends a request; returns the answer, a dictionary. Raises Refused or Dead."""
        try:
            self.process.stdin.write(json.dumps(request).encode() + b"\n")
            self.process.stdin.flush()
        except (OSError, ValueError):
            pass  # the process has ended; reading reports why
        answer = json.loads(self._line())
        if "error" in answer:
            raise Refused(f"{self.name}: {one_line(answer['error'])}")
        return answer

    def _line(self):
        end = time.monotonic() + self.timeout
        pipes = {self.process.stdout, self.process.stderr}
        while b"\n" not in self.rest:
            left = end - time.monotonic()
            if left <= 0:
                self.close()
                raise Dead(f"{self.name}: no answer for {self.timeout:g} s")
            for pipe in select.select(list(pipes), [], [], left)[0]:
                got = pipe.read(65536)
                if pipe is self.process.stderr:
                    # Must be read, because a full pipe would block the process. Only the end is kept.
                    self.said = (self.said + (got or b""))[-2000:]
                    if got == b"":
                        pipes.discard(pipe)
                elif got == b"":
                    raise self._death()
                else:
                    self.rest += got or b""
        line, self.rest = self.rest.split(b"\n", 1)
        return line

    def _death(self):
        status = self.process.wait()
        self.said += self.process.stderr.read() or b""
        self.close()
        if status < 0:
            name = signal.Signals(-status).name
            hint = HINTS.get(-status)
            return Dead(f"{self.name}: died by {name}" + (f": {hint}" if hint else ""))
        last = self.said.decode(errors="replace").strip().splitlines() or ["no message"]
        return Dead(f"{self.name}: ended with status {status}: {last[-1]}")

    def close(self):
        if self.process.poll() is None:
            self.process.kill()
            self.process.wait()
        for pipe in (self.process.stdin, self.process.stdout, self.process.stderr):
            try:
                pipe.close()
            except OSError:
                pass
