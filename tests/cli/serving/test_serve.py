"""`tracerisk serve`: what its pages show, and to whom; the server is a real one."""

import json
import re
import shutil
import socket
import subprocess
import sys
import threading
import time
from contextlib import contextmanager
from dataclasses import replace
from html import unescape
from pathlib import Path
from urllib.parse import quote

import pytest

from tracerisk.adder.lock.lock import ControllerLock, Lock
from tracerisk.cli import main
from tracerisk.cli.parser import whole_parser
from tracerisk.cli.reviewers.serve import PORT
from tracerisk.cli.serving.model_changes import answer, choices_of, read_change
from tracerisk.cli.serving.server import Server
from tracerisk.cli.serving.site import Site
from tracerisk.common.hardware.model import Basis, Component, FailureFigure, Hardware
from tracerisk.pipeline.review.overview import overview

PICK = {
    "pick": ("place 1", "motor = 2e-6 x3; power = 1e-4 of2"),
    "place": ("done 1", "motor = 1e-6 x3"),
}


def write_lock(*names: str) -> None:
    lock = Lock()
    for name in names:
        lock = lock.with_controller(name, ControllerLock("run", {}))
    Path("tracerisk.lock").write_bytes(lock.dumps())


@pytest.fixture
def folder(tmp_path, annotated_source, monkeypatch):
    """A repository of two controllers that a lock knows; nothing of it was run."""
    monkeypatch.chdir(tmp_path)
    Path("cells").mkdir()
    Path("pick.py").write_text(annotated_source(**PICK))
    Path("cells/we ld.py").write_text(annotated_source(weld=("done 1", "torch = 3e-5")))
    write_lock("pick.py", "cells/we ld.py")
    return tmp_path


@contextmanager
def serving():
    with Server(Site(), 0) as server:
        thread = threading.Thread(target=server.serve_forever, kwargs={"poll_interval": 0.01})
        thread.start()
        try:
            yield server
        finally:
            server.shutdown()
            thread.join()


@pytest.fixture
def server(folder):
    with serving() as found:
        yield found


class Answer:
    """What came back over a raw connection."""

    def __init__(self, raw: bytes) -> None:
        head, _, self.body = raw.partition(b"\r\n\r\n")
        first, *lines = head.decode("latin-1").split("\r\n")
        self.status = int(first.split()[1]) if first.startswith("HTTP/") else 0
        self.headers = dict(line.split(": ", 1) for line in lines)

    @property
    def text(self) -> str:
        return self.body.decode()

    @property
    def json(self):
        return json.loads(self.body)


def send(server, raw: str | bytes) -> Answer:
    with socket.create_connection(("127.0.0.1", server.server_port), timeout=10) as connection:
        connection.sendall(raw.encode() if isinstance(raw, str) else raw)
        connection.shutdown(socket.SHUT_WR)
        parts = []
        while part := connection.recv(65536):
            parts.append(part)
    return Answer(b"".join(parts))


def get(server, path: str, *headers: str, method: str = "GET", host: str | None = None) -> Answer:
    host = f"127.0.0.1:{server.server_port}" if host is None else host
    lines = [f"{method} {path} HTTP/1.1", *([f"Host: {host}"] if host else []), *headers]
    return send(server, "\r\n".join((*lines, "", "")))


def solved(server, path: str) -> dict:
    found = get(server, path)
    assert found.status == 200, found.text
    return found.json


def test_the_first_page_has_every_controller_with_its_figure(server, folder):
    found = get(server, "/")
    assert found.status == 200
    assert '<a href="/controller/cells/we%20ld.py">' in found.text
    assert "3.000e-05" in found.text
    assert found.text.index("we ld.py") < found.text.index("pick.py")
    assert f"<b>{folder.name}</b>" in found.text


@pytest.mark.parametrize("kind", ["controller", "report"])
def test_a_controller_has_a_page_and_a_report(server, kind):
    found = get(server, f"/{kind}/cells/we%20ld.py")
    assert found.status == 200
    assert "3.000\xa0\N{MULTIPLICATION SIGN}\xa010⁻⁵" in found.text
    anchors = set(re.findall(r'href="#([^"]+)"', found.text))
    assert anchors <= set(re.findall(r' id="([^"]+)"', found.text))


