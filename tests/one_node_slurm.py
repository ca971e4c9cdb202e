# SPDX-License-Identifier: GPL-2.0-or-later
"""A Slurm of one node on this machine, for the tests marked ``slurm``: needs Debian's slurm-wlm and munge, and root."""

from __future__ import annotations

import os
import secrets
import shutil
import socket
import subprocess
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

PROGRAMS = ("munged", "slurmctld", "slurmd", "sbatch", "scontrol", "sinfo")
SEARCHED = f"{os.environ['PATH']}:/usr/sbin:/sbin"
PAUSE, LIMIT = 0.1, 300
"""Seconds between two looks, and the end of a hang."""

SETTINGS = """\
ClusterName=test
SlurmctldHost={host}(127.0.0.1)
SlurmctldPort={controller}
SlurmdPort={node}
SlurmUser=root
SlurmdUser=root
MailProg=/bin/true
AuthType=auth/munge
AuthInfo=socket={place}/munge.socket
CredType=cred/munge
StateSaveLocation={place}/state
SlurmdSpoolDir={place}/spool
SlurmctldPidFile={place}/slurmctld.pid
SlurmdPidFile={place}/slurmd.pid
SlurmctldLogFile={place}/slurmctld.log
SlurmdLogFile={place}/slurmd.log
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
SwitchType=switch/none
MpiDefault=none
JobAcctGatherType=jobacct_gather/none
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
SchedulerParameters=batch_sched_delay=0,sched_interval=1
PropagatePrioProcess=1
JobRequeue=1
KillWait=20
ReturnToService=2
NodeName={host} NodeAddr=127.0.0.1 CPUs=2 RealMemory={memory} State=UNKNOWN
PartitionName=test Nodes={host} Default=YES State=UP DefaultTime=10 MaxTime=60
"""


def missing() -> str:
    """Why there can be no Slurm here; empty where there can."""
    lacking = [name for name in PROGRAMS if shutil.which(name, path=SEARCHED) is None]
    if lacking:
        return f"Slurm is not installed (no {', '.join(lacking)}); `make slurm` installs it"
    return "" if os.geteuid() == 0 else "a Slurm for tests needs root"


@contextmanager
def one_node_slurm() -> Iterator[Slurm]:
    """Start the three daemons in a folder of their own, and end them after the block."""
    with tempfile.TemporaryDirectory(prefix="slurm", dir="/tmp", ignore_cleanup_errors=True) as name:
        slurm = Slurm(Path(name))
        try:
            slurm.start()
            yield slurm
        finally:
            slurm.stop()


class Slurm:
    """The daemons in the folder `place`, and the programs that speak to them."""

    def __init__(self, place: Path):
        self.place = place
        self.environment = os.environ | {"SLURM_CONF": str(place / "slurm.conf"), "PATH": SEARCHED}
        self.daemons: list[subprocess.Popen[bytes]] = []

    def start(self) -> None:
        """Write the settings, start the daemons, wait until the node is idle."""
        ports = {"controller": free_port(), "node": free_port()}
        memory = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // 2**20
        settings = SETTINGS.format(
            memory=memory, host=socket.gethostname().partition(".")[0], place=self.place, **ports
        )
        (self.place / "slurm.conf").write_text(settings)
        newer = subprocess.run(["slurmctld", "-V"], env=self.environment, capture_output=True, text=True).stdout
        cgroups = "CgroupPlugin=disabled\n" if newer.split()[-1] >= "23.11" else ""
        (self.place / "cgroup.conf").write_text(cgroups)
        self.place.chmod(0o755)
        for folder in ("state", "spool"):
            (self.place / folder).mkdir()
        key = self.place / "key"
        key.touch(0o600)
        key.write_bytes(secrets.token_bytes(128))
        own = ("key-file", "socket", "pid-file", "log-file", "seed-file")
        names = dict(zip(own, ("key", "munge.socket", "munged.pid", "munged.log", "seed"), strict=True))
        self._launch("munged", "--foreground", *(f"--{option}={self.place / file}" for option, file in names.items()))
        wait_for(lambda: (self.place / "munge.socket").exists(), "munged")
        self._launch("slurmctld", "-D", "-f", str(self.place / "slurm.conf"))
        self._launch("slurmd", "-D", "-f", str(self.place / "slurm.conf"))
        wait_for(lambda: self.ask("sinfo", "-h", "-o", "%T").strip() == "idle", "the node")

    def _launch(self, *command: str) -> None:
        with (self.place / f"{command[0]}.out").open("wb") as output:
            started = subprocess.Popen(
                command, env=self.environment, stdout=output, stderr=output, start_new_session=True
            )
        self.daemons.append(started)

    def stop(self) -> None:
        """Cancel what is left and end the daemons."""
        self.ask("scancel", "--user=root")
        if self.daemons:
            wait_for(lambda: not self.ask("squeue", "-h"), "the end of the jobs")
        for daemon in reversed(self.daemons):
            daemon.terminate()
            daemon.wait(LIMIT)

    def ask(self, *command: str, **options) -> str:
        """Output of a program of Slurm."""
        done = subprocess.run(
            command, env=self.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, **options
        )
        return done.stdout

    def submit(self, folder: Path, *options: str) -> str:
        """Submit ``job.slurm`` of a folder; the number of the job."""
        said = self.ask("sbatch", "--parsable", *options, "job.slurm", cwd=folder).strip()
        assert said.isdigit(), said
        return said

    def job(self, number: str) -> dict[str, str]:
        """What Slurm says of a job."""
        text = self.ask("scontrol", "show", "job", "-o", number)
        return dict(word.partition("=")[::2] for word in text.split() if "=" in word)

    def start_soon(self, number: str) -> None:
        """Start a requeued job now: Slurm waits 120 s, and a start in the same second would fail."""
        time.sleep(2)
        self.ask("scontrol", "update", f"JobId={number}", "StartTime=now+3")

    def wait(self, number: str, *states: str) -> dict[str, str]:
        """Wait until a job is in one of some states, after it has begun; what Slurm says of it then."""
        wait_for(lambda: self._found(number, states), f"{states} of job {number}")
        return self.job(number)

    def _found(self, number: str, states: tuple[str, ...]) -> bool:
        job = self.job(number)
        return job["JobState"] in states and (job["JobState"] != "PENDING" or job["Restarts"] != "0")


def wait_for(found, what: str) -> None:
    """Wait until a function returns true; it fails after `LIMIT`."""
    for _ in range(int(LIMIT / PAUSE)):
        if found():
            return
        time.sleep(PAUSE)
    raise AssertionError(f"waited {LIMIT} s for {what}")


def free_port() -> int:
    """A port that no program listens on."""
    with socket.socket() as found:
        found.bind(("127.0.0.1", 0))
        return found.getsockname()[1]
