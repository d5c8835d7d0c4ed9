"""neumann beside LuxCore: the built-in Cornell box at the same size, depth and threads, in one run.

    python luxcore_peer.py NEUMANN SCENES_FOLDER ROUNDS

Prints a table: milliseconds per sample of every pixel, by path tracing, by bidirectional path tracing and by vertex
connection and merging, and by how much the mean of LuxCore's picture differs from neumann's.

Both programs trace paths of at most ten segments, without Russian roulette. LuxCore limits the subpaths from the camera
and from the light, but not what they are joined to: BIDIRCPU and BIDIRVMCPU are given what every way to make a path of
ten segments needs, so they make longer paths too, with 2.5 times the connections, and their times include that.
The first radius is 0.003 of the scene's in both programs; LuxCore merges with 16384 light paths in each thread, neumann
with one for each pixel. Of LuxCore's samplers the random one has the least to do. With blocks of one pixel it spreads a
short run over the whole picture; with its usual ones BIDIRVMCPU leaves pixels without a sample, and so is too dark.
"""

import contextlib
import io
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

import numpy as np
from gltf import accessor, read_gltf, transform

# The module says on stdout which libraries it has found.
with contextlib.redirect_stdout(io.StringIO()):
    import pyluxcore as lux

# Edge of the picture, pixels.
SIZE = 512
SEGMENTS = 10
# neumann's method, LuxCore's, and the samples per pixel that each takes in a round.
PAIRS = [("pt-mis", "PATHCPU", 32, 16), ("bdpt", "BIDIRCPU", 6, 4), ("vcm", "BIDIRVMCPU", 4, 4)]


def properties(values):
    result = lux.Properties()
    for name, value in values.items():
        result.Set(lux.Property(name, value))
    return result


def floats(values):
    return [float(v) for v in values]


def matte(material):
    pbr = material.get("pbrMetallicRoughness", {})
    extensions = material.get("extensions", {})
    odd = set(extensions) - {"KHR_materials_emissive_strength", "KHR_materials_specular"}
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    is_lambert = specular == 0 and pbr.get("metallicFactor", 1.0) == 0 and "baseColorTexture" not in pbr
    assert is_lambert and not odd, f"material {material.get('name')}: only Lambert"
    result = {"type": "matte", "kd": floats(pbr.get("baseColorFactor", [1, 1, 1, 1])[:3])}
    strength = extensions.get("KHR_materials_emissive_strength", {}).get("emissiveStrength", 1.0)
    emission = strength * np.array(material.get("emissiveFactor", [0, 0, 0]), float)
    if emission.any():
        result["emission"] = floats(emission)
    return result