def test_the_history_of_a_controller_is_shown_or_why_it_is_not(server, folder):
    assert get(server, "/history/pick.py").status == 422
    for words in (("init", "-q"), ("add", "-A"), ("commit", "-q", "-m", "Begin <it>")):
        identity = ("-c", "user.name=t", "-c", "user.email=t@t")
        subprocess.run(["git", *identity, *words], check=True, capture_output=True)
    found = get(server, "/history/pick.py")
    assert (found.status, "Begin &lt;it&gt;" in found.text) == (200, True)


def test_a_slider_gives_what_solve_gives(server, capsys):
    found = solved(server, "/what-if/pick.py?rate.motor=2.5")
    assert found["command"] == "tracerisk solve pick.py --set motor=x2.5"
    words = found["command"].split()[1:]
    assert main([*words, "--json"]) == 0
    mission = json.loads(capsys.readouterr().out)["assessment"]["mission"]
    assert found["after"] == mission["failure_probability"]
    assert found["ratio"] == pytest.approx(found["after"] / found["before"])
    assert found["after"] > 2.4 * found["before"]
    assert solved(server, "/what-if/pick.py")["ratio"] == 1.0


def test_redundancy_is_solved_by_the_model_of_blocks_that_say_so(server, annotated_source):
    found = solved(server, "/what-if/pick.py?units.power=2of2")
    # Both power units are needed: 2e-4, where both had to fail.
    assert found["after"] - found["before"] == pytest.approx(2e-4 - 1e-8, rel=1e-3)
    assert found["command"] == ""
    one_more = solved(server, "/what-if/pick.py?units.motor=3of4&rate.motor=10")
    assert one_more["after"] < found["before"]
    assert "fail independently" in " ".join(one_more["assumptions"])


@pytest.mark.parametrize(
    ("query", "expected"),
    [
        ("rate.moter=2", "no component 'moter'; did you mean 'motor'"),
        ("rate.motor=0", "'0' is no factor; allowed: 0.001 to 1000"),
        ("rate.motor=nan", "is no factor"),
        ("rate.motor=1e400", "is no factor"),
        ("rate.motor=2&rate.motor=3", "given 2 times"),
        ("units.motor=9of9", "units.motor: '9of9'; allowed:"),
        ("units.motor=", "units.motor: ''"),
        ("speed=2", "speed cannot be changed here"),
        ("payload=2", "unknown: payload; allowed: rate.NAME, units.NAME, speed"),
        ("&&", "the query cannot be read"),
        ("&".join(f"rate.a{n}=1" for n in range(300)), "the query cannot be read"),
    ],
)
def test_a_change_that_cannot_be_is_refused_with_its_reason(server, query, expected):
    found = get(server, f"/what-if/pick.py?{query}")
    assert found.status == 400
    assert expected in found.json["error"]


def test_what_blocks_do_not_say_is_not_offered_and_the_page_says_so(server):
    page = get(server, "/controller/pick.py").text
    assert "Payload is not offered" in page
    assert "Speed is not offered: the hardware data behind the blocks is not known here" in page
    assert 'data-query="speed"' not in page
    assert 'data-query="rate.motor"' in page


@pytest.mark.parametrize(
    "host",
    [
        "evil.example",
        "127.0.0.1",
        "127.0.0.1:1",
        "evil.example:{port}",
        "127.0.0.1.evil.example:{port}",
        "[::1]:{port}",
        "0.0.0.0:{port}",
        "",
    ],
)
def test_another_host_is_refused(server, host):
    found = get(server, "/", host=host.format(port=server.server_port))
    assert found.status == 421
    assert "pick.py" not in found.text


def test_two_hosts_are_refused(server):
    own = f"Host: 127.0.0.1:{server.server_port}"
    assert get(server, "/", "Host: evil.example").status == 421
    assert get(server, "/", own).status == 421


