"""Published models, written anew from the literature."""

from __future__ import annotations

from tests.unit.timed_automata.explore.models import network
from timed_automata import Network


def fischer(n: int, *, write: int = 2, wait: str = "x > 2") -> Network:
    """Mutual exclusion by a shared variable (Fischer; Lamport 1987): write within ``write``, wait longer."""
    process = f"""P(const pid_t pid): own: clock x; | req: x <= WRITE
        idle -> req; guard: id == 0; do: x = 0
        req -> wait; guard: x <= WRITE; do: x = 0, id = pid
        wait -> req; guard: id == 0; do: x = 0
        wait -> cs; guard: {wait} && id == pid
        cs -> idle; do: id = 0"""
    return network(f"const int WRITE = {write}; typedef int[1,{n}] pid_t; int[0,{n}] id;", process)


def train_gate(n: int, *, leave: str = "x >= 3") -> Network:
    """Trains that share a bridge, a gate that stops them in order (Yi, Pettersson, Daniels 1994)."""
    train = f"""Train(const id_t id): own: clock x; | Appr: x <= 20 | Start: x <= 15 | Cross: x <= 5
        Safe -> Appr; sync: appr[id]!; do: x = 0
        Appr -> Cross; guard: x >= 10; do: x = 0
        Appr -> Stop; guard: x <= 10; sync: stop[id]?; do: x = 0
        Stop -> Start; sync: go[id]?; do: x = 0
        Start -> Cross; guard: x >= 7; do: x = 0
        Cross -> Safe; guard: {leave}; sync: leave[id]!; do: x = 0"""
    gate = """Gate: committed: Stopping
        Free -> Occ; select: e : id_t; guard: len == 0; sync: appr[e]?; do: enqueue(e)
        Free -> Occ; guard: len > 0; sync: go[list[0]]!
        Occ -> Stopping; select: e : id_t; sync: appr[e]?; do: enqueue(e)
        Stopping -> Occ; sync: stop[list[len - 1]]!
        Occ -> Free; select: e : id_t; guard: e == list[0]; sync: leave[e]?; do: dequeue()"""
    declarations = f"""const int N = {n}; typedef int[0,N-1] id_t;
        chan appr[N], stop[N], leave[N]; urgent chan go[N]; id_t list[N + 1]; int[0,N] len;
        void enqueue(id_t e) {{ list[len] = e; len++; }}
        void dequeue() {{ int i; for (i = 0; i < len - 1; i++) list[i] = list[i + 1]; len--; list[len] = 0; }}"""
    return network(declarations, train, gate)


def bridge() -> Network:
    """Four people, one torch, a bridge for two: 5, 10, 20 and 25 minutes (Rote 2002)."""
    person = """Person(const int pace): own: clock y;
        here -> crossing; guard: side == 0; sync: take!; do: y = 0
        crossing -> there; guard: y >= pace; sync: put!
        there -> returning; guard: side == 1; sync: take!; do: y = 0
        returning -> here; guard: y >= pace; sync: put!"""
    torch = """Torch:
        free -> one; sync: take?
        one -> two; sync: take?
        one -> free; sync: put?; do: side = 1 - side
        two -> last; sync: put?
        last -> free; sync: put?; do: side = 1 - side"""
    system = "A = Person(5); B = Person(10); C = Person(20); D = Person(25); system A, B, C, D, Torch;"
    return network("chan take, put; int[0,1] side; clock time;", person, torch, system=system)


def doors() -> Network:
    """An air lock: two doors, never both open; a door that is waited for opens in time."""
    door = """Door(const int[0,1] id): own: clock x; | opening: x <= 6 | open: x <= 8 | closing: x <= 6
        closed -> waiting; guard: pushed[id]; sync: go!; do: x = 0
        waiting -> opening; guard: !busy; sync: go!; do: busy = true, x = 0
        opening -> open; guard: x >= 6; do: x = 0
        open -> closing; guard: x >= 4; do: x = 0
        closing -> closed; guard: x >= 6; do: busy = false, pushed[id] = false"""
    user = """User(const int[0,1] id): own: clock w;
        idle -> idle; guard: !pushed[id] && w >= 1; do: pushed[id] = true, w = 0"""
    hurry = "Hurry: on -> on; sync: go?"
    return network("bool busy; bool pushed[2]; urgent chan go;", door, user, hurry)


def csma_cd(n: int, *, delay: int = 26) -> Network:
    """Carrier sense with collision detection (Nicollin, Sifakis, Yovine 1992): 808 to send, 26 to be heard."""
    station = """S(const id_t id): own: clock x; | send: x <= 808 | retry: x < 2 * DELAY
        wait -> send; sync: begin!; do: x = 0
        wait -> wait; sync: cd?; do: x = 0
        wait -> retry; sync: cd?; do: x = 0
        wait -> retry; sync: busy!; do: x = 0
        send -> wait; guard: x == 808; sync: end!; do: x = 0
        send -> retry; sync: cd?; do: x = 0
        retry -> send; guard: x < 2 * DELAY; sync: begin!; do: x = 0
        retry -> retry; sync: cd?; do: x = 0
        retry -> retry; guard: x < 2 * DELAY; sync: busy!; do: x = 0"""
    bus = """Bus: own: clock y; | collision: y < DELAY
        idle -> active; sync: begin?; do: y = 0
        active -> collision; guard: y < DELAY; sync: begin?; do: y = 0
        active -> active; guard: y >= DELAY; sync: busy?
        active -> idle; sync: end?; do: y = 0
        collision -> idle; guard: y < DELAY; sync: cd!; do: y = 0"""
    declarations = f"""const int DELAY = {delay}; typedef int[1,{n}] id_t;
        chan begin, end, busy; broadcast chan cd;"""
    return network(declarations, station, bus)
