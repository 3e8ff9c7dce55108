#!/usr/bin/env python3
"""Chooses views of a .carat file, and a flight, for scripts/demo.

usage: demo_views.py CARAT FILE BODY FLIGHT.json LAYER...     LAYER: the sources, coarsest first

Prints one view a line, its name and then the options of carat render: the whole globe from two sides and from above both
poles, then for each regional layer an oblique view of all of it and one from low over its middle, then the named places
of the body that the file knows finely enough: those of docs/gallery.md among them. Ground heights are asked from the file,
through carat query. FLIGHT.json becomes the path, for carat fly, of a descent from space to the last of these views.
"""

import dataclasses
import json
import math
import subprocess
import sys

RADIUS = {"earth": 6371000.0, "moon": 1737400.0, "mars": 3389500.0}

# name, latitude, longitude, heading, distance and height above ground of the eye in metres, coarsest useful spacing in metres,
# the sun's azimuth relative to the heading and elevation in degrees
PLACES = {
    "earth": [
        ("himalaya", 27.99, 86.93, 15, 350e3, 120e3, 5e3, 285, 24),
        ("andes", -32.65, -70.01, 80, 350e3, 110e3, 5e3, 285, 24),
    ],
    "moon": [("tycho", -43.3, -11.2, 10, 250e3, 90e3, 8e3, 285, 24)],
}

# name, place that must be known, coarsest useful spacing in metres there; then the eye's latitude, longitude and height, heading,
# pitch and angle of view; then how it is lit, besides the light of the body where there is any.
FROM_ORBIT = ["--relief=3", "--detail", "--tone=aces", "--exposure=1.6", "--supersample=2"]
AT_WHITNEY = ["--sun=110,30", "--sky", "--tone=aces", "--exposure=1.4"]
GALLERY = {
    "earth": [
        ("whitney-1", (36.58, -118.29), 500, 36.50, -118.29, 6500, 20, -35, 45, AT_WHITNEY),
        ("whitney-2", (36.58, -118.29), 500, 36.565, -118.29, 4700, 20, -20, 45, AT_WHITNEY),
        ("whitney-1-detail", (36.58, -118.29), 500, 36.50, -118.29, 6500, 20, -35, 45, AT_WHITNEY + ["--detail"]),
        ("whitney-2-detail", (36.58, -118.29), 500, 36.565, -118.29, 4700, 20, -20, 45, AT_WHITNEY + ["--detail"]),
        ("sierra-nevada-sunset", (36.58, -118.29), 500, 36.70, -117.98, 5200, 245, -7, 45,
         ["--sun=310,8", "--sky", "--water", "--shadows", "--tone=aces", "--exposure=2.5"]),
    ],
    "mars": [
        ("valles-marineris", (-10, -70), 40e3, -18, -62, 400e3, 307, -34, 38, ["--sun=50,30", *FROM_ORBIT]),
        ("olympus-mons", (18.65, -133.8), 40e3, 8.5, -139.5, 300e3, 30, -28, 32, ["--sun=280,25", *FROM_ORBIT]),
    ],
}

FROM_SPACE = ["--sun=290,50"]
# What the light of a body wants, besides the sun.
LIGHT = {
    "earth": ["--sky", "--water", "--tone=aces"],
    "mars": ["--tone=aces"],  # through its dust the relief is gone
}


@dataclasses.dataclass
class View:
    name: str
    lat: float  # of the eye, degrees
    lon: float
    height: float  # metres above the ellipsoid
    heading: float = 0
    pitch: float = -90
    fov: float = 50
    look: tuple = ()  # further options of carat render

    def options(self):
        eye = f"--eye={self.lat:.6f},{self.lon:.6f},{self.height:.1f}"
        angles = f"--heading={self.heading:.1f} --pitch={self.pitch:.2f} --fov={self.fov}"
        return " ".join([self.name, eye, angles, *self.look])

    def keyframe(self, time):
        angles = {"heading": self.heading, "pitch": self.pitch, "fov": self.fov}
        return {"time": time, "lat": self.lat, "lon": self.lon, "height": self.height, **angles}


