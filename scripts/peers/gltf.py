"""Reads what neumann's peers need of a glTF file: its JSON, its buffers, arrays of numbers and places of nodes."""

import base64
import json
import os
import struct
import urllib.parse

import numpy as np


def read_gltf(path):
    """The JSON and the bytes of each buffer."""
    raw = open(path, "rb").read()
    blob = b""
    if raw[:4] == b"glTF":
        (n,) = struct.unpack_from("<I", raw, 12)
        doc, blob = json.loads(raw[20 : 20 + n]), raw[28 + n :]
    else:
        doc = json.loads(raw)
    return doc, [resource(path, buffer["uri"]) if "uri" in buffer else blob for buffer in doc.get("buffers", [])]


def resource(path, uri):
    if uri.startswith("data:"):
        return base64.b64decode(uri.split(",", 1)[1])
    return open(os.path.join(os.path.dirname(path), urllib.parse.unquote(uri)), "rb").read()


def accessor(doc, buffers, index):
    a = doc["accessors"][index]
    view = doc["bufferViews"][a["bufferView"]]
    kind = {5126: "<f4", 5125: "<u4", 5123: "<u2", 5121: "u1"}[a["componentType"]]
    width = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4}[a["type"]]
    item = np.dtype(kind).itemsize * width
    start = view.get("byteOffset", 0) + a.get("byteOffset", 0)
    strides = (view.get("byteStride", item), np.dtype(kind).itemsize)
    return np.ndarray((a["count"], width), kind, buffers[view["buffer"]], start, strides).copy()


def transform(node):
    if "matrix" in node:
        return np.array(node["matrix"], float).reshape(4, 4).T
    m = np.eye(4)
    x, y, z, w = node.get("rotation", [0, 0, 0, 1])
    m[:3, :3] = [
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)],
    ]
    m[:3, :3] *= np.array(node.get("scale", [1, 1, 1]))
    m[:3, 3] = node.get("translation", [0, 0, 0])
    return m
