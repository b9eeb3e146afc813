"""What libraries do works in a contained controller, and gives the same as outside."""

import importlib.util
import re
import socket

import pytest

from tests.slow import slow_but
from tracerisk.api import trace_controller
from tracerisk.common.sandbox.kernel.features import offers_own_network, support
from tracerisk.config import Settings
from tracerisk.pipeline.workspace.controller import load_controller

# By the module that is imported: a small use, of which the last line is an expression.
OF_PYTHON = {
    "asyncio": """
async def main():
    await asyncio.sleep(0.01)
    process = await asyncio.create_subprocess_exec("echo", "x", stdout=asyncio.subprocess.PIPE)
    out, _ = await process.communicate()
    return out, await asyncio.get_running_loop().run_in_executor(None, lambda: 7)
asyncio.run(main())""",
    "bz2": "len(bz2.decompress(bz2.compress(bytes(99))))",
    "concurrent.futures": """
with concurrent.futures.ThreadPoolExecutor(3) as pool:
    result = list(pool.map(abs, range(-5, 5)))
result""",
    "csv": "list(csv.reader(['a,b']))",
    "ctypes": "ctypes.CDLL(None).abs(-3), ctypes.CFUNCTYPE(ctypes.c_int)(lambda: 5)()",
    "ctypes.util": "ctypes.util.find_library('m')",
    "dbm": """
import os, tempfile
with dbm.open(os.path.join(tempfile.mkdtemp(), "d"), "c") as store:
    store["a"] = "b"
    result = store["a"]
result""",
    "fcntl": "import tempfile\nwith tempfile.TemporaryFile() as f: fcntl.flock(f, fcntl.LOCK_EX); fcntl.lockf(f, fcntl.LOCK_EX)\n0",
    "getpass": "getpass.getuser()",
    "hashlib": "hashlib.sha256(b'x').hexdigest(), hashlib.scrypt(b'a', salt=b'b', n=2, r=1, p=1)",
    "locale": "locale.setlocale(locale.LC_ALL, 'C')",
    "logging.handlers": """
import os, tempfile
name = os.path.join(tempfile.mkdtemp(), "log")
handler = logging.handlers.RotatingFileHandler(name, maxBytes=20, backupCount=2)
for number in range(5): handler.emit(logging.makeLogRecord({"msg": "abcdefghij"}))
handler.close()
sorted(os.listdir(os.path.dirname(name)))""",
    "lzma": "len(lzma.decompress(lzma.compress(bytes(99))))",
    "mmap": "m = mmap.mmap(-1, 99)\nm[:2] = b'ab'\nm[:2]",
    "multiprocessing": """
with multiprocessing.get_context("fork").Pool(2) as pool: result = pool.map(abs, [-1, 2])
queue, lock, value = multiprocessing.Queue(), multiprocessing.Lock(), multiprocessing.Value("i", 3)
queue.put(4)
with lock: result += [queue.get(timeout=5), value.value]
result""",
    "os": """
ours, theirs = os.pipe()
os.write(theirs, b"x")
child = os.posix_spawn("/bin/true", ["true"], {})
os.read(ours, 1), os.waitpid(child, 0)[1], os.umask(0o22) >= 0, os.cpu_count() > 0, len(os.getrandom(3))""",
    "pathlib": "sorted(p.suffix for p in pathlib.Path(__file__).parent.iterdir())",
    "pickle": "pickle.loads(pickle.dumps({1: 2}))",
    "platform": "platform.machine(), platform.system()",
    "pwd": "pwd.getpwuid(0).pw_name",
    "queue": "q = queue.Queue()\nq.put(1)\nq.get()",
    "random": "random.Random(1).random(), len(random.SystemRandom().randbytes(5))",
    "resource": "resource.setrlimit(resource.RLIMIT_CORE, (0, 0)), resource.getrusage(0).ru_nvcsw >= 0",
    "select": """
import os
ours, theirs = os.pipe()
poll, epoll = select.poll(), select.epoll()
poll.register(ours); epoll.register(ours, select.EPOLLIN)
os.write(theirs, b"x")
len(poll.poll(99)), len(epoll.poll(1)), len(select.select([ours], [], [], 1)[0])""",
    "shutil": """
import os, tempfile
folder = tempfile.mkdtemp()
for name in "ab": open(os.path.join(folder, name), "w").write(name)
shutil.copy2(os.path.join(folder, "a"), os.path.join(folder, "c"))
shutil.make_archive(os.path.join(folder, "z"), "zip", folder)
shutil.move(os.path.join(folder, "a"), os.path.join(folder, "d"))
shutil.copytree(folder, folder + "2")
shutil.disk_usage(folder).total > 0, sorted(os.listdir(folder + "2"))""",
    "signal": """
seen = []
signal.signal(signal.SIGUSR2, lambda *_: seen.append(1))
signal.raise_signal(signal.SIGUSR2)
import os; os.kill(os.getpid(), signal.SIGUSR2)
seen""",
    "socket": """
one, other = socket.socketpair()
one.settimeout(5); one.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 9999); one.sendall(b"x")
tcp = socket.socket(); tcp.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1); tcp.setblocking(False)
other.recv(1), tcp.getsockname()""",
    "sqlite3": """
import os, tempfile
base = sqlite3.connect(os.path.join(tempfile.mkdtemp(), "x.db"))
base.execute("pragma journal_mode=wal"); base.execute("create table t(a)")
base.execute("insert into t values (5)"); base.commit()
base.execute("select a from t").fetchall()""",
    "ssl": "context = ssl.create_default_context()\ncontext.minimum_version.name, len(ssl.RAND_bytes(4))",
    "subprocess": """
subprocess.run(["sh", "-c", "echo $((1+2)); ls /usr | head -1; sort </dev/null"], capture_output=True).stdout, \\
subprocess.check_output(["tr", "a", "b"], input=b"aa"), subprocess.call(["false"], start_new_session=True)""",
    "tempfile": "f = tempfile.NamedTemporaryFile()\nf.write(b'abc')",
    "termios": """
try: termios.tcgetattr(0); result = 0
except termios.error as error: result = error.args[0]
result""",
    "threading": """
import time
barrier, done = threading.Barrier(3), []
def work(): barrier.wait(); time.sleep(0.01); done.append(1)
threads = [threading.Thread(target=work) for _ in range(3)]
for thread in threads: thread.start()
for thread in threads: thread.join()
done""",
    "time": "time.sleep(0.01), time.clock_getres(time.CLOCK_MONOTONIC)",
    "tracemalloc": "tracemalloc.start(); tracemalloc.stop()\n0",
    "urllib.request": """
try: urllib.request.urlopen("http://127.0.0.1:9", timeout=2); result = "reached"
except OSError as error: result = type(error).__name__
result""",
    "uuid": "uuid.uuid5(uuid.NAMESPACE_DNS, 'a'), len(str(uuid.uuid4()))",
    "zoneinfo": "str(zoneinfo.ZoneInfo('UTC'))",
}
INSTALLED = {
    "PIL.Image": "im = PIL.Image.new('RGB', (9, 9), 'red').resize((5, 5)).rotate(45)\nim.tobytes()",
    "apsw": "list(apsw.Connection(':memory:').execute('select 1 + 1'))",
    "attrs": "attrs.make_class('A', ['x'])(x=1)",
    "av": "av.VideoFrame(16, 16, 'rgb24').reformat(8, 8, 'yuv420p').format.name",
    "cattrs": "cattrs.structure('5', int)",
    "cloudpickle": "cloudpickle.loads(cloudpickle.dumps(lambda: 5))()",
    "cv2": """
import numpy, os, tempfile
picture = numpy.zeros((40, 40, 3), numpy.uint8)
cv2.circle(picture, (20, 20), 9, (1, 2, 3), -1)
name = os.path.join(tempfile.mkdtemp(), "x.png")
cv2.imwrite(name, picture), int(cv2.GaussianBlur(cv2.imread(name), (5, 5), 0).sum()), cv2.getNumThreads() > 0""",
    "daqp": "import numpy\ndaqp.solve(numpy.eye(2), numpy.ones(2), numpy.eye(2), numpy.ones(2), -numpy.ones(2))[0]",
    "dateutil.parser": "dateutil.parser.parse('2020-01-02')",
    "fontTools.misc.bezierTools": "fontTools.misc.bezierTools.solveQuadratic(1, -3, 2)",
    "google.protobuf.timestamp_pb2": "google.protobuf.timestamp_pb2.Timestamp(seconds=5).SerializeToString()",
    "greenlet": "greenlet.greenlet(lambda: 5).switch()",
    "h11": "h11.Connection(h11.CLIENT).our_state",
    "h5py": """
import os, tempfile
name = os.path.join(tempfile.mkdtemp(), "x.h5")
with h5py.File(name, "w") as store: store["a"] = [1, 2]; store["a"].attrs["unit"] = "m"
with h5py.File(name, "r") as store: result = store["a"][:].tolist(), store["a"].attrs["unit"]
result""",
    "jinja2": "jinja2.Template('{{ a }}').render(a=1)",
    "joblib": "joblib.hash([1, 2]), joblib.Parallel(1)(joblib.delayed(abs)(n) for n in (-1, 2))",
    "jsonschema": "jsonschema.validate(1, {'type': 'integer'})",
    "lark": "lark.Lark('start: \"a\"+').parse('aaa').data",
    "libcst": "libcst.parse_module('a = 1').code",
    "lxml.etree": "lxml.etree.tostring(lxml.etree.fromstring('<a><b/></a>'))",
    "lz4.frame": "lz4.frame.decompress(lz4.frame.compress(bytes(99)))",
    "matplotlib.pyplot": """
import io
figure, axes = matplotlib.pyplot.subplots()
axes.plot([1, 2], [3, 4]); axes.set_title("x")
out = io.BytesIO(); figure.savefig(out, metadata={"Software": None})
import hashlib; hashlib.sha256(out.getvalue()).hexdigest()""",
    "mcap.writer": "import io\nw = mcap.writer.Writer(io.BytesIO())\nw.start(); w.finish()",
    "mpmath": "mpmath.mpf(2) ** 0.5",
    "mujoco": """
model = mujoco.MjModel.from_xml_string("<mujoco><worldbody><body><freejoint/><geom size='.1'/></body></worldbody></mujoco>")
data = mujoco.MjData(model)
for _ in range(9): mujoco.mj_step(model, data)
data.qpos.tolist()""",
    "networkx": "networkx.shortest_path(networkx.path_graph(5), 0, 4)",
    "numba": "numba.njit(lambda x: x + 1)(1)",
    "numpy": """
import os, tempfile
a = numpy.random.default_rng(1).random((300, 300))
name = os.path.join(tempfile.mkdtemp(), "a.npy"); numpy.save(name, a)
numpy.load(name, mmap_mode="r").sum(), numpy.linalg.solve(a, a).sum(), numpy.abs(numpy.fft.fft(a)).sum(), (a @ a).sum()""",
    "open3d": """
cloud = open3d.geometry.PointCloud(open3d.utility.Vector3dVector([[0, 0, 0], [0, 0, 1.0], [0, 1, 0]]))
tree = open3d.geometry.KDTreeFlann(cloud)
cloud.get_center().round(6).tolist(), list(tree.search_knn_vector_3d([0, 0, 0.9], 1)[1])""",
    "pandas": "pandas.DataFrame({'a': [1, 2]}).describe().to_csv()",
    "platformdirs": "platformdirs.user_cache_dir('x') > ''",
    "psutil": "psutil.cpu_count() > 0, psutil.virtual_memory().total > 0",
    "pyarrow": "pyarrow.array([1, 2]).to_pylist(), pyarrow.table({'a': [1]}).num_rows",
    "pygments": "import pygments.lexers, pygments.formatters\npygments.highlight('a', pygments.lexers.PythonLexer(), pygments.formatters.NullFormatter())",
    "pyparsing": "pyparsing.Word('a').parse_string('aa').as_list()",
    "py_trees": "py_trees.behaviours.Success('x').status",
    "requests": "requests.Request('GET', 'http://a/b', params={'c': 1}).prepare().url",
    "rich.table": "rich.table.Table('a').columns[0].header",
    "ruamel.yaml": "ruamel.yaml.YAML(typ='safe').load('a: [1, 2]')",
    "scipy.optimize": "scipy.optimize.minimize(lambda x: (x[0] - 3) ** 2, [0.0]).x.round(6).tolist()",
    "scipy.spatial.transform": "scipy.spatial.transform.Rotation.from_euler('z', 1).as_quat().tolist()",
    "serial": """
try: serial.Serial("/dev/ttyUSB0", 115200); result = "opened"
except serial.SerialException: result = "no port"
port = serial.serial_for_url("loop://", timeout=1); port.write(b"x")
result, port.read(1)""",
    "shapely": "shapely.Point(0, 0).buffer(1).intersection(shapely.box(0, 0, 2, 2)).area.__round__(6)",
    "sklearn.linear_model": "sklearn.linear_model.LinearRegression(n_jobs=2).fit([[0.0], [1.0]], [0, 2]).coef_.round(6)",
    "sortedcontainers": "sortedcontainers.SortedList([3, 1])",
    "sympy": "sympy.Symbol('x') + 1",
    "torch": """
x = torch.arange(9.0).reshape(3, 3).requires_grad_()
(x @ x).sum().backward()
loader = torch.utils.data.DataLoader(list(range(4)), batch_size=2)
x.grad.tolist(), [b.tolist() for b in loader], torch.get_num_threads() > 0, torch.nn.Linear(2, 1)(torch.ones(1, 2)).shape""",
    "tornado.ioloop": "import asyncio, tornado.gen\ntornado.ioloop.IOLoop().run_sync(lambda: tornado.gen.sleep(0.01))",
    "tqdm": "list(tqdm.tqdm([1, 2], disable=True))",
    "trimesh": "mesh = trimesh.creation.box((1, 2, 3))\nmesh.volume.round(6), mesh.is_watertight, mesh.bounds.tolist()",
    "tree_sitter": "import tree_sitter_c\ntree_sitter.Parser(tree_sitter.Language(tree_sitter_c.language())).parse(b'int a;').root_node.type",
    "yaml": "yaml.safe_load('a: [1, 2]'), yaml.__with_libyaml__",
    "zmq": """
context = zmq.Context()
one, other = context.socket(zmq.PAIR), context.socket(zmq.PAIR)
one.bind("inproc://a"); other.connect("inproc://a"); one.send(b"x")
other.recv()""",
    "zstandard": "zstandard.decompress(zstandard.compress(bytes(99)))",
}
OVER_LOOPBACK = {
    "asyncio.streams": """
import asyncio
async def answer(reader, writer):
    writer.write((await reader.readline()).upper())
    await writer.drain()
    writer.close()
async def main():
    server = await asyncio.start_server(answer, "127.0.0.1", 0)
    reader, writer = await asyncio.open_connection(*server.sockets[0].getsockname())
    writer.write(b"hello\\n")
    result = await reader.readline()
    writer.close(); server.close()
    return result
asyncio.run(main())""",
    "grpc": """
import concurrent.futures
server = grpc.server(concurrent.futures.ThreadPoolExecutor(1))
port = server.add_insecure_port("127.0.0.1:0")
with grpc.insecure_channel(f"127.0.0.1:{port}") as channel: call = channel.unary_unary("/a/b")
port > 0, callable(call)""",
    "http.server": """
import threading, urllib.request
class Handler(http.server.BaseHTTPRequestHandler):
    def do_GET(self):
        self.send_response(200); self.end_headers(); self.wfile.write(b"x" * 300000)
    def log_message(self, *_): pass
server = http.server.ThreadingHTTPServer(("localhost", 0), Handler)
thread = threading.Thread(target=server.serve_forever); thread.start()
result = len(urllib.request.urlopen(f"http://localhost:{server.server_port}/", timeout=5).read())
server.shutdown(); thread.join(); server.server_close()
result""",
    "multiprocessing.connection": """
import threading
listener = multiprocessing.connection.Listener(("127.0.0.1", 0), authkey=b"key")
def serve():
    with listener.accept() as connection: connection.send(connection.recv() + 1)
thread = threading.Thread(target=serve); thread.start()
with multiprocessing.connection.Client(listener.address, authkey=b"key") as connection:
    connection.send(4)
    result = connection.recv()
thread.join()
result""",
    "multiprocessing.managers": """
import threading
class Manager(multiprocessing.managers.BaseManager): pass
Manager.register("values", callable=lambda: [3, 4])
server = Manager(address=("127.0.0.1", 0), authkey=b"key").get_server()
threading.Thread(target=server.serve_forever, daemon=True).start()
client = Manager(address=server.address, authkey=b"key"); client.connect()
str(client.values())""",
    "requests": """
import http.server, threading
class Handler(http.server.BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.send_response(200); self.end_headers(); self.wfile.write(body.upper())
    def log_message(self, *_): pass
server = http.server.HTTPServer(("127.0.0.1", 0), Handler)
thread = threading.Thread(target=server.serve_forever); thread.start()
result = requests.post(f"http://127.0.0.1:{server.server_port}/", data=b"x", timeout=5).content
server.shutdown(); thread.join(); server.server_close()
result""",
    "socketserver": """
import socket
class Handler(socketserver.DatagramRequestHandler):
    def handle(self): self.wfile.write(self.rfile.read().upper())
import threading
server = socketserver.UDPServer(("127.0.0.1", 0), Handler)
threading.Thread(target=server.handle_request).start()
with socket.socket(type=socket.SOCK_DGRAM) as client:
    client.settimeout(5); client.sendto(b"x", server.server_address)
    result = client.recv(9)
result""",
    "socket": """
import threading
server, sizes = socket.create_server(("::1", 0), family=socket.AF_INET6), []
def serve():
    connection, _ = server.accept()
    with connection:
        while piece := connection.recv(100_000): sizes.append(len(piece))
thread = threading.Thread(target=serve); thread.start()
with socket.create_connection(server.getsockname()[:2]) as client: client.sendall(bytes(9_000_000))
thread.join()
sum(sizes)""",
    "subprocess": """
import socket, sys
server = socket.create_server(("127.0.0.1", 0))
code = "import socket, sys; socket.create_connection(('127.0.0.1', int(sys.argv[1]))).sendall(b'x')"
process = subprocess.Popen([sys.executable, "-c", code, str(server.getsockname()[1])])
connection, _ = server.accept()
result = connection.recv(9), process.wait()
result""",
    "websockets.sync.server": """
import threading, websockets.sync.client
def echo(connection): connection.send(connection.recv().upper())
server = websockets.sync.server.serve(echo, "127.0.0.1", 0)
thread = threading.Thread(target=server.serve_forever); thread.start()
with websockets.sync.client.connect(f"ws://127.0.0.1:{server.socket.getsockname()[1]}") as client:
    client.send("x")
    result = client.recv(timeout=5)
server.shutdown(); thread.join()
result""",
    "xmlrpc.server": """
import threading, xmlrpc.client
server = xmlrpc.server.SimpleXMLRPCServer(("127.0.0.1", 0), logRequests=False)
server.register_function(pow)
threading.Thread(target=server.serve_forever, daemon=True).start()
xmlrpc.client.ServerProxy(f"http://127.0.0.1:{server.server_address[1]}").pow(2, 5)""",
    "zmq": """
context = zmq.Context()
one, other = context.socket(zmq.PAIR), context.socket(zmq.PAIR)
other.connect(f"tcp://localhost:{one.bind_to_random_port('tcp://127.0.0.1')}"); other.send(b"x")
one.recv()""",
}
CONTROLLER = """\
import ast
import rospy, moveit_commander

def use(name, code):
    body = ast.parse(code.strip()).body
    last = ast.Expression(body.pop().value)
    space = {{"__name__": "a_use", "__file__": __file__}}
    exec(f"import {{name}}", space)
    exec(compile(ast.Module(body, []), name, "exec"), space)
    return eval(compile(last, name, "eval"), space)

rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")
joints = arm.get_current_joint_values()
joints[0] += 0.02
arm.go(joints, wait=True)
for name, code in {uses!r}.items():
    try:
        result = use(name, code)
    except BaseException as error:
        result = f"failed: {{error!r}}"
    print("USED", name, repr(result), flush=True)
"""


