# Make an environment with gpu_xform, and install lavapipe where no adapter is found.
#
# PYTHON: the Python to use. PACKAGE: what pip installs; by default the tree that this script is in, with EXTRAS.
set -euo pipefail

environment=${GPU_XFORM_ENVIRONMENT:-$RUNNER_TEMP/gpu-xform}
"$PYTHON" -m venv "$environment"
bin=$environment/bin
"$bin/pip" --quiet --disable-pip-version-check install "${PACKAGE:-$GITHUB_ACTION_PATH${EXTRAS:+[$EXTRAS]}}"

has_adapter() {
  "$bin/python" -c 'import sys, gpu_xform; sys.exit(not gpu_xform.adapters())'
}

if ! has_adapter; then
  if [ "$(id -u)" = 0 ]; then as_root=; else as_root=sudo; fi
  $as_root apt-get update -qq
  $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends mesa-vulkan-drivers libvulkan1
  has_adapter
fi
