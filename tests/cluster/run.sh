#!/bin/sh
# Runs a command where it can start SLURM: tests/cluster/run.sh python -m pytest -m cluster
#
# The command gets namespaces of its own: a network with nothing but the loopback interface, a
# folder over /etc/slurm, and a process table. What it starts ends with it, and neither a SLURM
# installed on this host nor its ports are touched.
set -eu

skip() {
    echo "make test-cluster: skipped: $*"
    exit 0
}

PATH="$PATH:/usr/sbin:/sbin"
for program in slurmctld slurmd sbatch munged unshare ip mount; do
    command -v "$program" >/dev/null || skip "no $program (sudo sh tests/cluster/install.sh)"
done
test "$(id -u)" = 0 || skip "only root can start a cluster (sudo make test-cluster)"
spaces="unshare --mount --net --pid --fork --kill-child --mount-proc"
$spaces true 2>/dev/null || skip "this system lets nobody make namespaces"

MOCAP_SLURM=$(mktemp -d)
export MOCAP_SLURM
trap 'rm -rf "$MOCAP_SLURM"' EXIT
chmod 711 "$MOCAP_SLURM" # as MUNGE wants it
mkdir "$MOCAP_SLURM/etc"
# SLURM resolves no name, not even 127.0.0.1, on a host without any other address: the second one
# is of those set aside for documentation
$spaces sh -euc 'ip link set lo up; ip address add 192.0.2.1/32 dev lo
    mount --bind "$MOCAP_SLURM/etc" /etc/slurm; "$@"' sh "$@"
