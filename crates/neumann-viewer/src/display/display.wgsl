// From linear radiance to the screen: exposure, tone curve, false colour, difference, wipe.
// The curves are those of neumann-picture's `tone`, operation for operation; a test holds them together.

struct Look {
    // Origin and size of what is shown of the left and of the right texture, texture coordinates.
    left: vec4f,
    right: vec4f,
    // Radiance per stored unit (left, right), exposure factor, place of the wipe (0 to 1 across).
    scale: vec4f,
    // Base-2 logarithms of the ends of the false-colour range; difference at the end of its scale.
    range: vec4f,
    // Row of the colour map.
    map: vec4i,
}

// What differs from one pipeline to the next. A software adapter runs every branch of a shader
// whose condition it learns only while drawing, so these are fixed when a pipeline is made.
// Tone curve, in the order of menus.
override TONE: i32 = 0;
// 0: the picture; 1: false colour; 2: the difference.
override MODE: i32 = 0;
override IS_WIPING: bool = false;
override IS_SMOOTH: bool = false;
// The target encodes sRGB itself.
override TARGET_ENCODES: bool = false;

@group(0) @binding(0) var<uniform> look: Look;
@group(0) @binding(1) var left_texture: texture_2d<f32>;
@group(0) @binding(2) var right_texture: texture_2d<f32>;
@group(0) @binding(3) var maps: texture_2d<f32>;
@group(0) @binding(4) var smoothly: sampler;

struct Corner {
    @builtin(position) position: vec4f,
    @location(0) uv: vec2f,
}

// One triangle that covers the viewport; uv runs from 0 to 1, v downwards.
@vertex
fn cover(@builtin(vertex_index) index: u32) -> Corner {
    let uv = vec2f(f32((index << 1u) & 2u), f32(index & 2u));
    return Corner(vec4f(uv.x * 2.0 - 1.0, 1.0 - uv.y * 2.0, 0.0, 1.0), uv);
}

// The nearest texel. Loaded, not sampled: OpenGL allows a texture one sampler only.
fn texel(at: vec2f, size: vec2u) -> vec2u {
    return min(vec2u(max(at, vec2f(0.0)) * vec2f(size)), size - 1u);
}

fn left_radiance(uv: vec2f) -> vec3f {
    let at = look.left.xy + uv * look.left.zw;
    if IS_SMOOTH {
        return textureSampleLevel(left_texture, smoothly, at, 0.0).rgb * look.scale.x;
    }
    return textureLoad(left_texture, texel(at, textureDimensions(left_texture)), 0).rgb * look.scale.x;
}

fn right_radiance(uv: vec2f) -> vec3f {
    let at = look.right.xy + uv * look.right.zw;
    if IS_SMOOTH {
        return textureSampleLevel(right_texture, smoothly, at, 0.0).rgb * look.scale.y;
    }
    return textureLoad(right_texture, texel(at, textureDimensions(right_texture)), 0).rgb * look.scale.y;
}

// Rec. 709.
fn luminance(c: vec3f) -> f32 {
    return 0.2126 * c.r + 0.7152 * c.g + 0.0722 * c.b;
}

fn mapped(map: i32, t: f32) -> vec3f {
    let index = i32(clamp(t, 0.0, 1.0) * 255.0 + 0.5);
    return textureLoad(maps, vec2i(index, map), 0).rgb;
}

// A matrix whose rows add up to one, without its diagonal: greys pass unchanged.
fn mixed(c: vec3f, r: vec2f, g: vec2f, b: vec2f) -> vec3f {
    return vec3f(
        c.r + r.x * (c.g - c.r) + r.y * (c.b - c.r),
        c.g + g.x * (c.r - c.g) + g.y * (c.b - c.g),
        c.b + b.x * (c.r - c.b) + b.y * (c.g - c.b),
    );
}

