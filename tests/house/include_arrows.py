#!/usr/bin/env python3
"""Checks that the modules include only the modules that the design allows them.

usage: include_arrows.py ROOT FOLDER:MODULE:ALLOWED,ALLOWED... ...

In every C++ file and shader under ROOT/FOLDER, a line #include "carat/X/..." must name the module itself or an allowed
one, and no quoted include may climb out of its folder with "..". Prints file:line of each offender; exit code 1 if any.
"""

import pathlib
import re
import sys

INCLUDE = re.compile(r'^\s*#\s*include\s*["<]([^">]+)[">]')
SUFFIXES = {".hpp", ".cpp", ".h", ".c", ".cc", ".inl", ".glsl", ".vert", ".frag", ".comp", ".mesh", ".task"}


def fault(included, module, allowed):
    """What is wrong with this include in this module, or None."""
    if ".." in pathlib.PurePosixPath(included).parts:
        return "climbs out of its folder"
    parts = pathlib.PurePosixPath(included).parts
    if len(parts) > 1 and parts[0] == "carat" and parts[1] not in allowed | {module}:
        return f"{module} may include {', '.join(sorted(allowed)) or 'no other module'}"
    return None


def offenders(root, folder, module, allowed):
    for path in sorted((root / folder).rglob("*")):
        if path.suffix not in SUFFIXES:
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            reason = match and fault(match[1], module, allowed)
            if reason:
                yield f"{path.relative_to(root)}:{number}: {match[1]}: {reason}"


def main():
    root = pathlib.Path(sys.argv[1])
    found = []
    for rule in sys.argv[2:]:
        folder, module, allowed = rule.split(":")
        if not (root / folder).is_dir():
            sys.exit(f"{root / folder} is not a folder")
        found += offenders(root, folder, module, set(filter(None, allowed.split(","))))
    print("\n".join(found) if found else "every include follows the arrows")
    return 1 if found else 0


sys.exit(main())
