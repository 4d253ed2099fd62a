"""A Slurm of one node on this machine: real daemons on loopback, started and stopped by hand.

Neither systemd nor cgroups, neither a database nor a file outside of one temporary folder: Debian's
``munge`` and ``slurm-wlm`` are enough. Root or not, the daemons run as whoever starts them.
"""

from __future__ import annotations

import os
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from contextlib import ExitStack, contextmanager
from getpass import getuser
from pathlib import Path

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
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory=4000 State=UNKNOWN
PartitionName=short Nodes={host} Default=YES MaxTime=60 State=UP
"""


@contextmanager
def slurm_cluster():
    """Start munged, slurmctld and slurmd and yield a function that runs their clients' commands.

    Its attribute `environment` is the one in which they find the cluster. All is stopped, whatever
    happens.
    """
    with ExitStack() as stack:
        # Short, since the address of a socket may have 108 characters.
        folder = Path(stack.enter_context(tempfile.TemporaryDirectory(prefix="slurm-")))
        folder.chmod(0o711)  # munged wants its socket within everybody's reach
        write_configuration(folder)
        environment = client_environment(folder)

        def output(*command):
            return subprocess.run(
                command, env=environment, check=True, capture_output=True, text=True, timeout=60
            ).stdout

        output.environment = environment
        munge = [f"--{kind}-file={folder}/munge.{kind}" for kind in ("key", "log", "pid", "seed")]
        slurm = ["-D", "-f", f"{folder}/slurm.conf"]
        for name, arguments, ready in (
            ("munged", ["-F", f"--socket={folder}/munge.socket", *munge], "test -e munge.socket"),
            ("slurmctld", slurm, "scontrol ping | grep -q 'is UP'"),
            ("slurmd", slurm, "sinfo --noheader --format=%T | grep -q idle"),
        ):
            stack.enter_context(daemon(name, arguments, ready, folder, environment))
        # Jobs first: their processes are children of the node's daemon.
        stack.callback(output, "scancel", f"--user={getuser()}")
        yield output


def program(name):
    """Return the path of a program; `make test-slurm` has seen to it that there is one."""
    return shutil.which(name, path=f"{os.environ['PATH']}:/usr/sbin:/sbin")


def write_configuration(folder):
    for name in ("state", "spool", "bin"):
        (folder / name).mkdir()
    key = folder / "munge.key"
    key.touch(mode=0o600)
    key.write_bytes(secrets.token_bytes(128))
    with socket.socket() as first, socket.socket() as second:
        for each in (first, second):
            each.bind(("127.0.0.1", 0))
        ports = [each.getsockname()[1] for each in (first, second)]
    text = CONFIGURATION.format(
        host=socket.gethostname().partition(".")[0], user=getuser(), folder=folder,
        control_port=ports[0], node_port=ports[1],
    )  # fmt: skip
    (folder / "slurm.conf").write_text(text, encoding="utf-8")


def client_environment(folder):
    """Return an environment whose Slurm commands are those of this cluster.

    The plugin takes SLURM_* out of the environment of a job's inner srun, so each command goes
    through a script that says where the configuration is; /etc/slurm stays as it is.
    """
    for name in CLIENTS:
        script = folder / "bin" / name
        script.write_text(f'#!/bin/sh\nSLURM_CONF={folder}/slurm.conf exec {program(name)} "$@"\n')
        script.chmod(0o755)
    inherited = {k: v for k, v in os.environ.items() if not k.startswith(("SLURM_", "SBATCH_"))}
    return {**inherited, "PATH": f"{folder}/bin:{inherited['PATH']}"}


@contextmanager
def daemon(name, arguments, ready, folder, environment):
    """Run a daemon in the foreground of its own session; end it by its process id."""
    log = folder / f"{name}.out"
    with log.open("wb") as out:
        process = subprocess.Popen(
            [program(name), *arguments],
            stdin=subprocess.DEVNULL,
            stdout=out,
            stderr=out,
            start_new_session=True,
        )
    try:
        deadline = time.monotonic() + 30
        while subprocess.run(
            ["sh", "-c", ready], cwd=folder, env=environment, check=False
        ).returncode:
            ended = process.poll() is not None or time.monotonic() > deadline
            assert not ended, f"{name} did not come up:\n{log.read_text()[-2000:]}"
            time.sleep(0.1)
        yield
    finally:
        process.terminate()
        try:
            process.wait(timeout=20)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
