#!/usr/bin/env python3
"""Run the C compiler, keeping objects by their preprocessed text in FREEZE_OBJECTS.

Tests compile the same files of the runtime in each process. FREEZE_LEVEL takes the place of -O2
and -O3.
"""

import hashlib
import os
import shutil
import subprocess
import sys
from pathlib import Path


def main() -> int:
    real, level = os.environ["FREEZE_CC"], os.environ.get("FREEZE_LEVEL")
    arguments = [level if level and each in ("-O2", "-O3") else each for each in sys.argv[1:]]
    if "-c" not in arguments or "-o" not in arguments or "--coverage" in arguments:
        os.execv(real, [real, *arguments])
    target = arguments[arguments.index("-o") + 1]
    plain = [each for each in arguments if each not in ("-c", "-o", target)]
    text = subprocess.run([real, *plain, "-E", "-P"], capture_output=True, check=False)
    if text.returncode != 0 or text.stderr:
        os.execv(real, [real, *arguments])
    flags = [each for each in plain if each[:2] != "-I" and each[-2:] != ".c"]
    digest = hashlib.sha1("\0".join(flags).encode() + text.stdout).hexdigest()
    kept = Path(os.environ["FREEZE_OBJECTS"]) / digest
    if not kept.exists():
        done = subprocess.run([real, *arguments], capture_output=True, check=False)
        sys.stdout.buffer.write(done.stdout)
        sys.stderr.buffer.write(done.stderr)
        if done.returncode == 0 and not done.stderr:
            own = kept.with_suffix(f".{os.getpid()}")
            shutil.copyfile(target, own)
            own.replace(kept)
        return done.returncode
    shutil.copyfile(kept, target)
    return 0


if __name__ == "__main__":
    sys.exit(main())
