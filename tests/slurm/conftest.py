"""The tests on a real Slurm are collected by `make test-slurm` alone; it makes .venv-slurm."""

from __future__ import annotations

import os

if not os.environ.get("MICROIMPACT_SLURM"):
    collect_ignore = ["test_cluster.py"]
