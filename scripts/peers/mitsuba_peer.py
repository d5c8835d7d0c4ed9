"""neumann beside Mitsuba 3: the same scenes, size, depth and threads, in one run.

    python mitsuba_peer.py NEUMANN SCENES_FOLDER ROUNDS [SCENE[:METHOD]...]

Prints a table. SCENE is the name of a built-in scene, or a .gltf or .glb file; without any, speeds are compared first, and
then a few built-in scenes. Files are read by the few lines below, which understand what the built-in scenes use (Lambert,
mirrors, rough metal, smooth glass, emission) and metal-rough materials with a texture of base colour, for which Mitsuba's
principled BSDF stands in. A scene without a camera is seen as neumann sees it, one without lights under a white sky.

Both programs trace paths of at most ten segments; speeds are compared without Russian roulette, times to an error with
each program's own default for it. METHOD is one of neumann's, pt-mis if none is named; Mitsuba's is always path.

Times to an error are given for two of Mitsuba's samplers: `independent`, which it takes by default, and `multijitter`, which
stratifies all samples of a render together. The latter is asked for counts that it does not round up, all in one render.
"""

import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
import time

import mitsuba as mi
import numpy as np
from gltf import accessor, read_gltf, resource, transform

mi.set_variant("llvm_ad_rgb")
# It warns of counts that are rounded, which `exact` asks for, and of renders in several passes.
mi.set_log_level(mi.LogLevel.Error)
import drjit as dr  # noqa: E402  (needs the variant)

# Edge of the picture, pixels: where speed is compared, and where error is.
SIZE_FOR_SPEED = 512
SIZE_FOR_ERROR = 256
SEGMENTS = 10
TARGET = 1e-3
# Samples of the image that errors are relative to, and the most that are taken on the way to the target.
REFERENCE = 1024
MOST_SAMPLES = 512
SAMPLERS = ("independent", "multijitter")
# Samples per pixel in one wavefront at most, as wavefronts take memory.
MOST_AT_ONCE = 64
# Seconds of rest before a measurement: the threads of the one before spin for a while after their last task.
REST = 0.3


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values[:3]]}


def bitmap(path, doc, buffers, index):
    """A texture of colours, as Mitsuba reads it."""
    image = doc["images"][doc["textures"][index]["source"]]
    if "uri" in image:
        data = resource(path, image["uri"])
    else:
        view = doc["bufferViews"][image["bufferView"]]
        start = view.get("byteOffset", 0)
        data = buffers[view["buffer"]][start : start + view["byteLength"]]
    with tempfile.NamedTemporaryFile(suffix=".png" if data[:4] == b"\x89PNG" else ".jpg") as file:
        file.write(data)
        file.flush()
        return {"type": "bitmap", "bitmap": mi.Bitmap(file.name)}


KNOWN = {
    "KHR_materials_emissive_strength",
    "KHR_materials_ior",
    "KHR_materials_specular",
    "KHR_materials_transmission",
    "KHR_materials_volume",
}


def bsdf(path, doc, buffers, material):
    pbr = material.get("pbrMetallicRoughness", {})
    extensions = material.get("extensions", {})
    base = pbr.get("baseColorFactor", [1, 1, 1, 1])
    roughness = pbr.get("roughnessFactor", 1.0)
    texture = pbr.get("baseColorTexture")
    odd = set(extensions) - KNOWN
    assert "attenuationColor" not in extensions.get("KHR_materials_volume", {}), "only clear glass"
    assert not odd and "normalTexture" not in material, f"material {material.get('name')}: {odd or 'normal texture'}"
    if texture is not None:
        assert "metallicRoughnessTexture" not in pbr and base[:3] == [1, 1, 1], "only textures of base colour"
        color = bitmap(path, doc, buffers, texture["index"])
        metallic = pbr.get("metallicFactor", 1.0)
        b = {"type": "principled", "base_color": color, "metallic": metallic, "roughness": roughness, "specular": 0.5}
        return {"type": "twosided", "b": b}
    if extensions.get("KHR_materials_transmission", {}).get("transmissionFactor", 0) == 1:
        ior = extensions.get("KHR_materials_ior", {}).get("ior", 1.5)
        assert roughness == 0 and min(base[:3]) == 1, "only clear, smooth glass"
        return {"type": "dielectric", "int_ior": ior, "ext_ior": 1.0}
    if pbr.get("metallicFactor", 1.0) == 1:
        # Perfectly reflecting: base colour 1 at every angle.
        assert min(base[:3]) == 1, "only white metal"
        if roughness == 0:
            return {"type": "twosided", "b": {"type": "conductor", "material": "none"}}
        metal = {"type": "roughconductor", "material": "none", "distribution": "ggx", "alpha": roughness**2}
        return {"type": "twosided", "b": metal}
    specular = extensions.get("KHR_materials_specular", {}).get("specularFactor", 1.0)
    assert specular == 0, f"material {material.get('name')}: only Lambert, metal and glass"
    return {"type": "twosided", "b": {"type": "diffuse", "reflectance": rgb(base)}}