@pytest.mark.parametrize(
    "headers",
    [
        ("Origin: https://evil.example",),
        ("Origin: null",),
        ("Origin: http://127.0.0.1",),
        ("Origin: https://127.0.0.1:{port}",),
        ("Origin: http://127.0.0.1:{port}", "Origin: https://evil.example"),
        ("Sec-Fetch-Site: cross-site", "Sec-Fetch-Mode: no-cors"),
        ("Sec-Fetch-Site: same-site", "Sec-Fetch-Mode: cors"),
    ],
)
@pytest.mark.parametrize("path", ["/", "/state", "/what-if/pick.py?rate.motor=2"])
def test_a_page_of_another_site_gets_nothing(server, headers, path):
    reported = [each.format(port=server.server_port) for each in headers]
    found = get(server, path, *reported)
    assert found.status == 403
    assert "Access-Control-Allow-Origin" not in found.headers
    assert b"pick.py" not in found.body


def test_own_pages_and_links_from_elsewhere_are_answered(server):
    port = server.server_port
    for host in ("127.0.0.1", "localhost"):
        origin = f"Origin: http://{host}:{port}"
        assert get(server, "/state", origin, host=f"{host}:{port}").status == 200
    link = ("Sec-Fetch-Site: cross-site", "Sec-Fetch-Mode: navigate")
    assert get(server, "/", *link).status == 200


@pytest.mark.parametrize("method", ["POST", "PUT", "DELETE", "PATCH", "OPTIONS", "TRACE", "BREW"])
def test_nothing_can_be_written(server, folder, method):
    before = {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}
    found = get(server, "/controller/pick.py", "Content-Length: 0", method=method)
    assert (found.status, found.headers["Allow"]) == (405, "GET, HEAD")
    assert {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()} == before


def test_the_head_of_a_page_is_sent_without_it(server):
    found = get(server, "/", method="HEAD")
    assert (found.status, found.body) == (200, b"")
    assert int(found.headers["Content-Length"]) == len(get(server, "/").body)


@pytest.mark.parametrize(
    "path",
    [
        "/files/../secret.html", "/files/%2e%2e/secret.html", "/files/..%2fsecret.html",
        "/files//etc/passwd", "/files/%2fetc/passwd", "/files/out.html", "/files/inside/../x.html",
        "/files/pick.py", "/files/tracerisk.lock", "/files/plain.html", "/files/.git/x.html",
        "/files/a%00.html", "/files/", "/files", "/files/cells", "/controller/../secret.html",
        "/report/%2e%2e%2fsecret.html", "/history//etc/passwd", "/what-if/..%2f..%2fetc%2fpasswd",
        "//evil.example/", "/%ff%fe", "/[", "/controller/[::1", "/files/%5b.html", "/controller/" + "a" * 5000,
    ],
)  # fmt: skip
def test_no_path_leads_to_what_is_no_page(server, folder, path):
    secret = folder.parent / "secret.html"
    page = b'<meta name="generator" content="tracerisk">TOP SECRET'
    secret.write_bytes(page)
    (folder / "plain.html").write_bytes(b"TOP SECRET")
    (folder / ".git").mkdir()
    (folder / ".git/x.html").write_bytes(page)
    (folder / "out.html").symlink_to(secret)
    found = get(server, path)
    assert found.status == (200 if path == "//evil.example/" else 404) or b"evil" not in found.body
    assert b"SECRET" not in found.body
    assert b"root:" not in found.body


def test_a_report_of_the_repository_is_shown_and_can_ask_for_nothing(server, folder):
    assert main(["report", "pick.py", "-o", "pick.html", "--quiet"]) == 0
    page = get(server, "/").text
    assert '<a href="/files/pick.html">' in page
    found = get(server, "/files/pick.html")
    assert found.body == (folder / "pick.html").read_bytes()
    policy = found.headers["Content-Security-Policy"]
    assert policy.startswith("sandbox allow-scripts; default-src 'none'")
    assert "connect-src" not in policy


