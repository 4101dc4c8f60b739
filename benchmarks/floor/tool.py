"""The floor without ROS: pty, this process, Unix socket, arbiter.

``run SECONDS`` sends goals. It notes the goals and the times of the answers.
"""

from __future__ import annotations

import sys
import threading

from wire import GO, Arbiter, Notes, give_goals, now_us, read_frames, word_of


def main(port: str, socket: str, path: str) -> None:
    arbiter, notes = Arbiter(socket), Notes(path)

    def ask(word: bytes) -> None:
        arbiter.ask(word)
        notes.add(state=word.decode(), received=now_us())

    def read() -> None:
        for frame in read_frames(port):
            if frame.startswith(GO):
                ask(word_of(frame))

    threading.Thread(target=read, daemon=True).start()
    give_goals(notes, lambda number: ask(b"c%d" % number))


if __name__ == "__main__":
    main(*sys.argv[1:])
