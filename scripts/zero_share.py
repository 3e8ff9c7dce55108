#!/usr/bin/env python3
"""How many in a thousand of a raster's samples are exactly 0, of 512 x 512 evenly over it, for scripts/demo.

usage: zero_share.py RASTER

Many elevation models of land (SRTM, Copernicus GLO-30) hold 0 for the sea. Coded to within a tolerance it comes out a
little above 0 here and a little below there: neither land nor water.
"""

import array
import os
import subprocess
import sys
import tempfile


def zero_share(raster):
    with tempfile.TemporaryDirectory() as folder:
        out = os.path.join(folder, "sample")
        subprocess.run(
            ["gdal_translate", "-q", "-b", "1", "-ot", "Float64", "-outsize", "512", "512", "-r", "nearest", "-of", "ENVI", raster, out],
            check=True,
        )
        samples = array.array("d")
        with open(out, "rb") as file:
            samples.frombytes(file.read())
    return samples.count(0.0) / len(samples)


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(round(1000 * zero_share(sys.argv[1])))
