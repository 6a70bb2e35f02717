"""The environment of ROS: sourced, addresses, the master."""

import pathlib
import socket
import urllib.parse
import xmlrpc.client

from .findings import fail, last_line, ok, warn

TIMEOUT = 2.0  # [s] for a master to answer
INSTALLED = pathlib.Path(__file__).resolve().parents[3] / "share/raven2_trainer"  # where this is lib/raven2_trainer/...
DEFAULT_MASTER = "http://localhost:11311"


def environment(machine):
    """Which raven2_trainer do rosrun and roslaunch find?"""
    setup = f"source {machine.build}/devel/setup.bash" if machine.build else "as root: apt-get install rosbash catkin"
    if machine.which("rospack") is None:
        return [fail("no rospack: ROS is not installed", "as root: scripts/install_dependencies")]
    status, text = machine.run("rospack", "find", "raven2_trainer")
    if status != 0:
        return [warn("rosrun and roslaunch do not find raven2_trainer: the environment is not sourced", setup)]
    found = pathlib.Path(last_line(text)).resolve()
    expected = machine.build / "devel/share/raven2_trainer" if machine.build else INSTALLED
    if found != expected.resolve():
        return [warn(f"rosrun finds another raven2_trainer: {found}", setup + ", in a new shell")]
    return [ok(f"rosrun finds {found}")]


def resolves(name):
    try:
        return {entry[4][0] for entry in socket.getaddrinfo(name, None)}
    except OSError:
        return set()


def is_ours(address):
    """Can this computer listen there?"""
    family = socket.AF_INET6 if ":" in address else socket.AF_INET
    with socket.socket(family, socket.SOCK_DGRAM) as link:
        try:
            link.bind((address, 0))
        except OSError:
            return False
    return True


def addresses(machine):
    """Other nodes connect to what ROS_HOSTNAME or ROS_IP says, else to the host's name."""
    for name in ("ROS_HOSTNAME", "ROS_IP"):
        value = machine.environ.get(name)
        if not value:
            continue
        reached = resolves(value)
        if not reached:
            return [fail(f"{name} is {value}, which does not resolve", f"unset {name}, or set it to an address of this computer")]
        if not any(is_ours(address) for address in reached):
            return [fail(f"{name} is {value}, which is not this computer",
                         f"unset {name}, or set it to an address that `hostname -I` prints")]
        return [ok(f"{name} is {value}, this computer")]
    host = socket.gethostname()
    if not resolves(host):
        return [warn(f"the name of this computer, {host}, does not resolve: other ROS programs cannot connect",
                     f"as root: echo '127.0.1.1 {host}' >> /etc/hosts, or export ROS_IP=127.0.0.1")]
    return [ok(f"{host} resolves; nodes of this package listen on 127.0.0.1 alone (doc/ros.md)")]


class Transport(xmlrpc.client.Transport):
    """Gives up on a master that hangs."""

    def make_connection(self, host):
        connection = super().make_connection(host)
        connection.timeout = TIMEOUT
        return connection


def master(machine):
    uri = machine.environ.get("ROS_MASTER_URI") or DEFAULT_MASTER
    parts = urllib.parse.urlsplit(uri)
    if parts.scheme != "http" or not parts.hostname or not parts.port:
        return [fail(f"ROS_MASTER_URI is {uri}, which is no http://HOST:PORT", f"export ROS_MASTER_URI={DEFAULT_MASTER}")]
    if not resolves(parts.hostname):
        return [fail(f"ROS_MASTER_URI is {uri}: {parts.hostname} does not resolve",
                     f"export ROS_MASTER_URI={DEFAULT_MASTER}, or add the name to /etc/hosts")]
    try:
        status, _, pid = xmlrpc.client.ServerProxy(uri, transport=Transport()).getPid("/raven2_doctor")
    except ConnectionError:
        return [warn(f"no master at {uri}: sessions run, topics and services appear when there is one", "roscore, or roslaunch, which starts one")]
    except (OSError, xmlrpc.client.Error, ValueError) as error:
        return [fail(f"at {uri} is no ROS master: {type(error).__name__}", "end what listens there, or set ROS_MASTER_URI")]
    return [ok(f"a master answers at {uri}, process {pid}")] if status == 1 else [
        fail(f"the master at {uri} refuses to answer", "restart it: roscore")]
