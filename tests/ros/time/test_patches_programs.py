"""Programs that a controller starts: however slow they are, it sees them at the same instants."""

import asyncio
import concurrent.futures
import http.client
import http.server
import multiprocessing
import multiprocessing.connection
import os
import signal
import socket
import subprocess
import sys
import threading
import time

import pytest

SECOND = 1_000_000_000
LATE_S = 0.25
"""How long a program takes that answers late: longer than a machine needs for the others."""


def program(text, **how):
    return subprocess.Popen([sys.executable, "-c", text], text=True, **how)


def said_by(process):
    return process.stdout.readline().strip()


def a_server_of_http_answers():
    serving = program(
        "import http.server\n"
        "class Handler(http.server.BaseHTTPRequestHandler):\n"
        "  def do_GET(self):\n"
        "    self.send_response(200); self.end_headers(); self.wfile.write(self.path.encode())\n"
        "  def log_message(self, *_): pass\n"
        "server = http.server.HTTPServer(('127.0.0.1', 0), Handler)\n"
        "print(server.server_port, flush=True); server.serve_forever()",
        stdout=subprocess.PIPE,
    )
    answers = []
    try:
        at = int(said_by(serving))
        for number in range(3):
            connection = http.client.HTTPConnection("127.0.0.1", at, timeout=5)
            connection.request("GET", f"/{number}")
            answers.append(connection.getresponse().read())
            connection.close()
            time.sleep(0.02)
    finally:
        serving.kill()
        serving.wait()
    return answers


