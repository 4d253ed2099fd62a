"""A Slurm of one node on this machine: real daemons on loopback, started and stopped by hand.

Neither systemd nor cgroups, neither a database nor a file outside of one temporary folder: Debian's
``munge`` and ``slurm-wlm`` are enough. Root or not, the daemons run as whoever starts them.
"""

from __future__ import annotations

import os
import secrets
import shlex
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from getpass import getuser
from pathlib import Path

DAEMONS = ("munged", "slurmctld", "slurmd")
# What Snakemake's plugin and its jobs call.
CLIENTS = (
    "sbatch",
    "srun",
    "squeue",
    "sinfo",
    "scancel",
    "scontrol",
    "sacct",
    "sacctmgr",
    "sshare",
)
CPUS, MEMORY_MB = 2, 4000

CONFIGURATION = """\
ClusterName=microimpact
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={control_port}
SlurmdPort={node_port}
SlurmUser={user}
SlurmdUser={user}
# Loopback alone: without both, each daemon would listen on every address of the machine.
CommunicationParameters=NoInAddrAny,NoCtldInAddrAny
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
CredType=cred/munge
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.pid
# No systemd and no cgroups.
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
# No database: the controller alone remembers jobs, and for so long (seconds).
AccountingStorageType=accounting_storage/none
JobAcctGatherType=jobacct_gather/none
MinJobAge=300
SchedulerType=sched/builtin
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
# The node has what is said here, however few cores the machine has.
SlurmdParameters=config_overrides
ReturnToService=2
KillWait=2
NodeName={host} NodeAddr=127.0.0.1 CPUs={cpus} RealMemory={memory} State=UNKNOWN
PartitionName=short Nodes={host} Default=YES MaxTime=60 State=UP
"""


class ClusterError(RuntimeError):
    """A cluster that does not come up."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Cluster:
    """A running cluster: its folder, and the environment in which its commands find it."""

    folder: Path
    environment: Mapping[str, str]

    def output(self, *command: str) -> str:
        """Return what a command says that runs in the cluster's environment."""
        return subprocess.run(
            command, env=self.environment, check=True, capture_output=True, text=True, timeout=60
        ).stdout


@contextmanager
def slurm_cluster() -> Iterator[Cluster]:
    """Start munged, slurmctld and slurmd; stop them, whatever happens.

    Raises
    ------
    ClusterError
        If a program is missing or a daemon does not come up; with the end of its log.
    """
    programs = {name: _program(name) for name in (*DAEMONS, *CLIENTS)}
    with ExitStack() as stack:
        # Short, since the address of a socket may have 108 characters.
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm-")))
        folder.chmod(0o711)  # munged wants its socket within everybody's reach
        _write_configuration(folder)
        environment = _client_environment(folder, programs)
        cluster = Cluster(folder=folder, environment=environment)

        socket_path = folder / "munge.socket"
        munged = [programs["munged"], "--foreground", f"--socket={socket_path}"]
        munged += [f"--{kind}-file={folder}/munge.{kind}" for kind in ("key", "log", "pid", "seed")]
        configuration = str(folder / "slurm.conf")
        controller = [programs["slurmctld"], "-D", "-f", configuration]
        node = [programs["slurmd"], "-D", "-f", configuration]

        stack.enter_context(_daemon(munged, folder, socket_path.exists))
        stack.enter_context(
            _daemon(controller, folder, lambda: _says(cluster, "scontrol ping", "is UP"))
        )
        stack.enter_context(
            _daemon(node, folder, lambda: _says(cluster, "sinfo --noheader --format=%T", "idle"))
        )
        # Jobs first: their processes are children of the node's daemon.
        stack.callback(_end_jobs, cluster)
        yield cluster


def _program(name: str) -> str:
    found = shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")
    if found is None:
        raise ClusterError(f"no {name} here; on Debian: apt-get install slurm-wlm munge")
    return found


def _write_configuration(folder: Path) -> None:
    control_port, node_port = _free_ports(2)
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(secrets.token_bytes(128))
    text = CONFIGURATION.format(
        host=socket.gethostname().partition(".")[0],
        user=getuser(),
        folder=folder,
        control_port=control_port,
        node_port=node_port,
        cpus=CPUS,
        memory=MEMORY_MB,
    )
    (folder / "slurm.conf").write_text(text, encoding="utf-8")


def _client_environment(folder: Path, programs: Mapping[str, str]) -> dict[str, str]:
    """Return an environment whose Slurm commands are those of this cluster.

    The plugin takes SLURM_* out of the environment of a job's inner srun, so each command goes
    through a script that says where the configuration is; /etc/slurm stays as it is.
    """
    for name in CLIENTS:
        script = folder / "bin" / name
        command = shlex.quote(programs[name])
        script.write_text(
            f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {command} "$@"\n', encoding="utf-8"
        )
        script.chmod(0o755)
    inherited = {k: v for k, v in os.environ.items() if not k.startswith(("SLURM_", "SBATCH_"))}
    return {**inherited, "PATH": f"{folder}/bin:{inherited['PATH']}"}


@contextmanager
def _daemon(command: list[str], folder: Path, ready: Callable[[], bool]) -> Iterator[None]:
    """Run a daemon in the foreground of its own session; end it by its process id."""
    log = folder / f"{Path(command[0]).name}.out"
    with log.open("wb") as out:
        process = subprocess.Popen(
            command, stdin=subprocess.DEVNULL, stdout=out, stderr=out, start_new_session=True
        )
    try:
        deadline = time.monotonic() + 30
        while not ready():
            if process.poll() is not None or time.monotonic() > deadline:
                last = log.read_text(errors="replace")[-2000:]
                raise ClusterError(f"{shlex.join(command)} did not come up:\n{last}")
            time.sleep(0.1)
        yield
    finally:
        process.terminate()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def _end_jobs(cluster: Cluster) -> None:
    """Cancel what still runs, and wait until it is gone."""
    cluster.output("scancel", f"--user={getuser()}")
    deadline = time.monotonic() + 20
    while cluster.output("squeue", "--noheader") and time.monotonic() < deadline:
        time.sleep(0.2)


def _says(cluster: Cluster, command: str, expected: str) -> bool:
    done = subprocess.run(
        shlex.split(command),
        env=cluster.environment,
        check=False,
        capture_output=True,
        text=True,
        timeout=60,
    )
    return expected in done.stdout


def _free_ports(count: int) -> list[int]:
    with ExitStack() as stack:
        sockets = [stack.enter_context(socket.socket()) for _ in range(count)]
        for one in sockets:
            one.bind(("127.0.0.1", 0))
        return [one.getsockname()[1] for one in sockets]
