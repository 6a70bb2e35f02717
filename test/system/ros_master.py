"""A ROS master for tests, used through its plain XML-RPC interface, and the addresses on which a process listens."""

import os
import socket
import socketserver
import subprocess
import threading
import time
import xmlrpc.client
import xmlrpc.server

from stack import BUILD, free_ports, wait_until


class _Patient(xmlrpc.client.Transport):
    """Gives up after 5 s, so that a test never hangs with its master."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = 5
        return connection


class RosMaster:
    """`rosmaster --core` on a free port; start() and kill() as often as wanted. Use as a context manager."""

    def __init__(self, folder):
        self.port = free_ports(1)[0]
        self.uri = f"http://127.0.0.1:{self.port}"
        self._environment = dict(os.environ, ROS_MASTER_URI=self.uri, ROS_IP="127.0.0.1", ROS_HOME=folder,
                                 ROS_LOG_DIR=os.path.join(folder, "log"))
        self._process = None

    def know_our_messages(self):
        """Makes this package's messages and services available to run() and popen()."""
        path = os.path.join(BUILD, "devel/lib/python3/dist-packages")
        self._environment["PYTHONPATH"] = path + os.pathsep + os.environ.get("PYTHONPATH", "")

    def start(self):
        """Waits until the master answers. Returns the time of the answer."""
        self._process = subprocess.Popen(["rosmaster", "--core", "-p", str(self.port)], env=self._environment,
                                         stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(lambda: self.answers() or self._process.poll() is not None, 60, "the ROS master answers")
        assert self._process.poll() is None, "rosmaster ended"
        return time.monotonic()

    def kill(self):
        if self._process is not None:
            self._process.kill()
            self._process.wait()
            self._process = None

    def signal(self, sign):
        self._process.send_signal(sign)

    def answers(self):
        try:
            return self.ask("getPid") == self._process.pid
        except (OSError, xmlrpc.client.Error):
            return False

    def ask(self, method, *arguments):
        with xmlrpc.client.ServerProxy(self.uri, transport=_Patient()) as master:
            code, words, value = getattr(master, method)("/test", *arguments)
        assert code == 1, words
        return value

    def known_of(self, node, lists=None):
        """The master's entries of a node: {"published": {...}, "subscribed": {...}, "services": {...}}."""
        return {kind: {name for name, nodes in entries if node in nodes}
                for kind, entries in zip(("published", "subscribed", "services"), lists or self.ask("getSystemState"))}

    def slave(self, node):
        """The slave API of a node, as anybody can call it."""
        return xmlrpc.client.ServerProxy(self.ask("lookupNode", node))

    def run(self, *command, seconds=20):
        """Runs a ROS command-line tool with this master."""
        return subprocess.run(command, env=self._environment, capture_output=True, text=True, timeout=seconds)

    def popen(self, *command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL):
        return subprocess.Popen(command, env=self._environment, stdin=stdin, stdout=stdout, stderr=subprocess.DEVNULL, text=True)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.kill()


class _Handler(xmlrpc.server.SimpleXMLRPCRequestHandler):
    protocol_version = "HTTP/1.1"  # one connection for all calls, as with the real master


class _Server(socketserver.ThreadingMixIn, xmlrpc.server.SimpleXMLRPCServer):
    daemon_threads = True


class SlowMaster:
    """Forwards every call to a master. Delays the first call that unregisters, and the first after delay_next(), by `seconds`; with
    `always` each call."""

    def __init__(self, master, seconds, always=False):
        self._master, self._seconds, self._connections = master.uri, seconds, threading.local()
        self._wanted = seconds
        self._always = always
        self._server = _Server(("127.0.0.1", 0), _Handler, logRequests=False)
        self._server.register_instance(self)
        self.uri = "http://{}:{}".format(*self._server.server_address)

    def _dispatch(self, method, arguments):
        if self._always:
            time.sleep(self._seconds)
        elif method.startswith("unregister"):
            seconds, self._seconds = self._seconds, 0.0
            time.sleep(seconds)
        if not hasattr(self._connections, "master"):
            self._connections.master = xmlrpc.client.ServerProxy(self._master, transport=_Patient())
        return getattr(self._connections.master, method)(*arguments)

    def delay_next(self):
        self._seconds = self._wanted

    def __enter__(self):
        threading.Thread(target=self._server.serve_forever, daemon=True).start()
        return self

    def __exit__(self, *_):
        self._server.shutdown()
        self._server.server_close()


def _address(text):
    """Dotted form of an IPv4 address of /proc/net (hexadecimal, in the machine's byte order). IPv6 is unchanged."""
    if len(text) == 8:
        return socket.inet_ntoa(bytes.fromhex(text)[::-1])
    return text


def listeners(pid):
    """[(protocol, address, port)] on which a process accepts input: listening TCP, and UDP without a peer."""
    inodes = set()
    for fd in os.listdir(f"/proc/{pid}/fd"):
        try:
            target = os.readlink(f"/proc/{pid}/fd/{fd}")
        except FileNotFoundError:  # closed in the meantime
            continue
        if target.startswith("socket:["):
            inodes.add(target[8:-1])
    found = []
    for protocol in ("tcp", "tcp6", "udp", "udp6"):
        with open(f"/proc/{pid}/net/{protocol}", encoding="ascii") as table:
            for line in list(table)[1:]:
                fields = line.split()
                local, remote, state, inode = fields[1], fields[2], fields[3], fields[9]
                is_open = state == "0A" if protocol.startswith("tcp") else remote.endswith(":0000")
                if inode in inodes and is_open:
                    host, port = local.split(":")
                    found.append((protocol, _address(host), int(port, 16)))
    return found


def resident_mib(pid):
    with open(f"/proc/{pid}/statm", encoding="ascii") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20
