"""`python -m gpu_xform` is the command `gpu-xform`."""

import sys

from .cli import main

if __name__ == "__main__":
    sys.exit(main())
