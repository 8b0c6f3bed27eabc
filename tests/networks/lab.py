"""Machines and networks on this computer: namespaces, and a switch between them.

A machine is a network namespace. A network is a switch in this process that forwards frames
between TAP devices: it can lose, delay and hold back what passes, as a Wi-Fi does. (`tc netem`
does the same where the kernel has it.)
"""

from __future__ import annotations

import fcntl
import heapq
import os
import random
import selectors
import shutil
import signal
import struct
import subprocess
import sys
import threading
import time
from dataclasses import dataclass, field
from pathlib import Path

PROGRAMS = {
    "halo": str(Path(sys.executable).with_name("halo")),
    "python": sys.executable,
}
TUN = Path("/dev/net/tun")
_SET_INTERFACE, _TAP_WITHOUT_HEADER = 0x400454CA, 0x0002 | 0x1000
"""`TUNSETIFF` and `IFF_TAP | IFF_NO_PI`, as in Linux' `if_tun.h`."""
_LARGEST = 65_536
START_S, ENDING_S = 30.0, 10.0


def unavailable() -> str:
    """Return why there can be no machines here; empty if there can."""
    if sys.platform != "linux" or shutil.which("ip") is None or os.geteuid() != 0:
        return "network namespaces need Linux, root and the ip tool"
    if not os.access(TUN, os.R_OK | os.W_OK):
        return f"{TUN} is not here"
    probe = f"halo{os.getpid()}"
    if subprocess.run(["ip", "netns", "add", probe], capture_output=True).returncode:
        return "this container allows no network namespaces"
    ip("netns", "del", probe)
    return ""


def ip(*words: str) -> None:
    subprocess.run(["ip", *words], check=True, capture_output=True)


@dataclass
class Air:
    """What a network does with packets."""

    loss: float = 0.0
    """Share of the packets that is lost, in each direction."""
    delay_s: float = 0.0
    jitter_s: float = 0.0
    """Up to this much is added to the delay; the order stays."""
    multicast: bool = True
    """Whether multicast passes (broadcast does, for ARP)."""
    cut: bool = False
    """Nothing passes."""


class Network:
    """A switch. `join` is to be called before `start`."""

    def __init__(self, name: str, seed: int = 1) -> None:
        self.name = name
        self.air = Air()
        self.lost = self.passed = self.readable = 0
        """Packets; `readable`: those with the name of a key of ours."""
        self._random = random.Random(seed)
        self._ports: list[int] = []
        self._waiting: list[tuple[float, int, int, bytes]] = []
        self._latest_s: dict[int, float] = {}
        self._count = 0
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run, name=f"network {name}", daemon=True)

    def join(self, machine: Machine, address: str) -> None:
        """Give a machine an interface, called like the network, with an address and its length."""
        port = os.open(TUN, os.O_RDWR | os.O_NONBLOCK)
        device = f"h{os.getpid()}-{len(self._ports)}{self.name[:4]}"[:15]
        request = struct.pack("16sH22x", device.encode(), _TAP_WITHOUT_HEADER)
        fcntl.ioctl(port, _SET_INTERFACE, request)
        self._ports.append(port)
        ip("link", "set", device, "netns", machine.namespace, "name", self.name)
        inside = ("-n", machine.namespace)
        ip(*inside, "addr", "add", address, "dev", self.name)
        ip(*inside, "link", "set", self.name, "up")

    def start(self) -> None:
        """Forward what comes, until `close`."""
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        if self._thread.ident is not None:
            self._thread.join()
        for port in self._ports:
            os.close(port)

    def _run(self) -> None:
        with selectors.DefaultSelector() as ports:
            for port in self._ports:
                ports.register(port, selectors.EVENT_READ)
            while not self._ended.is_set():
                for key, _ in ports.select(self._wait_s()):
                    self._receive(key.fd)
                self._send_due(time.monotonic())

    def _wait_s(self) -> float:
        return max(self._waiting[0][0] - time.monotonic(), 0.0) if self._waiting else 0.1

    def _receive(self, port: int) -> None:
        try:
            while packet := os.read(port, _LARGEST):
                self._accept(port, packet)
        except OSError:  # nothing more, or the machine is gone
            return

    def _accept(self, port: int, packet: bytes) -> None:
        air = self.air
        is_multicast = packet[0] & 1 and packet[:6] != b"\xff" * 6
        if air.cut or (is_multicast and not air.multicast) or self._random.random() < air.loss:
            self.lost += 1
            return
        self.passed += 1
        self.readable += b"halo/1" in packet
        late_s = air.delay_s + self._random.uniform(0.0, air.jitter_s)
        at_s = max(time.monotonic() + late_s, self._latest_s.get(port, 0.0))
        self._latest_s[port] = at_s
        self._count += 1
        heapq.heappush(self._waiting, (at_s, self._count, port, packet))

    def _send_due(self, now_s: float) -> None:
        while self._waiting and self._waiting[0][0] <= now_s:
            _, _, source, packet = heapq.heappop(self._waiting)
            for port in self._ports:
                if port != source:
                    try:
                        os.write(port, packet)
                    except OSError:  # its machine is gone
                        continue