def look_at(program, path):
    """The camera that neumann gives to a scene without one: eye, target, vertical angle of view in degrees."""
    run = subprocess.run([program, "info", "--json", path], check=True, capture_output=True, text=True)
    info = json.loads(run.stdout)
    camera, bounds = info["cameras"][0], info["bounds"]
    target = [(low + high) / 2 for low, high in zip(bounds["min"], bounds["max"])]
    return camera["eye"], target, camera["fov_degrees"]


def load(path, size, view=None, sampler="independent"):
    """The scene for Mitsuba, with its first camera or with `view`, and one of its samplers."""
    doc, buffers = read_gltf(path)
    scene = {"type": "scene"}
    materials = doc.get("materials", [])

    def add_sensor(eye, target, up, fov):
        scene["sensor"] = {
            "type": "perspective",
            "fov": fov,
            "fov_axis": "y",
            "to_world": mi.ScalarTransform4f().look_at(origin=eye, target=target, up=up),
            "film": {
                "type": "hdrfilm",
                "width": size,
                "height": size,
                "rfilter": {"type": "box"},
                "pixel_format": "rgb",
            },
            "sampler": {"type": sampler},
        }

    is_lit = False

    def add_mesh(number, placed):
        nonlocal is_lit
        for i, primitive in enumerate(doc["meshes"][number]["primitives"]):
            attributes = primitive["attributes"]
            points = accessor(doc, buffers, attributes["POSITION"]).astype(float)
            points = points @ placed[:3, :3].T + placed[:3, 3]
            indices = accessor(doc, buffers, primitive["indices"]) if "indices" in primitive else np.arange(len(points))
            faces = indices.reshape(-1, 3)
            if np.linalg.det(placed[:3, :3]) < 0:
                faces = faces[:, ::-1]
            material = materials[primitive["material"]]
            properties = mi.Properties()
            properties["bsdf"] = mi.load_dict(bsdf(path, doc, buffers, material))
            emission = np.array(material.get("emissiveFactor", [0, 0, 0]), float)
            strength = material.get("extensions", {}).get("KHR_materials_emissive_strength", {})
            emission *= strength.get("emissiveStrength", 1.0)
            if emission.any():
                is_lit = True
                properties["emitter"] = mi.load_dict({"type": "area", "radiance": rgb(emission)})
            has_normals = "NORMAL" in attributes
            has_uvs = "TEXCOORD_0" in attributes
            mesh = mi.Mesh(
                f"m{len(scene)}",
                len(points),
                len(faces),
                has_vertex_normals=has_normals,
                has_vertex_texcoords=has_uvs,
                props=properties,
            )
            parameters = mi.traverse(mesh)
            parameters["vertex_positions"] = points.astype(np.float32).ravel()
            parameters["faces"] = faces.astype(np.uint32).ravel()
            if has_normals:
                normals = accessor(doc, buffers, attributes["NORMAL"]).astype(float)
                normals = normals @ np.linalg.inv(placed[:3, :3])
                normals /= np.linalg.norm(normals, axis=1, keepdims=True)
                parameters["vertex_normals"] = normals.astype(np.float32).ravel()
            if has_uvs:
                uvs = accessor(doc, buffers, attributes["TEXCOORD_0"])
                parameters["vertex_texcoords"] = uvs.astype(np.float32).ravel()
            parameters.update()
            scene[f"mesh_{len(scene)}_{i}"] = mesh

    def visit(number, parent):
        node = doc["nodes"][number]
        placed = parent @ transform(node)
        if "mesh" in node:
            add_mesh(node["mesh"], placed)
        if "camera" in node and "sensor" not in scene:
            perspective = doc["cameras"][node["camera"]]["perspective"]
            eye, forward, up = placed[:3, 3], -placed[:3, 2], placed[:3, 1]
            add_sensor(eye, eye + forward, up, math.degrees(perspective["yfov"]))
        for child in node.get("children", []):
            visit(child, placed)

    for root in doc["scenes"][doc.get("scene", 0)]["nodes"]:
        visit(root, np.eye(4))
    if "sensor" not in scene:
        eye, target, fov = view
        add_sensor(eye, target, [0, 1, 0], fov)
    if not is_lit:
        scene["sky"] = {"type": "constant", "radiance": rgb([1, 1, 1])}
    return mi.load_dict(scene)


