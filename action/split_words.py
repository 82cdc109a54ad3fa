"""Split a text into words as a shell does, without expanding anything, and print each with a NUL behind it."""

import shlex
import sys

sys.stdout.write("".join(f"{word}\0" for word in shlex.split(sys.argv[1])))
