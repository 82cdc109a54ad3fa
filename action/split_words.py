"""Split a text into words as a shell does, without expanding anything, and print each with a NUL behind it."""

import shlex
import sys

try:
    words = shlex.split(sys.argv[1])
except ValueError as error:
    sys.exit(f"::error::options: {error}, in {' '.join(sys.argv[1].split())}")
sys.stdout.write("".join(f"{word}\0" for word in words))