class Mitsuba:
    def __init__(self, scene, kind="path", rr_depth=5, sampler="independent"):
        self.scene = scene
        self.options = {"type": kind, "max_depth": SEGMENTS, "rr_depth": rr_depth}
        self.is_stratified = sampler != "independent"
        self.render(self.exact(4), 0)

    def exact(self, spp):
        """The least number of samples per pixel, from `spp` on, that the sampler does not round up."""
        sampler = self.scene.sensors()[0].sampler()
        while True:
            sampler.set_sample_count(spp)
            if sampler.sample_count() == spp:
                return spp
            spp = sampler.sample_count()

    def render(self, spp, seed):
        """The image, and the seconds it took. Samples that are stratified together are of one render, in several passes."""
        part = spp if self.is_stratified else MOST_AT_ONCE
        image, done, seconds = 0, 0, 0
        while done < spp:
            n = min(part, spp - done)
            at_once = next(k for k in range(min(n, MOST_AT_ONCE), 0, -1) if n % k == 0)
            passes = {"samples_per_pass": at_once} if at_once < n else {}
            integrator = mi.load_dict({**self.options, **passes})
            start = time.time()
            rendered = mi.render(self.scene, integrator=integrator, spp=n, seed=seed * 1000 + done)
            dr.eval(rendered)
            dr.sync_thread()
            seconds += time.time() - start
            image = image + np.array(rendered)[..., :3] * n
            done += n
        return image / spp, seconds


class Neumann:
    def __init__(self, program, scene, size, method="pt-mis", options=()):
        self.command = [program, "render", scene, "--integrator", method, "--size", f"{size}x{size}"]
        self.command += ["--max-bounces", str(SEGMENTS - 1), "--threads", str(os.cpu_count()), "--json", *options]
        self.render(1, 0)

    def exact(self, spp):
        return spp

    def render(self, spp, seed):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "image.exr")
            command = [*self.command, "--iterations", str(spp), "--seed", str(seed), "-o", path]
            run = subprocess.run(command, check=True, capture_output=True, text=True)
            return read_exr(path), json.loads(run.stdout)["ms_per_iteration"] * spp / 1000


def read_exr(path):
    for name, layer in mi.Bitmap(path).split():
        if name in ("", "<root>", "root"):
            return np.array(layer.convert(mi.Bitmap.PixelFormat.RGB, mi.Struct.Type.Float32, False), float)
    raise ValueError(f"{path}: no layer of its own")


def per_sample(programs, spp, rounds):
    """Median milliseconds per sample of each, in turn."""
    times = {name: [] for name in programs}
    for i in range(rounds):
        for name, program in programs.items():
            n = program.exact(spp.get(name, 16))
            time.sleep(REST)
            times[name].append(program.render(n, i + 1)[1] * 1000 / n)
    return {name: statistics.median(t) for name, t in times.items()}


def relative_error(program, n, seed, mean):
    """relMSE of n samples per pixel: half the mean squared difference of two renders, which needs no exact image."""
    a, b = (program.render(n, 2 * seed + i)[0] for i in (0, 1))
    return float((0.5 * (a - b) ** 2 / (mean**2 + 1e-2)).mean())