fn aces(x: vec3f) -> vec3f {
    let v = mixed(min(x, vec3f(1e6)), vec2f(0.35458, 0.04823), vec2f(0.07600, 0.01566), vec2f(0.02840, 0.13383));
    let a = v * (v + 0.0245786) - 0.000090537;
    let b = v * (0.983729 * v + 0.432951) + 0.238081;
    return mixed(a / b, vec2f(-0.53108, -0.07367), vec2f(-0.10208, -0.00605), vec2f(-0.00327, -0.07276));
}

fn agx(x: vec3f) -> vec3f {
    let v = mixed(x, vec2f(0.0784336, 0.079223745), vec2f(0.042328242, 0.079166127), vec2f(0.042375655, 0.0784336));
    let ev = clamp(log2(max(v, vec3f(1e-10))), vec3f(-12.47393), vec3f(4.026069));
    let t = (ev + 12.47393) / (4.026069 + 12.47393);
    let t2 = t * t;
    let t4 = t2 * t2;
    let y = 15.5 * t4 * t2 - 40.14 * t4 * t + 31.96 * t4 - 6.868 * t2 * t + 0.4298 * t2 + 0.1191 * t - 0.00232;
    let code = mixed(y, vec2f(-0.09802088, -0.099029744), vec2f(-0.05289685, -0.098961177), vec2f(-0.052971635, -0.09804345));
    return pow(max(code, vec3f(0.0)), vec3f(2.2));
}

fn neutral(x: vec3f) -> vec3f {
    let start = 0.76;
    let least = min(x.r, min(x.g, x.b));
    var offset = 0.04;
    if least < 0.08 {
        offset = least - 6.25 * least * least;
    }
    let c = x - offset;
    let peak = max(c.r, max(c.g, c.b));
    if peak < start {
        return c;
    }
    let d = 1.0 - start;
    let new_peak = 1.0 - d * d / (peak + d - start);
    let g = 1.0 - 1.0 / (0.15 * (peak - new_peak) + 1.0);
    return mix(c * (new_peak / peak), vec3f(new_peak), g);
}

fn toned(exposed: vec3f) -> vec3f {
    let x = clamp(exposed, vec3f(0.0), vec3f(1e9));
    var y = x;
    if TONE == 1 {
        y = x / (1.0 + x);
    } else if TONE == 2 {
        y = aces(x);
    } else if TONE == 3 {
        y = agx(x);
    } else if TONE == 4 {
        y = neutral(x);
    }
    return clamp(y, vec3f(0.0), vec3f(1.0));
}

fn encoded(x: vec3f) -> vec3f {
    return select(1.055 * pow(x, vec3f(1.0 / 2.4)) - 0.055, 12.92 * x, x <= vec3f(0.0031308));
}

fn decoded(x: vec3f) -> vec3f {
    return select(pow((x + 0.055) / 1.055, vec3f(2.4)), x / 12.92, x <= vec3f(0.04045));
}

@fragment
fn shade(corner: Corner) -> @location(0) vec4f {
    if MODE == 2 {
        let apart = luminance(left_radiance(corner.uv)) - luminance(right_radiance(corner.uv));
        return of_code(mapped(4, 0.5 + 0.5 * apart / look.range.z));
    }
    var radiance = left_radiance(corner.uv);
    if IS_WIPING {
        radiance = select(right_radiance(corner.uv), radiance, corner.uv.x < look.scale.w);
    }
    if MODE == 1 {
        let stops = log2(max(luminance(radiance), 1e-30));
        return of_code(mapped(look.map.x, (stops - look.range.x) / (look.range.y - look.range.x)));
    }
    let linear = toned(radiance * look.scale.z);
    if TARGET_ENCODES {
        return vec4f(linear, 1.0);
    }
    return vec4f(encoded(linear), 1.0);
}

// A colour that is sRGB-coded already.
fn of_code(code: vec3f) -> vec4f {
    if TARGET_ENCODES {
        return vec4f(decoded(code), 1.0);
    }
    return vec4f(code, 1.0);
}