class Planet:
    def __init__(self, carat, file, body):
        self.carat, self.file = carat, file
        self.radius = RADIUS.get(body, RADIUS["earth"])
        self.light = LIGHT.get("earth" if body == "synthetic" else body, [])

    def exposed(self, exposure):
        """The light's options; where air dims the sun, brighter by a factor."""
        return self.light + ([f"--exposure={exposure}"] if self.light else [])

    def query(self, places):
        """[(height, spacing)] in metres at [(latitude, longitude)]."""
        lines = "".join(f"{lat!r},{lon!r}\n" for lat, lon in places)
        command = [self.carat, "query", self.file, "--points", "-", "--no-header"]
        done = subprocess.run(command, input=lines, text=True, stdout=subprocess.PIPE, check=True)
        return [tuple(map(float, line.split(",")[2:4])) for line in done.stdout.splitlines()]

    def away(self, lat, lon, bearing, distance):
        """The place at a distance along the great circle that leaves lat, lon with a bearing (degrees)."""
        angle, b = distance / self.radius, math.radians(bearing)
        p, l = math.radians(lat), math.radians(lon)
        q = math.asin(math.sin(p) * math.cos(angle) + math.cos(p) * math.sin(angle) * math.cos(b))
        m = l + math.atan2(math.sin(b) * math.sin(angle) * math.cos(p), math.cos(angle) - math.sin(p) * math.sin(q))
        return math.degrees(q), (math.degrees(m) + 540) % 360 - 180

    def look_at(self, name, lat, lon, heading, distance, height, sun=285, elevation=24):
        """A view from behind the place, the eye so high above both grounds, the place in the middle."""
        eye = self.away(lat, lon, heading + 180, distance)
        (ground, _), (below, _) = self.query([(lat, lon), eye])
        eye_height = max(ground, below) + height
        drop = eye_height - ground + distance**2 / (2 * self.radius)
        light = [f"--sun={(heading + sun) % 360:.0f},{elevation}"] + self.exposed(2.5)
        pitch = -math.degrees(math.atan2(drop, distance))
        return View(name, *eye, eye_height, heading, pitch, look=tuple(light))

    def from_space(self, name, lat, lon, height, fov):
        """A view straight down; height in radii."""
        return View(name, lat, lon, height * self.radius, fov=fov, look=tuple(FROM_SPACE + self.exposed(1.5) + ["--relief=3"]))


@dataclasses.dataclass
class Region:
    """Where a raster lies: its middle and its height in degrees, its rows, whether it spans more than half the globe."""

    name: str
    lat: float
    lon: float
    span: float
    rows: int
    is_global: bool

    @staticmethod
    def of(layer):
        info = json.loads(subprocess.run(["gdalinfo", "-json", layer], text=True, stdout=subprocess.PIPE, check=True).stdout)
        if "wgs84Extent" in info:
            ring = info["wgs84Extent"]["coordinates"][0]
        else:
            ring = [info["cornerCoordinates"][corner] for corner in ("upperLeft", "lowerLeft", "lowerRight", "upperRight")]
        lons, lats = [p[0] for p in ring], [p[1] for p in ring]
        name = layer.rsplit("/", 1)[-1].rsplit(".", 1)[0]
        middle = (min(lats) + max(lats)) / 2, (min(lons) + max(lons)) / 2
        return Region(name, *middle, max(lats) - min(lats), info["size"][1], max(lons) - min(lons) > 180)


def space_views(planet, lon):
    return [
        planet.from_space("globe", 15, lon, 2.6, 36),
        planet.from_space("globe-far-side", 15, (lon + 360) % 360 - 180, 2.6, 36),
        planet.from_space("north-pole", 89.9, 0, 0.6, 60),
        planet.from_space("south-pole", -89.9, 0, 0.6, 60),
    ]


def region_views(planet, region):
    size = math.radians(region.span) * planet.radius
    spacing = size / region.rows
    return [
        planet.look_at(region.name + "-oblique", region.lat, region.lon, 340, 0.9 * size, 0.4 * size),
        planet.look_at(region.name + "-low", region.lat, region.lon, 20, 100 * spacing, 20 * spacing),
    ]


def main():
    carat, file, body, flight, layers = sys.argv[1], sys.argv[2], sys.argv[3], sys.argv[4], sys.argv[5:]
    planet = Planet(carat, file, body)
    regions = [region for region in map(Region.of, layers) if not region.is_global]

    views = space_views(planet, regions[0].lon if regions else -100.0)
    for region in regions:
        views += region_views(planet, region)
    for name, lat, lon, heading, distance, height, needed, sun, elevation in PLACES.get(body, []):
        if planet.query([(lat, lon)])[0][1] <= needed:
            views.append(planet.look_at(name, lat, lon, heading, distance, height, sun, elevation))
    for name, place, needed, *eye, look in GALLERY.get(body, []):
        if planet.query([place])[0][1] <= needed:
            views.append(View(name, *eye, look=tuple(look)))
    print("\n".join(view.options() for view in views))

    goal = views[-1]
    start = planet.from_space("start", goal.lat, goal.lon - 40, 1.5, goal.fov)
    with open(flight, "w", encoding="utf-8") as out:
        json.dump([start.keyframe(0), goal.keyframe(8)], out, indent=1)


main()
