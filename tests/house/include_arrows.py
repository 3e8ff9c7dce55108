#!/usr/bin/env python3
"""Checks that the modules include only the modules that the design allows them.

usage: include_arrows.py ROOT FOLDER:MODULE:ALLOWED,ALLOWED... ...

In every C++ file and shader under ROOT/FOLDER (less the folders of other rules inside it), #include "carat/X/..." must name
the module itself or an allowed one, no include may climb out of its folder with "..", and only the module vulkan may
include Vulkan's headers. Prints file:line of each offender; exit code 1 if any.
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
    if parts[0] == "vulkan" and module != "vulkan":
        return f"{module} must work without Vulkan"
    if len(parts) > 1 and parts[0] == "carat" and parts[1] not in allowed | {module}:
        return f"{module} may include {', '.join(sorted(allowed)) or 'no other module'}"
    return None


def offenders(root, folder, module, allowed, inner):
    """Lines "file:number: include: reason" for the files under folder, but not under the folders inner."""
    for path in sorted((root / folder).rglob("*")):
        if path.suffix not in SUFFIXES or any(root / other in path.parents for other in inner):
            continue
        for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
            match = INCLUDE.match(line)
            reason = match and fault(match[1], module, allowed)
            if reason:
                yield f"{path.relative_to(root)}:{number}: {match[1]}: {reason}"


def main():
    root = pathlib.Path(sys.argv[1])
    rules = [rule.split(":") for rule in sys.argv[2:]]
    found = []
    for folder, module, allowed in rules:
        if not (root / folder).is_dir():
            sys.exit(f"{root / folder} is not a folder")
        inner = [other for other, _, _ in rules if other.startswith(folder + "/")]
        found += offenders(root, folder, module, set(filter(None, allowed.split(","))), inner)
    print("\n".join(found) if found else "every include follows the arrows")
    return 1 if found else 0


sys.exit(main())
