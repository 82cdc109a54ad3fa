#!/usr/bin/env bash
# CPython 3.11.7 (multiprocessing.resource_tracker), distributed 2026.8.0.
#
# Behaviour: a thread that blocks SIGINT and then makes a LocalCluster has it unblocked: the first process that
# multiprocessing spawns starts a resource tracker, which blocks SIGINT and SIGTERM for itself and at its end unblocks
# both, instead of restoring the mask that it found. So workers hear the Ctrl+C of the terminal, which a mask that
# processes inherit was meant to keep from them. If the tracker runs before the mask is set, the workers inherit it.
#
# The guess before: the mask stays as it was set, and all that is spawned meanwhile inherits it.
#
# Seen:
#   tracker started by the cluster: a worker has SIGINT blocked: False
#   tracker started before the mask: a worker has SIGINT blocked: True
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install distributed==2026.8.0
cat > "$folder/look.py" <<'PYTHON'
import signal
import sys
from multiprocessing import resource_tracker

from distributed import Client, LocalCluster


def is_blocked():
    for line in open("/proc/self/status"):
        if line.startswith("SigBlk:"):
            return bool(int(line.split()[1], 16) >> (signal.SIGINT - 1) & 1)


if __name__ == "__main__":
    if sys.argv[1] == "before":
        resource_tracker.ensure_running()
    signal.pthread_sigmask(signal.SIG_BLOCK, [signal.SIGINT])
    with LocalCluster(n_workers=1, threads_per_worker=1, dashboard_address=":0", silence_logs=50) as cluster:
        with Client(cluster) as client:
            # The main thread of the worker's process has the mask that the process began with.
            print(next(iter(client.run(is_blocked).values())))
PYTHON
first=$("$folder/venv/bin/python" "$folder/look.py" by_cluster)
second=$("$folder/venv/bin/python" "$folder/look.py" before)
echo "tracker started by the cluster: a worker has SIGINT blocked: $first"
echo "tracker started before the mask: a worker has SIGINT blocked: $second"
[ "$first $second" = "False True" ]
