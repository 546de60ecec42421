"""A display for tests: speaks the protocol of the viewer tev and keeps the images that it receives.
"""

import socket
import struct
import threading

import numpy as np

CREATE_IMAGE, UPDATE_IMAGE_V3 = 4, 6


class Picture:
    def __init__(self, width, height, channels):
        self.channels = channels
        self.pixels = np.full((height, width, len(channels)), np.nan, np.float32)
        self.updates = []  # (x, y, width, height) in the order of arrival


class Message:
    """Parses the fields of a message in order."""

    def __init__(self, data):
        self.data, self.at = data, 0

    def number(self, kind):
        value, = struct.unpack_from("<" + kind, self.data, self.at)
        self.at += struct.calcsize("<" + kind)
        return value

    def text(self):
        end = self.data.index(0, self.at)
        text = self.data[self.at:end].decode()
        self.at = end + 1
        return text


class Receiver:
    """Receives from one connection. `leave_after`: number of messages after which it closes the
    connection. `stalls`: accepts the connection but never reads from it."""

    def __init__(self, leave_after=None, stalls=False):
        self.pictures, self.messages, self.creations, self.error = {}, 0, 0, None
        self.leave_after, self.stalls = leave_after, stalls
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = "127.0.0.1:%d" % self.listener.getsockname()[1]
        self.closing = threading.Event()
        self.thread = threading.Thread(target=self.receive, daemon=True)
        self.thread.start()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.closing.set()
        self.thread.join(10)
        self.listener.close()

    def wait(self):
        """Waits until the connection has ended."""
        self.thread.join(10)
        if self.error:
            raise self.error
        assert not self.thread.is_alive()

    def receive(self):
        try:
            connection, _ = self.listener.accept()
            with connection:
                if self.stalls:
                    self.closing.wait()
                    return
                with connection.makefile("rb") as stream:
                    while length := stream.read(4):
                        size, = struct.unpack("<I", length)
                        self.handle(Message(stream.read(size - 4)))
                        self.messages += 1
                        if self.messages == self.leave_after:
                            return
        except Exception as error:  # wait() reports it
            self.error = error

    def handle(self, message):
        kind = message.number("b")
        message.number("b")  # focus flag
        name = message.text()
        if kind == CREATE_IMAGE:
            width, height, count = (message.number("i") for _ in range(3))
            self.pictures[name] = Picture(width, height, [message.text() for _ in range(count)])
            self.creations += 1
        elif kind == UPDATE_IMAGE_V3:
            self.update(self.pictures[name], message)
        else:
            raise ValueError(f"unsupported message of kind {kind}")

    @staticmethod
    def update(picture, message):
        channels = [message.text() for _ in range(message.number("i"))]
        x, y, width, height = (message.number("i") for _ in range(4))
        offsets = [message.number("q") for _ in channels]
        strides = [message.number("q") for _ in channels]
        numbers = np.frombuffer(message.data, "<f4", offset=message.at)
        last = [o + (width * height - 1) * s for o, s in zip(offsets, strides)]
        if max(last) + 1 != len(numbers):
            raise ValueError(f"{len(numbers)} numbers, not {max(last) + 1}")
        for name, offset, stride, end in zip(channels, offsets, strides, last):
            values = numbers[offset:end + 1:stride].reshape(height, width)
            target = picture.pixels[y:y + height, x:x + width, picture.channels.index(name)]
            if target.shape != values.shape:
                raise ValueError(f"{width}x{height} pixels at {x}, {y}: must be inside the image")
            target[:] = values
        picture.updates.append((x, y, width, height))