def samples_to_target(program, mean):
    """Samples per pixel until the error is the target, between two renders that enclose it, or, where that takes too
    long, from the last one, the error going down in proportion to the number of samples."""
    before, n = None, program.exact(8)
    while True:
        error = relative_error(program, n, n, mean)
        if error <= TARGET:
            break
        if n >= MOST_SAMPLES:
            return n * error / TARGET
        before, n = (n, error), program.exact(n * 2)
    if before is None:
        return n * error / TARGET
    slope = math.log(error / before[1]) / math.log(n / before[0])
    return before[0] * math.exp(math.log(TARGET / before[1]) / slope)


def row(what, ours, theirs, ratio, unit):
    print(f"| {what} | {ours:.4g} {unit} | {theirs:.4g} {unit} | {ratio:.2f} |", flush=True)


def main():
    program, folder, rounds = sys.argv[1], sys.argv[2], int(sys.argv[3])
    scenes = sys.argv[4:]
    print("\n| | neumann | Mitsuba | neumann's advantage |\n|---|---|---|---|")
    if not scenes:
        compare_speeds(program, os.path.join(folder, "cornell.glb"), rounds)
    # The same method as Mitsuba's, and where that is not the one for the scene, the one that is.
    for name in scenes or ["cornell", "cornell-glass", "cornell-glass:bdpt", "plates", "many"]:
        name, _, method = name.partition(":")
        path = name if "." in name else os.path.join(folder, f"{name}.glb")
        compare_times_to_error(program, path, rounds, method or "pt-mis")


def compare_speeds(program, cornell, rounds):
    size = SIZE_FOR_SPEED
    scene = load(cornell, size)
    no_roulette = ("--set", "roulette=false")
    programs = {
        "path": Mitsuba(scene, rr_depth=1000),
        "ptracer": Mitsuba(scene, "ptracer", 1000),
        "pt-mis": Neumann(program, cornell, size, "pt-mis", no_roulette),
        "lt": Neumann(program, cornell, size, "lt", no_roulette),
        "bdpt": Neumann(program, cornell, size, "bdpt"),
        "vcm": Neumann(program, cornell, size, "vcm"),
    }
    ms = per_sample(programs, {"path": 32, "ptracer": 32, "bdpt": 6, "vcm": 4}, rounds)
    unit = "ms/sample"
    row("`pt-mis` against `path`, cornell", ms["pt-mis"], ms["path"], ms["path"] / ms["pt-mis"], unit)
    row("`lt` against `ptracer`, cornell", ms["lt"], ms["ptracer"], ms["ptracer"] / ms["lt"], unit)
    row("`bdpt` against `path`, cornell", ms["bdpt"], ms["path"], ms["path"] / ms["bdpt"], unit)
    row("`vcm` against `path`, cornell", ms["vcm"], ms["path"], ms["path"] / ms["vcm"], unit)


def is_lit(doc):
    emits = any(any(m.get("emissiveFactor", [0])) for m in doc.get("materials", []))
    return emits or "KHR_lights_punctual" in doc.get("extensionsUsed", [])


def compare_times_to_error(program, path, rounds, method):
    name = os.path.splitext(os.path.basename(path))[0]
    options, view = [], None
    doc = read_gltf(path)[0]
    if not is_lit(doc):
        options += ["--env", "uniform"]
    if "cameras" not in doc:
        view = look_at(program, path)
        eye, target = (",".join(map(str, point)) for point in view[:2])
        options += [f"--eye={eye}", f"--target={target}", f"--fov={view[2]}"]
    programs = {"ours": Neumann(program, path, SIZE_FOR_ERROR, method, options)}
    for sampler in SAMPLERS:
        programs[sampler] = Mitsuba(load(path, SIZE_FOR_ERROR, view, sampler), sampler=sampler)
    mean = programs["ours"].render(REFERENCE, 4711)[0]
    check = programs["independent"].render(REFERENCE // 4, 1)[0].mean() / mean.mean()
    if abs(check - 1) > 0.02:
        print(f"{name}: the programs do not render the same scene; means differ by {check:.3f}", file=sys.stderr)
    ms = per_sample(programs, dict.fromkeys(SAMPLERS, 32), rounds)
    seconds = {key: samples_to_target(program, mean) * ms[key] / 1000 for key, program in programs.items()}
    for sampler in SAMPLERS:
        what = f"time to relMSE {TARGET:g}, {name}, `{method}` against `path` with `{sampler}`"
        row(what, seconds["ours"], seconds[sampler], seconds[sampler] / seconds["ours"], "s")


if __name__ == "__main__":
    main()