class Program:
    """A program that runs on a machine. What it prints goes to a file."""

    def __init__(self, command: list[str], folder: Path, log: Path) -> None:
        self._log = log
        with log.open("w") as output:
            self._process = subprocess.Popen(
                command, cwd=folder, stdin=subprocess.PIPE, stdout=output, stderr=output
            )

    @property
    def text(self) -> str:
        """What it printed so far."""
        return self._log.read_text(errors="replace")

    @property
    def code(self) -> int | None:
        """Its exit code; None while it runs."""
        return self._process.poll()

    def wait_for(self, words: str, within_s: float = START_S) -> None:
        """Wait until it has printed something."""
        until_s = time.monotonic() + within_s
        while words not in self.text:
            assert self._process.poll() is None, f"it ended: {self.text}"
            assert time.monotonic() < until_s, f"no '{words}' in: {self.text}"
            time.sleep(0.02)

    def go(self) -> None:
        """Send an empty line to its input."""
        assert self._process.stdin is not None
        self._process.stdin.write(b"\n")
        self._process.stdin.flush()

    def end(self, how: int = signal.SIGTERM) -> str:
        """End it; return what it printed."""
        if self._process.poll() is None:
            self._process.send_signal(how)
        return self.ended()

    def ended(self, within_s: float = ENDING_S) -> str:
        """Wait for its end; return what it printed."""
        try:
            self._process.communicate(timeout=within_s)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.communicate()
            raise
        return self.text


@dataclass
class Machine:
    """A machine: its networks are its own, its files are in `folder`."""

    name: str
    namespace: str
    folder: Path
    _started: list[Program] = field(default_factory=list)

    def start(self, *command: str | Path) -> Program:
        """Start a program in its folder. `halo` is the one of this environment."""
        log = self.folder / f"{len(self._started)}.log"
        self._started.append(Program(self._inside(command), self.folder, log))
        return self._started[-1]

    def run(
        self, *command: str | Path, timeout_s: float = 60.0
    ) -> subprocess.CompletedProcess[str]:
        """Run a program to its end."""
        return subprocess.run(
            self._inside(command), cwd=self.folder, capture_output=True, text=True,
            timeout=timeout_s,
        )  # fmt: skip

    def close(self) -> None:
        for program in self._started:
            program.end(signal.SIGKILL)

    def _inside(self, command: tuple[str | Path, ...]) -> list[str]:
        words = [PROGRAMS.get(str(word), str(word)) for word in command]
        return ["ip", "netns", "exec", self.namespace, *words]


class Lab:
    """Machines and networks, all ended by `close`."""

    def __init__(self, folder: Path, name: str = "") -> None:
        """`name`: of one of several labs at once."""
        self._folder, self._name = folder, name
        self.machines: dict[str, Machine] = {}
        self.networks: list[Network] = []

    def machine(self, name: str) -> Machine:
        namespace = f"halo{os.getpid()}-{self._name}{name}"
        ip("netns", "add", namespace)
        folder = self._folder / name
        folder.mkdir()
        self.machines[name] = Machine(name, namespace, folder)
        ip("-n", namespace, "link", "set", "lo", "up")
        return self.machines[name]

    def network(self, name: str, **members: str) -> Network:
        """Connect machines, each with its address: `network("lan", table="10.0.0.1/24")`."""
        network = Network(name)
        self.networks.append(network)
        for member, address in members.items():
            machine = self.machines.get(member) or self.machine(member)
            network.join(machine, address)
        network.start()
        return network

    def close(self) -> None:
        for machine in self.machines.values():
            machine.close()
        for network in self.networks:
            network.close()
        for machine in self.machines.values():
            ip("netns", "del", machine.namespace)