def a_program_asks_a_server_in_a_thread():
    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.end_headers()
            time.sleep(0.1)
            self.wfile.write(b"%d" % (time.time_ns() // 1_000_000 % 1000))

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    threading.Thread(target=server.serve_forever, daemon=True).start()
    text = (
        "import urllib.request\n"
        f"print(urllib.request.urlopen('http://127.0.0.1:{server.server_port}').read())"
    )
    return subprocess.run(
        [sys.executable, "-c", text], capture_output=True, text=True, timeout=30
    ).stdout


def a_program_asks_a_loop_in_a_thread():
    async def answer(reader, writer):
        question = await reader.readline()
        await asyncio.sleep(0.1)
        writer.write(question.upper())
        await writer.drain()
        writer.close()

    async def serve():
        server = await asyncio.start_server(answer, sock=listening)
        await server.serve_forever()

    listening = socket.create_server(("127.0.0.1", 0))
    threading.Thread(target=lambda: asyncio.run(serve()), daemon=True).start()
    text = (
        "import socket\n"
        f"end = socket.create_connection({listening.getsockname()!r})\n"
        "end.sendall(b'abc\\n'); print(end.recv(99))"
    )
    return subprocess.run([sys.executable, "-c", text], capture_output=True, text=True).stdout


def a_server_of_asyncio_answers():
    free = socket.create_server(("127.0.0.1", 0))
    at = free.getsockname()[1]
    free.close()
    serving = program(
        "import asyncio\n"
        "async def answer(reader, writer):\n"
        "  while line := await reader.readline():\n"
        "    await asyncio.sleep(0.02); writer.write(line.upper()); await writer.drain()\n"
        "async def main():\n"
        f"  server = await asyncio.start_server(answer, '127.0.0.1', {at})\n"
        "  await server.serve_forever()\n"
        "asyncio.run(main())"
    )

    async def ask():
        tries = 0
        while True:
            try:
                reader, writer = await asyncio.open_connection("127.0.0.1", at)
                break
            except ConnectionRefusedError:
                tries += 1
                await asyncio.sleep(0.05)
        answers = [tries]
        for number in range(3):
            writer.write(b"a%d\n" % number)
            answers.append(await asyncio.wait_for(reader.readline(), 10))
        writer.close()
        return answers

    try:
        return asyncio.run(ask())
    finally:
        serving.terminate()
        serving.wait(timeout=10)


def a_program_of_asyncio_answers():
    async def ask():
        process = await asyncio.create_subprocess_exec(
            *(sys.executable, "-c", "print(input().upper())"),
            stdin=asyncio.subprocess.PIPE,
            stdout=asyncio.subprocess.PIPE,
        )
        return (await process.communicate(b"abc\n"))[0], process.returncode

    return asyncio.run(ask())


def a_pair_of_sockets_leads_to_a_program():
    ours, theirs = socket.socketpair()
    answering = program(
        "import socket, time\n"
        f"end = socket.socket(fileno={theirs.fileno()})\n"
        f"while part := end.recv(99): time.sleep({LATE_S} / 4); end.sendall(part * 2)",
        pass_fds=[theirs.fileno()],
    )
    answers = []
    ours.settimeout(3)
    for number in range(4):
        ours.sendall(b"%d" % number)
        answers.append(ours.recv(99))
    ours.close()
    theirs.close()
    return answers, answering.wait()


def a_pipe_leads_to_a_program():
    ours, theirs = os.pipe()
    answering = program(
        f"import os, time\ntime.sleep({LATE_S}); os.write({theirs}, b'x' * 99)", pass_fds=[theirs]
    )
    os.close(theirs)
    answer = os.read(ours, 999), os.read(ours, 999)
    os.close(ours)
    return answer, answering.wait()


def a_connection_of_multiprocessing_leads_to_a_program():
    with multiprocessing.connection.Listener(("127.0.0.1", 0), authkey=b"k") as listener:
        asking = program(
            "import multiprocessing.connection as c, time\n"
            f"time.sleep({LATE_S})\n"
            f"with c.Client({listener.address!r}, authkey=b'k') as end:\n"
            "  for number in range(3): end.send([number]); assert end.recv() == -number"
        )
        answers = []
        with listener.accept() as end:
            for _ in range(3):
                answers.append(end.recv())
                end.send(-answers[-1][0])
        return answers, asking.wait()


def queues_and_pools_need_no_program():
    with multiprocessing.Manager() as manager:
        queue, shared = manager.Queue(), manager.dict()
        process = multiprocessing.Process(target=lambda: (time.sleep(0.1), queue.put(5)))
        process.start()
        shared["a"] = queue.get()
        process.join()
        with concurrent.futures.ProcessPoolExecutor(2) as pool:
            return dict(shared), list(pool.map(abs, [-1, -2]))


def a_program_answers_late():
    answering = program(
        f"import time\nfor n in range(3): time.sleep({LATE_S}); print(n, flush=True)",
        stdout=subprocess.PIPE,
    )
    return [said_by(answering) for _ in range(4)], answering.wait(timeout=5)


def a_program_never_answers():
    silent = program("import signal\nsignal.pause()", stdout=subprocess.PIPE)
    try:
        silent.wait(timeout=0.2)
    except subprocess.TimeoutExpired as error:
        said = str(error.timeout)
    silent.terminate()
    return said, silent.wait(timeout=5), silent.stdout.read()


def a_program_dies():
    ours, theirs = socket.socketpair()
    dying = program(
        f"import os, time\ntime.sleep({LATE_S}); os.kill(os.getpid(), 9)",
        pass_fds=[theirs.fileno()],
        stderr=subprocess.PIPE,
    )
    theirs.close()
    return ours.recv(9), dying.stderr.read(), dying.wait()


def a_program_is_polled():
    computing = program("sum(range(3_000_000))")
    looks = 0
    while computing.poll() is None:
        looks += 1
        time.sleep(0.1)
    return looks


EXPECTED = {
    a_server_of_http_answers: ([b"/0", b"/1", b"/2"], 0.06),
    a_program_asks_a_server_in_a_thread: ("b'100'\n", 0.1),
    a_program_asks_a_loop_in_a_thread: ("b'ABC\\n'\n", 0.1),
    a_server_of_asyncio_answers: ([0, b"A0\n", b"A1\n", b"A2\n"], 0.0),
    a_program_of_asyncio_answers: ((b"ABC\n", 0), 0.0),
    a_pair_of_sockets_leads_to_a_program: (([b"00", b"11", b"22", b"33"], 0), 0.0),
    a_pipe_leads_to_a_program: (((b"x" * 99, b""), 0), 0.0),
    a_connection_of_multiprocessing_leads_to_a_program: (([[0], [1], [2]], 0), 0.0),
    queues_and_pools_need_no_program: (({"a": 5}, [1, 2]), 0.1),
    a_program_answers_late: ((["0", "1", "2", ""], 0), 0.0),
    a_program_never_answers: (("0.2", -signal.SIGTERM, ""), 0.2),
    a_program_dies: ((b"", "", -signal.SIGKILL), 0.0),
    a_program_is_polled: (0, 0.0),
}


@pytest.mark.slow(but=4)
@pytest.mark.parametrize("ask", EXPECTED, ids=lambda ask: ask.__name__)
def test_a_controller_sees_a_program_at_the_same_instant(run, scheduler, ask):
    """While another of its threads waits for time alone, which could pass meanwhile."""
    ticks = []

    def tick():
        while True:
            time.sleep(0.01)
            ticks.append(scheduler.now_ns)

    def main():
        threading.Thread(target=tick, daemon=True).start()
        time.sleep(0.0)
        result = ask()
        return result, scheduler.now_ns

    result, took_ns = run(main)
    expected, expected_s = EXPECTED[ask]
    assert result == expected
    assert took_ns / SECOND == pytest.approx(expected_s, abs=0.001)
    assert len(ticks) == took_ns // 10_000_000
