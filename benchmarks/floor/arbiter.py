"""The floor's line arbiter: writes a line to a file for each message on a Unix socket.

A message is a word; the line has the word, and the time just before it was written (as virtual lines have it).
"""

from __future__ import annotations

import os
import selectors
import socket
import sys
import time


def main(path: str, lines: str) -> None:
    out = os.open(lines, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    listener = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
    listener.bind(path)
    listener.listen()
    with selectors.DefaultSelector() as selector:
        selector.register(listener, selectors.EVENT_READ)
        while True:
            for key, _ in selector.select():
                if key.fileobj is listener:
                    selector.register(listener.accept()[0], selectors.EVENT_READ)
                    continue
                client = key.fileobj
                assert isinstance(client, socket.socket)
                message = client.recv(4096)
                if not message:
                    selector.unregister(client)
                    client.close()
                    continue
                os.write(out, b"%s %d\n" % (message.strip(), time.monotonic_ns() // 1000))
                client.send(message)


if __name__ == "__main__":
    main(*sys.argv[1:])
