"""The ports of config/network.yaml: free, or by whom they are held."""

import errno
import os
import pathlib
import socket

from .findings import fail, ok, text_of, warn

PORTS = {"master_port": "udp", "robot_port": "udp", "force_port": "udp", "sight_port": "udp", "state_port": "tcp"}
OURS = ("simulator", "virtual_raven", "master_console", "raven_state_bridge", "impair", "console_view")


def wanted(machine):
    """Name, kind and number of every port."""
    network = machine.section("network")
    return [(name, kind, int(text_of(network, name, "0"))) for name, kind in PORTS.items()]


def refused(address, kind, port):
    """Number of the error with which that cannot be bound; 0 if it can."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM if kind == "udp" else socket.SOCK_STREAM) as link:
        if kind == "tcp":
            link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # as the server: not connections that have ended
        try:
            link.bind((address, port))
        except OSError as error:
            return error.errno
    return 0


def inodes(kind, port):
    """Of the sockets that are bound there; of TCP the listening ones."""
    found = set()
    for table in (f"/proc/net/{kind}", f"/proc/net/{kind}6"):
        for line in pathlib.Path(table).read_text().splitlines()[1:] if pathlib.Path(table).exists() else []:
            words = line.split()
            if int(words[1].rpartition(":")[2], 16) == port and (kind == "udp" or words[3] == "0A"):
                found.add(f"socket:[{words[9]}]")
    return found


def holder(kind, port):
    """Name and id of the process that holds a port, as far as this user may see it: None if not."""
    sockets = inodes(kind, port)
    for link in pathlib.Path("/proc").glob("[0-9]*/fd/*"):
        try:
            if str(link.readlink()) in sockets:
                process = link.parents[1]
                return (process / "comm").read_text().strip(), int(process.name)
        except OSError:
            continue
    return None


def held(name, kind, port):
    by = holder(kind, port)
    if by is None:
        return fail(f"{name} {port} ({kind}) is held by a process of somebody else",
                    f"as root: ss -lnp 'sport = :{port}' names it; end it, or choose another port in network.yaml")
    program, process = by
    if any(ours.startswith(program) for ours in OURS):  # the kernel keeps 15 characters
        return warn(f"{name} {port} ({kind}) is held by {program} ({process}): a session is running",
                    f"let it end, or kill {process}")
    return fail(f"{name} {port} ({kind}) is held by {program} ({process})",
                f"kill {process}, or choose another port in network.yaml")


def other(why, name, kind, port):
    """Of a port that nobody holds."""
    if why == errno.EACCES:
        return fail(f"{name} {port} ({kind}) is not for this user: ports below 1024 are root's",
                    "choose one of 1024 to 65535 in network.yaml")
    return fail(f"{name} {port} ({kind}) cannot be bound: {os.strerror(why)}", "choose another address or port in network.yaml")


def taken(address, port):
    """Findings of a port that the programs would not get."""
    why = refused(address, *port[1:])
    return [] if why == 0 else [held(*port)] if why == errno.EADDRINUSE else [other(why, *port)]


def is_address(text):
    """As the programs take it; of names only the one that needs no name server."""
    try:
        return text == "localhost" or bool(socket.inet_aton(text))
    except OSError:
        return False


def ports(machine):
    network = machine.section("network")
    if not network.is_file():
        return [fail(f"{network} is not there", "name the configuration with --config")]
    address = text_of(network, "bind_address", "127.0.0.1")
    if not is_address(address):
        return [fail(f"bind_address is {address}, which is no IPv4 address", f"mend it in {network}")]
    if refused(address, "udp", 0) == errno.EADDRNOTAVAIL:
        return [fail(f"bind_address {address} is not this computer's", f"hostname -I shows those that are: set one in {network}")]
    chosen = [port for port in wanted(machine) if port[2]]
    found = [finding for port in chosen for finding in taken(address, port)]
    twice = {p[1:] for p in chosen if [q[1:] for q in chosen].count(p[1:]) > 1}
    found += [fail(f"{network} gives port {port} ({kind}) twice", "choose another port for one of them")
              for kind, port in sorted(twice)]
    return found or [ok("free: " + ", ".join(f"{name} {port}" for name, _, port in chosen))]