def load(path):
    """The scene for LuxCore, with its first camera."""
    doc, buffers = read_gltf(path)
    scene = lux.Scene()
    values = {}
    for i, material in enumerate(doc["materials"]):
        values |= {f"scene.materials.m{i}.{name}": value for name, value in matte(material).items()}

    def add_mesh(number, placed):
        for primitive in doc["meshes"][number]["primitives"]:
            points = accessor(doc, buffers, primitive["attributes"]["POSITION"]).astype(float)
            points = points @ placed[:3, :3].T + placed[:3, 3]
            faces = accessor(doc, buffers, primitive["indices"]).reshape(-1, 3)
            if np.linalg.det(placed[:3, :3]) < 0:
                faces = faces[:, ::-1]
            name = f"mesh{len(values)}"
            points, faces = ([tuple(row) for row in array.tolist()] for array in (points, faces))
            scene.DefineMesh(name, points, faces, None, None, None, None)
            values[f"scene.objects.{name}.shape"] = name
            values[f"scene.objects.{name}.material"] = f"m{primitive['material']}"

    def visit(number, parent):
        node = doc["nodes"][number]
        placed = parent @ transform(node)
        if "mesh" in node:
            add_mesh(node["mesh"], placed)
        if "camera" in node and "scene.camera.type" not in values:
            perspective = doc["cameras"][node["camera"]]["perspective"]
            eye, forward, up = placed[:3, 3], -placed[:3, 2], placed[:3, 1]
            values["scene.camera.type"] = "perspective"
            values["scene.camera.lookat.orig"] = floats(eye)
            values["scene.camera.lookat.target"] = floats(eye + forward)
            values["scene.camera.up"] = floats(up)
            # The picture is square, so it does not matter along which edge the angle is.
            values["scene.camera.fieldofview"] = math.degrees(perspective["yfov"])
        for child in node.get("children", []):
            visit(child, placed)

    for root in doc["scenes"][doc.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    scene.Parse(properties(values))
    return scene


class LuxCore:
    def __init__(self, scene, engine):
        self.scene = scene
        self.values = {
            "renderengine.type": engine,
            "native.threads.count": os.cpu_count(),
            "film.width": SIZE,
            "film.height": SIZE,
            "film.filter.type": "BOX",
            "film.filter.xwidth": 0.5,
            "film.filter.ywidth": 0.5,
            "film.imagepipelines.0.0.type": "NOP",
            "film.opencl.enable": False,
            "sampler.type": "RANDOM",
            "sampler.random.adaptive.strength": 0.0,
            "sampler.random.bucketsize": 1,
            "sampler.random.tilesize": 1,
            # Vertices of the subpath from the camera, of that from the light, and where roulette would begin.
            "path.maxdepth": SEGMENTS,
            "light.maxdepth": SEGMENTS - 1,
            "path.russianroulette.depth": 1000,
            "path.russianroulette.cap": 1.0,
        }
        if engine == "PATHCPU":
            # What path.maxdepth is called there.
            kinds = ("total", "diffuse", "glossy", "specular")
            self.values |= {f"path.pathdepth.{kind}": SEGMENTS for kind in kinds}

    def render(self, spp, seed):
        """The mean of the image, and the milliseconds per sample."""
        config = lux.RenderConfig(properties({**self.values, "renderengine.seed": seed}), self.scene)
        session = lux.RenderSession(config)
        session.Start()
        # The clock starts after the first sample of every pixel, so that what the program sets up is not measured.
        start = None
        while True:
            time.sleep(0.01)
            session.UpdateStats()
            stats = session.GetStats()
            done = stats.Get("stats.renderengine.total.samplecount").GetFloat() / SIZE**2
            seconds = stats.Get("stats.renderengine.time").GetFloat()
            if start is None and done >= 1:
                start = (done, seconds)
            if start is not None and done >= start[0] + spp:
                break
        session.Stop()
        image = np.zeros((SIZE, SIZE, 3), np.float32)
        session.GetFilm().GetOutputFloat(lux.FilmOutputType.RGB, image)
        return image.mean(dtype=float), (seconds - start[1]) * 1000 / (done - start[0])


class Neumann:
    def __init__(self, program, scene, method):
        self.program = program
        self.command = [program, "render", scene, "--integrator", method, "--size", f"{SIZE}x{SIZE}", "--json"]
        self.command += ["--max-bounces", str(SEGMENTS - 1), "--threads", str(os.cpu_count())]
        self.command += ["--set", "roulette=false"]
        self.render(1, 0)

    def render(self, spp, seed):
        """The mean of the image, and the milliseconds per sample."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "image.exr")
            rendered = self.run([*self.command, "--iterations", str(spp), "--seed", str(seed), "-o", path])
            compared = self.run([self.program, "compare", "--json", path, path])
        return statistics.mean(compared["mean"]), rendered["ms_per_iteration"]

    def run(self, command):
        return json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def summary(results):
    """The mean of means, and the median of times."""
    means, times = zip(*results)
    return statistics.mean(means), statistics.median(times)


def main():
    program, folder, rounds = sys.argv[1], sys.argv[2], int(sys.argv[3])
    cornell = os.path.join(folder, "cornell.glb")
    scene = load(cornell)
    print("\n| | neumann | LuxCore | neumann's advantage | LuxCore's mean |\n|---|---|---|---|---|")
    for method, engine, our_spp, their_spp in PAIRS:
        ours, theirs = Neumann(program, cornell, method), LuxCore(scene, engine)
        our_results, their_results = [], []
        # Alternating, so that whatever else the machine does meets both.
        for i in range(rounds):
            our_results.append(ours.render(our_spp, i + 1))
            their_results.append(theirs.render(their_spp, i + 1))
        our_mean, our_ms = summary(our_results)
        their_mean, their_ms = summary(their_results)
        speeds = f"{our_ms:.4g} ms/sample | {their_ms:.4g} ms/sample | {their_ms / our_ms:.2f}"
        print(f"| `{method}` against `{engine}`, cornell | {speeds} | {their_mean / our_mean - 1:+.1%} |", flush=True)


if __name__ == "__main__":
    lux.Init(lambda line: None)
    try:
        main()
    finally:
        # It must not call back into an interpreter that has ended.
        lux.SetLogHandler(None)
