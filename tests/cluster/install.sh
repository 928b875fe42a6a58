#!/bin/sh
# Installs SLURM and MUNGE from the packages of Debian or Ubuntu, for `make test-cluster`. Run it as
# root. Where the packages start services of their own, they can be disabled: the test starts what
# it needs and stops it.
set -eu
apt-get update
apt-get install -y --no-install-recommends slurmctld slurmd slurm-client munge