@pytest.mark.parametrize(
    "raw",
    [
        b"", b"\r\n\r\n", b"GET\r\n\r\n", b"GET / HTTP/9.9\r\n\r\n", b"\x16\x03\x01\x02\x00\x01",
        b"GET http://evil.example/ HTTP/1.1\r\nHost: evil.example\r\n\r\n",
        b"GET / HTTP/1.1\r\n" + b"X: y\r\n" * 500 + b"\r\n",
        b"GET /" + b"a" * 70_000 + b" HTTP/1.1\r\n\r\n",
        b"GET / HTTP/1.1\r\nHost: \xff\xfe\r\n\r\n",
        b"GET /\x00 HTTP/1.1\r\nHost: x\r\n\r\n",
    ],
)  # fmt: skip
def test_what_is_no_request_is_refused_and_ends_nothing(server, raw):
    found = send(server, raw)
    assert found.status in (0, 400, 414, 421, 431, 505)
    assert b"pick.py" not in found.body
    assert get(server, "/").status == 200


def test_every_page_has_a_policy_that_lets_only_its_own_script_run(server):
    for path in ("/", "/controller/pick.py", "/report/pick.py", "/nope", "/history/pick.py"):
        found = get(server, path)
        policy = found.headers["Content-Security-Policy"]
        assert "default-src 'none'; script-src 'sha256-" in policy
        assert "'unsafe" not in policy
        assert policy.endswith("frame-ancestors 'none'")
        assert found.headers["X-Content-Type-Options"] == "nosniff"
        assert "Access-Control-Allow-Origin" not in found.headers


def test_names_and_messages_are_escaped(server, folder, annotated_source):
    name = "<img src=x onerror=alert(1)>.py"
    write_lock("pick.py", name)
    Path(name).write_text(annotated_source(**PICK))
    for path in (
        "/",
        f"/controller/{quote(name)}",
        f"/report/{quote(name)}",
        f"/nope/{quote(name)}",
    ):
        found = get(server, path)
        assert b"<img" not in found.body
    assert name in unescape(get(server, "/").text)


