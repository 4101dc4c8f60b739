"""The floor without ROS: pty, this process, Unix socket, owner.

``run SECONDS``: five commands a second, at random phases. Notes: goals, and when an answer was there.
"""

from __future__ import annotations

import json
import random
import sys
import threading
import time

from wire import GO, LAST_US, Owner, now_us, obey, read_frames, rest_until, word_of


def main(port: str, socket: str, notes: str) -> None:
    owner, taken = Owner(socket), list[dict[str, object]]()

    def read() -> None:
        for frame in read_frames(port):
            if frame.startswith(GO):
                word = word_of(frame)
                owner.ask(word)
                taken.append({"state": word.decode(), "received": now_us()})

    threading.Thread(target=read, daemon=True).start()
    count = 0

    def run(words: list[str]) -> None:
        nonlocal count
        end = now_us() + round(float(words[1]) * 1e6)
        while now_us() + 300_000 < end:
            time.sleep(random.uniform(0.1, 0.3))
            count += 1
            at, word = now_us(), f"c{count}"
            owner.ask(word.encode())
            taken.append({"state": word, "received": now_us()})
            taken.append({"goal": word, "at": at})
        rest_until(end + LAST_US)
        with open(notes, "a", encoding="utf-8") as file:
            file.writelines(json.dumps(note) + "\n" for note in taken)
        taken.clear()

    obey(run)


if __name__ == "__main__":
    main(*sys.argv[1:])
