#!/usr/bin/env bash
# distributed 2026.8.0, dask 2026.8.0, Python 3.11, Linux.
#
# Behaviour: `LocalCluster(dashboard_address=None)`, which the docstring gives to disable the dashboard, still listens on
# the dashboard's port 8787, and its `dashboard_link` names that port; a second such cluster beside it warns that the port
# is in use, and takes another. Without Bokeh there is no dashboard, only the server.
#
# The guess before: None opens no HTTP port, and two clusters without dashboards do not meet.
#
# Seen:
#   dashboard_link of a cluster without a dashboard: http://127.0.0.1:8787/status
#   HTTP status there: 404 for /status, 200 for /health
#   warnings of a second one: 1, "Port 8787 is already in use."
set -euo pipefail
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
python3 -m venv "$folder/venv"
"$folder/venv/bin/pip" --quiet --disable-pip-version-check install distributed==2026.8.0 dask==2026.8.0
"$folder/venv/bin/python" -W ignore::DeprecationWarning - <<'PYTHON'
import urllib.error
import urllib.request
import warnings

from distributed import LocalCluster

PORT = 8787


def status_of(path):
    try:
        with urllib.request.urlopen(f"http://127.0.0.1:{PORT}{path}", timeout=10) as reply:
            return reply.status
    except urllib.error.HTTPError as error:
        return error.code


WITHOUT = {"host": "127.0.0.1", "protocol": "tcp", "n_workers": 0, "dashboard_address": None}
assert "Set to ``None`` to disable the dashboard" in LocalCluster.__doc__
with LocalCluster(**WITHOUT) as cluster:
    link = cluster.dashboard_link
    print("dashboard_link of a cluster without a dashboard:", link)
    statuses = status_of("/status"), status_of("/health")
    print(f"HTTP status there: {statuses[0]} for /status, {statuses[1]} for /health")
    with warnings.catch_warnings(record=True) as seen:
        warnings.simplefilter("always")
        with LocalCluster(**WITHOUT):
            pass
    messages = [str(warning.message) for warning in seen if "already in use" in str(warning.message)]
    print(f'warnings of a second one: {len(messages)}, "{messages[0].splitlines()[0] if messages else ""}"')
assert f":{PORT}/" in link
assert statuses == (404, 200)
assert len(messages) == 1
PYTHON