def test_a_broken_a_deleted_and_a_restored_file_are_each_reported(server, folder):
    good = Path("pick.py").read_text()
    states = [get(server, "/state").json["state"]]
    for text, reported in (
        (good.replace("quantity = 3", "quantity = three"), "quantity = three is not allowed"),
        (good[: len(good) // 2], ""),
        ("def (", "pick.py"),
        (None, "cannot be read: No such file"),
    ):
        if text is None:
            Path("pick.py").unlink()
        else:
            Path("pick.py").write_text(text)
        found = get(server, "/")
        assert found.status == 200
        assert reported in unescape(found.text)
        assert "3.000e-05" in found.text, "the other one is still shown"
        assert get(server, "/controller/pick.py").status in (200, 422)
        assert get(server, "/what-if/pick.py?rate.motor=2").status in (200, 400)
        states.append(get(server, "/state").json["state"])
    assert len(set(states)) == len(states)
    Path("pick.py").write_text(good)
    assert solved(server, "/what-if/pick.py?rate.motor=2")["after"] > 0.0


def test_a_broken_lock_is_reported_until_it_is_whole_again(server, folder):
    good = Path("tracerisk.lock").read_text()
    for text in ("{", "[]", good[:100], ""):
        Path("tracerisk.lock").write_text(text)
        found = get(server, "/")
        assert found.status == 422, text
        assert "tracerisk.lock" in found.text
        assert get(server, "/state").status == 200
    Path("tracerisk.lock").write_text(good)
    assert get(server, "/").status == 200


def test_a_controller_of_a_lock_outside_of_the_folder_is_not_read(server, folder, annotated_source):
    secret = folder.parent / "outside.py"
    secret.write_text(annotated_source(withheld=("done 1", "gripper = 1e-7")))
    lock = json.loads(Path("tracerisk.lock").read_text())
    lock["controllers"]["../outside.py"] = lock["controllers"]["pick.py"]
    Path("tracerisk.lock").write_text(json.dumps(lock))
    for path in ("/", "/report/../outside.py", "/controller/..%2foutside.py"):
        assert "withheld" not in get(server, path).text


def test_two_that_ask_at_once_while_files_are_saved_all_get_an_answer(server, folder):
    good = Path("pick.py").read_text()
    ended = threading.Event()
    wrong: list[object] = []

    def ask(path: str) -> None:
        while not ended.is_set():
            found = get(server, path)
            if found.status not in (200, 400, 422):
                wrong.append((path, found.status))

    paths = ("/", "/what-if/pick.py?rate.motor=2", "/controller/pick.py", "/state")
    askers = [threading.Thread(target=ask, args=(path,)) for path in paths]
    for each in askers:
        each.start()
    try:
        until = time.monotonic() + 1.0
        number = 0
        while time.monotonic() < until:
            number += 1
            # As editors do: written in place, replaced, cut short, removed.
            if number % 4 == 0:
                Path("pick.py").unlink()
            Path("new.py").write_text(good if number % 3 else good[: number % len(good)])
            Path("new.py").replace("pick.py")
    finally:
        ended.set()
        for each in askers:
            each.join()
    assert wrong == []
    Path("pick.py").write_text(good)
    found = solved(server, "/what-if/pick.py?rate.motor=2")
    assert found["ratio"] > 1.9


def test_no_page_waits_for_a_slow_what_if(server, monkeypatch):
    asked, shown = threading.Event(), threading.Event()
    path = "/what-if/pick.py?rate.motor=3"
    expected = solved(server, path)

    def late(*arguments):
        asked.set()
        assert shown.wait(10)
        return answer(*arguments)

    monkeypatch.setattr("tracerisk.cli.serving.site.answer", late)
    answers = []
    threads = [
        threading.Thread(target=lambda: answers.append(get(server, path).json)) for _ in range(2)
    ]
    for each in threads:
        each.start()
    assert asked.wait(10)
    for page in ("/", "/controller/pick.py", "/report/pick.py", "/state"):
        assert get(server, page).status == 200
    shown.set()
    for each in threads:
        each.join()
    assert answers == [expected, expected]


def test_it_listens_to_this_machine_alone(server):
    assert server.server_address[0] == "127.0.0.1"
    addresses = {
        each[4][0] for each in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)
    }
    for address in addresses - {"127.0.0.1", "127.0.1.1"}:
        with pytest.raises(OSError, match=r"refused|timed out"):
            socket.create_connection((address, server.server_port), timeout=2).close()


def test_a_port_that_is_taken_is_reported(server, folder, capsys):
    assert main(["serve", "--port", str(server.server_port)]) == 2
    assert f"port {server.server_port} of 127.0.0.1 cannot be had" in capsys.readouterr().err
    assert main(["serve", "nowhere"]) == 2
    assert "is no folder; name a repository" in capsys.readouterr().err
    with pytest.raises(SystemExit):
        main(["serve", "--port", "99999"])
    assert "'99999' is no port; allowed: 0 to 65535" in capsys.readouterr().err


def test_the_command_prints_its_address_and_ends_by_an_interrupt(folder):
    command = [sys.executable, "-m", "tracerisk", "serve", "--port", "0"]
    with subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        url = running.stdout.readline().strip()
        found = re.fullmatch(r"http://127\.0\.0\.1:(\d+)/", url)
        assert found is not None
        with socket.create_connection(("127.0.0.1", int(found[1])), timeout=10):
            pass
        running.send_signal(2)
        assert running.wait(10) == 130
        assert running.stderr is not None
        assert "Traceback" not in running.stderr.read()


@pytest.fixture(scope="module")
def browsers():
    """Two browsers, neither of which knows of the other."""
    webdriver = pytest.importorskip("selenium.webdriver", reason="selenium is not installed")
    chromium = next(filter(None, map(shutil.which, ("chromium", "chromium-browser"))), None)
    driver = shutil.which("chromedriver")
    if chromium is None or driver is None:
        pytest.skip("Chromium and its driver are not installed")
    started = []
    try:
        for _ in range(2):
            options = webdriver.ChromeOptions()
            options.binary_location = chromium
            for word in (
                "--headless=new",
                "--no-sandbox",
                "--disable-gpu",
                "--window-size=1400,1000",
            ):
                options.add_argument(word)
            options.set_capability("goog:loggingPrefs", {"browser": "ALL"})
            service = webdriver.ChromeService(driver)
            started.append(webdriver.Chrome(options=options, service=service))
        yield started
    finally:
        for each in started:
            each.quit()


@pytest.mark.slow
def test_in_two_browsers_a_slider_solves_at_once_and_a_save_shows_in_both(server, browsers, folder):
    from selenium.webdriver.support.wait import WebDriverWait

    def shown(browser, part):
        return browser.execute_script(
            f"return document.querySelector('[data-answer={part}]').textContent"
        )

    first, second = browsers
    for each in browsers:
        each.get(f"{server.url}controller/pick.py")
        WebDriverWait(each, 10).until(lambda it: shown(it, "ratio") == "as it is")
    move = """
        const slider = document.querySelector('[data-query="rate.motor"]');
        slider.value = Math.log10(2);
        slider.dispatchEvent(new Event('input', {bubbles: true}));
    """
    first.execute_script(move)
    WebDriverWait(first, 5).until(lambda it: shown(it, "ratio").startswith("x2 of"))
    assert shown(first, "command") == "tracerisk solve pick.py --set motor=x2"
    assert first.current_url.endswith("?rate.motor=2")
    assert shown(second, "ratio") == "as it is"
    # A link holds the change.
    second.get(first.current_url)
    WebDriverWait(second, 10).until(lambda it: shown(it, "ratio").startswith("x2 of"))
    figure = shown(first, "after")
    good = Path("pick.py").read_text()
    Path("pick.py").write_text(good.replace("2e-06", "8e-06").replace("2e-6", "8e-6"))
    assert Path("pick.py").read_text() != good
    for each in browsers:
        WebDriverWait(each, 10).until(
            lambda it: shown(it, "after") not in (figure, "\N{EN DASH}"), "the save shows"
        )
        assert each.current_url.endswith("?rate.motor=2")
    first.execute_script("document.querySelector('.what-if [type=reset]').click()")
    WebDriverWait(first, 5).until(lambda it: shown(it, "ratio") == "as it is")
    for each in browsers:
        assert each.get_log("browser") == []


@pytest.mark.slow
@pytest.mark.parametrize("width", [400, 1400])
@pytest.mark.parametrize("scheme", ["light", "dark"])
def test_axe_finds_nothing_serious_on_any_page(server, browsers, scheme, width):
    axe = pytest.importorskip("selenium_axe_python", reason="selenium-axe-python is missing").Axe
    browser = browsers[0]
    features = [{"name": "prefers-color-scheme", "value": scheme}]
    browser.execute_cdp_cmd("Emulation.setEmulatedMedia", {"features": features})
    metrics = {"width": width, "height": 900, "deviceScaleFactor": 1, "mobile": width < 500}
    browser.execute_cdp_cmd("Emulation.setDeviceMetricsOverride", metrics)
    # The page's policy lets no other script run; the checker is one.
    browser.execute_cdp_cmd("Page.setBypassCSP", {"enabled": True})
    for path in ("", "controller/pick.py", "report/pick.py", "nope"):
        browser.get(f"{server.url}{path}")
        assert browser.execute_script("return document.documentElement.scrollWidth") <= width
        checker = axe(browser)
        checker.inject()
        found = checker.run()["violations"]
        serious = [each for each in found if each["impact"] in ("serious", "critical")]
        assert not serious, (path, axe.report(found))


@pytest.mark.slow
def test_a_page_of_another_site_cannot_read_this_one(server, browsers, folder):
    from http.server import BaseHTTPRequestHandler, HTTPServer

    class Foreign(BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.end_headers()
            self.wfile.write(b"<title>foreign</title>")

        def log_message(self, *_):
            pass

    with HTTPServer(("127.0.0.1", 0), Foreign) as foreign:
        thread = threading.Thread(target=foreign.serve_forever)
        thread.start()
        try:
            browser = browsers[1]
            browser.get(f"http://localhost:{foreign.server_port}/")
            reported = browser.execute_async_script(
                "const done = arguments[1];"
                "fetch(arguments[0]).then((r) => r.text()).then(done, (e) => done(`refused: ${e}`))",
                f"{server.url}what-if/pick.py",
            )
            assert reported.startswith("refused")
            framed = browser.execute_async_script(
                "const done = arguments[1], frame = document.createElement('iframe');"
                "frame.onload = () => { try { done(frame.contentDocument.body.textContent) }"
                " catch (e) { done(`refused: ${e.name}`) } };"
                "frame.src = arguments[0]; document.body.append(frame)",
                server.url,
            )
            assert "pick.py" not in (framed or "")
        finally:
            foreign.shutdown()
            thread.join()


def test_speed_changes_what_counts_time_in_use_and_nothing_else(folder, annotated_source):
    source = annotated_source(
        go=("done 1", "motor = 4e-6; gripper = 3e-6; torch := 2e-6; fan = 1e-6; unknown = 1e-7")
    )
    Path("pick.py").write_text(source)
    hour, demand = (
        FailureFigure("failure_rate", 1e-3, each) for each in (Basis.HOUR, Basis.DEMAND)
    )
    hardware = Hardware(
        "hardware.yaml",
        (
            Component("motor", (hour,)),
            Component("gripper", (hour, replace(demand, kind="probability"))),
            Component("torch", (hour,)),
            Component("fan", (replace(hour, standby=True),)),
        ),
    )
    (_, known) = overview(Path())
    choices = choices_of(known, hardware)
    assert [each.name for each in choices.components if each.by_time] == ["motor"]
    assert choices.notes[1].startswith("Speed leaves ")
    found = answer(known, choices, read_change({"speed": ["2"]}, choices), "pick.py")
    assert found.command == "tracerisk solve pick.py --set motor=x0.5"
    less = found.before.mission.failure_probability - found.after.mission.failure_probability
    assert less == pytest.approx(2e-6, rel=1e-4)
    (reported,) = found.assumptions
    assert "no torque grows with the speed" in reported
    none = choices_of(known, replace(hardware, components=hardware.components[1:]))
    assert (none.has_speed, "no component has figures by time" in none.notes[1]) == (False, True)
    assert choices_of(known, hardware).has_speed


def test_no_page_loads_what_only_a_run_needs(folder):
    script = """
import sys
from tracerisk.cli.serving.site import Site
site = Site()
for path in ("/", "/controller/pick.py", "/report/pick.py", "/state"):
    assert site.reply(path, "").status == 200, path
assert site.reply("/what-if/pick.py", "rate.motor=2").status == 200
heavy = {"mujoco", "dm_control", "libcst", "numpy", "scipy"} & set(sys.modules)
sys.exit(f"loaded: {heavy}" if heavy else 0)
"""
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr


def test_a_lock_that_is_new_below_shows_on_the_first_page(server, annotated_source):
    get(server, "/")
    Path("more").mkdir()
    Path("more/late.py").write_text(annotated_source(late=("done 1", "gripper = 1e-7")))
    lock = Lock().with_controller("late.py", ControllerLock("run", {}))
    Path("more/tracerisk.lock").write_bytes(lock.dumps())
    assert "/controller/more/late.py" in get(server, "/").text
    assert solved(server, "/what-if/more/late.py?rate.gripper=2")["ratio"] == pytest.approx(2.0)


def test_without_a_controller_the_page_says_what_writes_one(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with serving() as server:
        found = get(server, "/")
        assert found.status == 422
        assert "`tracerisk run FILE` writes one" in found.text
        assert get(server, "/state").status == 200


def test_the_commands_of_the_documentation_are_those_of_the_verb():
    text = (Path(__file__).parents[3] / "docs/serve.md").read_text(encoding="utf-8")
    (block,) = re.findall(r"^```sh\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    given = [whole_parser().parse_args(line.split()[1:]) for line in block.splitlines()]
    assert [(each.folder, each.port) for each in given] == [(".", PORT), ("../cell", 9000)]
    assert f"127.0.0.1:{PORT}/" in text