def is_installed(name: str) -> bool:
    try:
        return importlib.util.find_spec(name) is not None
    except ModuleNotFoundError:
        return False


def used(folder, uses, mode, capfd) -> dict[str, str]:
    (folder / "cell.py").write_text(CONTROLLER.format(uses=uses))
    trace = trace_controller(load_controller(folder / "cell.py"), Settings(sandbox=mode))
    assert trace.end.cause == "ended", trace.end
    return dict(re.findall(r"^USED (\S+) (.*)$", capfd.readouterr().err, re.MULTILINE))


@pytest.mark.skipif(bool(support().missing), reason="needs Landlock and seccomp")
@pytest.mark.parametrize("sixth", slow_but([0], range(6)))
def test_libraries_do_the_same_contained_or_not(sixth, tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    there = [name for name in sorted({**OF_PYTHON, **INSTALLED}) if is_installed(name)]
    uses = {name: {**OF_PYTHON, **INSTALLED}[name] for name in there[sixth::6]}
    assert len(uses) >= 6
    contained = used(tmp_path, uses, "require", capfd)
    assert contained.keys() == uses.keys()
    assert {name: text for name, text in contained.items() if "failed" in text} == {}
    assert contained == used(tmp_path, uses, "off", capfd)


@pytest.mark.slow
@pytest.mark.skipif(
    bool(support().missing) or not offers_own_network(), reason="needs a network of its own"
)
def test_parts_of_a_controller_speak_over_loopback_contained_or_not(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    uses = {name: use for name, use in OVER_LOOPBACK.items() if is_installed(name)}
    contained = used(tmp_path, uses, "require", capfd)
    assert contained.keys() == uses.keys()
    assert {name: text for name, text in contained.items() if "failed" in text} == {}
    assert contained == used(tmp_path, uses, "off", capfd)


SPEAKING = """\
import socket, threading, rospy, moveit_commander
rospy.init_node("cell")
arm = moveit_commander.MoveGroupCommander("panda_arm")
arm.go([0.1, 0, 0, -1, 0, 1, 0], wait=True)
with socket.create_server(("127.0.0.1", 0)) as server:
    socket.create_connection(server.getsockname()).close()
receiver = socket.socket(type=socket.SOCK_DGRAM)
receiver.bind(("127.0.0.1", 0))
socket.socket(type=socket.SOCK_DGRAM).sendto(b"x", receiver.getsockname())
try:
    socket.create_connection(("127.0.0.1", {port}), 2)
except OSError as error:
    print("GOT", type(error).__name__, flush=True)
socket.socket(type=socket.SOCK_DGRAM).sendto(b"x", ("127.0.0.1", {port}))
"""


@pytest.mark.skipif(
    bool(support().missing) or not offers_own_network(), reason="needs a network of its own"
)
def test_only_what_does_not_stay_within_the_run_is_a_finding(tmp_path, monkeypatch, capfd):
    monkeypatch.chdir(tmp_path)
    with socket.create_server(("127.0.0.1", 0)) as outside:
        port = outside.getsockname()[1]
        (tmp_path / "cell.py").write_text(SPEAKING.format(port=port))
        trace = trace_controller(load_controller(tmp_path / "cell.py"), Settings(sandbox="require"))
        outside.settimeout(0)
        with pytest.raises(BlockingIOError):
            outside.accept()
    assert "GOT ConnectionRefusedError" in capfd.readouterr().err
    found = [item.message.partition(":")[2].split(";")[0] for item in denied(trace)]
    assert found == [
        f"{port} was not connected to: the run is contained",
        f"{port} was not sent to: the run is contained",
    ]


def denied(trace):
    return [finding for finding in trace.findings if finding.kind == "denied"]
