"""How the processes of a tool talk to each other: lines of JSON over a Unix socket.

One process serves a socket, and others connect to it. The line arbiter, the programs of a tool, a testbench and the
relays of buses and inputs all work like this. They differ in their messages, which each of them has in a table beside
its own code (pydantic checks them), and in what they do with a request.

**Who may connect.** A `Listener` makes the socket with mode 0660 in a folder that nobody else can write, for its user
and one group. A process that can open the socket may use it; there is no password. The socket appears under its path
only when clients can connect to it, and it disappears with its server.

**Messages.** A message is one line: a JSON object in UTF-8 and a line feed. There are three kinds of them. The server
sends a *record* to all clients that follow it::

    {"kind": "frame", "at": 815000000, "content": {…}}

A client sends a *request* with a number, and gets an *answer* with that number. A request has a time after which nobody
may execute it, in µs on the monotonic clock of the machine, because its sender stops waiting then::

    {"id": 7, "command": "grip", "until_us": 816000000}
    {"kind": "answer-to", "id": 7, "accepted": true, "reason": "", "decided": true, "record": 12}

An answer with the id null belongs to no request: the line was not valid. ``decided`` is false if the request may have
been executed although the answer does not say so. Where records are numbered, ``record`` is the number of the first one
that is certain to follow the execution: answers and records may overtake each other. The line arbiter has requests and
replies of its own (`end_effector_hal.arbiter.protocol`), since it answers every write in the order of priority and
without a queue. The relay of a bus sends the answers of its devices in the form that their codec reads.

**The server never waits for a client.** A `Peer` is one connection without any waiting: it reads what is there, and
keeps what cannot be sent yet. Everything is bounded by `ClientLimits`. If a client sends a line that is too long, or
too many lines in a second, its connection ends. If it does not read, its backlog grows up to the limit, and then its
connection ends. If all places are taken, a newcomer gets the place of the client that is furthest behind; if nobody is
behind, the newcomer is turned away. If this process has no file descriptor left, newcomers are turned away and
everybody else is served. None of this reaches the process around the server: the worst that it does is a line in the
log.

**Two ways to run a server.** A `Server` has a selector of its own, whose descriptor is readable when there is something
to do. A thread that already waits for other things adds this descriptor to them and calls `Server.poll`; the thread of
a bus does so. `Server.start` makes a thread that polls and calls a function after each look, which sends the records
and returns how long the next look may wait. A second thread executes the requests, one after the other. A few requests
of each client may wait for it; more are refused at once. `Server.wake` ends a wait from any thread.

**Records have a beginning.** If the records only make sense after a first state, the server is made with
``greets=True``: a newcomer gets nothing until `Server.begin` sends this state to all newcomers, and every record from
there on. A server that has lost records calls `Server.lose_all`, and all clients are newcomers again.

**Two clients.** `Client` blocks: it connects, sends a line, and waits for a line until its time-out. `ask` uses it for
one request. `aio.AsyncClient` lives in an asyncio loop: it connects again whenever the server is back, checks each
record by the table, passes it on, and awaits the answers to its requests. Both put every failure into a sentence.
"""

from ._client import Client, ask
from ._listener import Listener, no_socket
from ._messages import Reply, RpcRequest, record_line
from ._peers import Peer, Peers
from ._server import ClientLimits, Server
