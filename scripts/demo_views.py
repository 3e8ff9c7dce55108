#!/usr/bin/env python3
"""Chooses views of a .carat file for scripts/demo.

usage: demo_views.py CARAT FILE BODY LAYER...     LAYER: the sources, coarsest first

Prints one view a line, its name and then the options of carat render: the whole globe from two sides and from above both
poles, then for each regional layer an oblique view of all of it and one from low over its middle, then the named places
of the body that the file knows finely enough. Ground heights are asked from the file, through carat query.
"""

import json
import math
import subprocess
import sys

RADIUS = {"earth": 6371000.0, "moon": 1737400.0, "mars": 3389500.0}

# name, latitude, longitude, heading, distance and height above ground of the eye in metres, coarsest useful spacing in metres
PLACES = {
    "earth": [
        ("himalaya", 27.99, 86.93, 15, 350e3, 120e3, 20e3),
        ("andes", -32.65, -70.01, 80, 350e3, 110e3, 20e3),
        ("sierra-nevada", 36.5785, -118.292, 265, 22e3, 2000, 500),
    ],
    "moon": [("tycho", -43.3, -11.2, 10, 250e3, 90e3, 8e3)],
    "mars": [
        ("olympus-mons", 18.65, -133.8, 330, 900e3, 300e3, 40e3),
        ("valles-marineris", -13.9, -59.2, 285, 600e3, 150e3, 40e3),
    ],
    "synthetic": [],
}


# From space a pixel of error is tens of kilometres, more than any relief: ask for enough detail to colour each pixel, and
# shade slopes more than they are.
FROM_SPACE = ["--error=0.05", "--relief=6", "--sun=290,55"]
SKY = ["--background=142,176,214"]


class Planet:
    def __init__(self, carat, file, body):
        self.carat, self.file = carat, file
        self.radius = RADIUS.get(body, RADIUS["earth"])
        self.sky = SKY if body in ("earth", "synthetic") else []

    def query(self, places):
        """[(height, spacing)] in metres at [(latitude, longitude)]."""
        lines = "".join(f"{lat!r},{lon!r}\n" for lat, lon in places)
        done = subprocess.run(
            [self.carat, "query", self.file, "--points", "-"], input=lines, text=True, stdout=subprocess.PIPE, check=True
        )
        rows = [line.split(",") for line in done.stdout.splitlines() if line and not line.startswith("lat")]
        return [(float(row[2]), float(row[3])) for row in rows]

    def away(self, lat, lon, bearing, distance):
        """The place at a distance along the great circle that leaves lat, lon with a bearing (degrees)."""
        angle, b = distance / self.radius, math.radians(bearing)
        p, l = math.radians(lat), math.radians(lon)
        q = math.asin(math.sin(p) * math.cos(angle) + math.cos(p) * math.sin(angle) * math.cos(b))
        m = l + math.atan2(math.sin(b) * math.sin(angle) * math.cos(p), math.cos(angle) - math.sin(p) * math.sin(q))
        return math.degrees(q), (math.degrees(m) + 540) % 360 - 180

    def look_at(self, name, lat, lon, heading, distance, height):
        """A view from behind the place, the eye so high above both grounds, the place in the middle."""
        eye = self.away(lat, lon, heading + 180, distance)
        (ground, _), (below, _) = self.query([(lat, lon), eye])
        eye_height = max(ground, below) + height
        drop = eye_height - ground + distance**2 / (2 * self.radius)
        light = [f"--sun={(heading + 285) % 360:.0f},24"] + (self.sky if eye_height < 30e3 else [])
        return view(name, *eye, eye_height, heading, -math.degrees(math.atan2(drop, distance)), 50, ["--error=0.7", *light])


def view(name, lat, lon, height, heading, pitch, fov, more):
    eye = f"--eye={lat:.6f},{lon:.6f},{height:.1f}"
    return " ".join([name, eye, f"--heading={heading:.1f}", f"--pitch={pitch:.2f}", f"--fov={fov}", *more])


def extent(layer):
    """Latitude and longitude of a raster's middle, its height in degrees of latitude and in rows, and whether it spans more
    than half the globe."""
    info = json.loads(subprocess.run(["gdalinfo", "-json", layer], text=True, stdout=subprocess.PIPE, check=True).stdout)
    if "wgs84Extent" in info:
        ring = info["wgs84Extent"]["coordinates"][0]
    else:
        corners = info["cornerCoordinates"]
        ring = [corners[name] for name in ("upperLeft", "lowerLeft", "lowerRight", "upperRight")]
    lons, lats = [p[0] for p in ring], [p[1] for p in ring]
    return (
        (min(lats) + max(lats)) / 2,
        (min(lons) + max(lons)) / 2,
        max(lats) - min(lats),
        info["size"][1],
        max(lons) - min(lons) > 180,
    )


def main():
    carat, file, body, layers = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4:]
    planet = Planet(carat, file, body)
    regions = [(layer, *extent(layer)) for layer in layers]
    regions = [r for r in regions if not r[5]]
    middle = regions[0][2] if regions else 10.0
    far = 2.6 * planet.radius

    views = [
        view("globe", 15, middle, far, 0, -90, 36, FROM_SPACE),
        view("globe-far-side", 15, (middle + 360) % 360 - 180, far, 0, -90, 36, FROM_SPACE),
        view("north-pole", 89.9, 0, 0.6 * planet.radius, 0, -90, 60, FROM_SPACE),
        view("south-pole", -89.9, 0, 0.6 * planet.radius, 0, -90, 60, FROM_SPACE),
    ]
    for layer, lat, lon, span, rows, _ in regions:
        name = layer.rsplit("/", 1)[-1].rsplit(".", 1)[0]
        size = math.radians(span) * planet.radius
        spacing = size / rows
        views.append(planet.look_at(name + "-oblique", lat, lon, 340, 0.9 * size, 0.4 * size))
        views.append(planet.look_at(name + "-low", lat, lon, 20, 100 * spacing, 20 * spacing))
    for name, lat, lon, heading, distance, height, needed in PLACES.get(body, []):
        if planet.query([(lat, lon)])[0][1] <= needed:
            views.append(planet.look_at(name, lat, lon, heading, distance, height))
    print("\n".join(views))


main()
